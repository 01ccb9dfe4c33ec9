"""Load limits: the figure of one, a table of several."""
