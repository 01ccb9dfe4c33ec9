"""Solvers, one method a file. Each is a small configured value that turns a scaled problem into a `Proposal`."""
