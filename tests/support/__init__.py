"""Builders of scenes and hands, oracles, and what tests put in the place of something inside the package."""
