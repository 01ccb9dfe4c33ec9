"""A sweep to look at: its front, what matters, and the hands on the front."""
