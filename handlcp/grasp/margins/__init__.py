"""How far a grasp is from failing, and the classic tests of closure."""
