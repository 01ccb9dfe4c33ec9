"""What parameters change in the laws of a grasp, a kind of them a file."""
