"""Hands beside each other: what each does of a brief, on one page."""
