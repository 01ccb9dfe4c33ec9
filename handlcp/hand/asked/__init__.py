"""What is asked of a hand's grasp, as it was given, and the specification made of it."""
