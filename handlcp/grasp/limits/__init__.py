"""How much load a grasp holds, and what gives out first."""
