"""How a hand's joints give way and what drives them: springs, tendons along routes, synergies, motors."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
