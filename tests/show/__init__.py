"""Verdicts, numbers, tables and pictures."""
