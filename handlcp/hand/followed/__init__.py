"""A hand and its object in motion, for loading in steps."""
