"""One iteration of a step, compiled: how contacts turn, the problem about them, its answer and where that leads."""
