"""Compiled inner loops: pure functions on arrays that know no problem, no units and no status."""
