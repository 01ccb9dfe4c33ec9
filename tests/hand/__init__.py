"""Tests of the hand."""
