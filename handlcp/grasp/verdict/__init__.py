"""Does it hold? The verdict on a grasp that is squeezed and loaded in steps, and what would help."""
