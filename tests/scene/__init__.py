"""Scene files: what is accepted, what is refused and in which words, and the grasps that come of them."""
