"""Envelopes for people: a surface in space, polar diagrams, a page to turn, plain data."""
