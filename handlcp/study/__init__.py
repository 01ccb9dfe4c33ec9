"""A designer's questions that take many grasps: envelopes, reliability, a gallery of hands."""
