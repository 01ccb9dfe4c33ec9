"""The mechanics: contacts, friction laws, effects, and grasps assembled from them. Imports lcp, knows no robot.

GraspSpec → build → Scene → assemble → propose → verify → answer          (README.md in `handlcp` walks one number
through it)
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
