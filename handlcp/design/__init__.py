"""Hands as functions of their parameters. Imports hand."""
