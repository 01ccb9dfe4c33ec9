"""A designer's questions that take many grasps: envelopes, payload, reliability, grip strength, what accuracy costs."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
