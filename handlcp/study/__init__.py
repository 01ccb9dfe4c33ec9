"""A designer's questions, answered with hands and grasps; `study.paper` reproduces the paper they started from."""
