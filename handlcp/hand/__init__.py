"""The robot: a hand from a URDF, its postures, objects to grasp, contact detection and joint torques. Imports grasp."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
