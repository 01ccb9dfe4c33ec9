"""Beside MuJoCo, a simulator that is not ours: `python -m tests.mujoco` runs every case and prints a table."""
