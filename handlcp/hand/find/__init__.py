"""Finding grasps: where an object fits between the fingertips, touched by all of them and held."""
