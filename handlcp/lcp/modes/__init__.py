"""The search over everything that contacts can do at once: what fits each choice of modes, and a tree of choices."""
