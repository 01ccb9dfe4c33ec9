"""The design of a hand itself: hands made of numbers, what they must do, and how well they do it."""
