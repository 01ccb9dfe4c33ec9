"""Colours of pictures and figures, from Okabe and Ito's palette: colour-blind readers can tell them apart."""

from __future__ import annotations

__all__ = ["BLUE", "GREEN", "GREY", "INK", "PURPLE", "RED"]

BLUE, RED, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#A0307A"
INK, GREY = "#222222", "#5F5F5F"  # of text, and of text that matters less
