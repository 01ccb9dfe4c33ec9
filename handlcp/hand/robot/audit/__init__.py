"""What to doubt in a hand: its limits, ranges, couplings, bodies and geometry."""
