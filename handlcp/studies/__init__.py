"""A designer's questions that take many grasps: envelopes, reliability."""
