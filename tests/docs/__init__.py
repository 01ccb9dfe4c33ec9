"""The README and the documentation do what they say: every block of code on every page is run."""
