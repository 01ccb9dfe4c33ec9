"""Quasi-static loading: a grasp followed through its stages, step by step."""
