"""What a hand holds, and where it touches: objects, meshes, distances, contact detection."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
