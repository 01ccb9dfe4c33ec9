"""The mathematics: (mixed) linear complementarity problems, solvers, and a certifier that trusts none of them.

Knows nothing of grasps or robots. The names are listed in `__init__.pyi`.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
