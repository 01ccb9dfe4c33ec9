"""The long suite of found grasps: `python -m tests.gallery`."""
