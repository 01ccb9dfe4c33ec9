"""The design of a hand itself: what it must do, and how well it does it."""
