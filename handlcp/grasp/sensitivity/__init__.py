"""Derivatives of an answer, from the contact conditions that hold at it."""
