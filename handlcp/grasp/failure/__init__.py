"""What gives out: one judge of a state, one table of words."""
