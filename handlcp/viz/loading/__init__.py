"""The figure of a grasp followed through its loading, and the picture of the hand where it ends."""
