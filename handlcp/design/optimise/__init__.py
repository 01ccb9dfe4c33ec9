"""The best numbers of a hand: one objective by its derivatives, several by a population."""
