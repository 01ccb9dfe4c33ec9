"""What a hand is: its URDF, xacro or MJCF file, joints, limits, fingertips, kinematics, and what is doubtful."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
