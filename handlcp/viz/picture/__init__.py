"""The picture of a grasp."""
