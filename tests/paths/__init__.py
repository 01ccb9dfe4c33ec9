"""Whether `load_limit`, `follow` and `check` say the same of a grasp; `python -m tests.paths` has the measures."""
