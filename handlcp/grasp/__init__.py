"""The mechanics: contacts, friction laws, effects, and grasps assembled from them. Imports lcp, knows no robot.

GraspSpec → build → Scene → assemble → propose → verify → answer          (README.md in `handlcp` walks one number
through it)
"""

from typing import Any

from lazy_loader import attach_stub

_named, _, __all__ = attach_stub(__name__, __file__)
_LAWS = ("AnisotropicCoulomb", "Coulomb", "Frictionless", "FrictionLaw", "Pyramid", "SoftFinger")
__all__ += _LAWS


def __getattr__(name: str) -> Any:
    """A name of the list, or a friction law, which stands in `handlcp.contact`."""
    if name in _LAWS:
        from handlcp.contact import friction

        return getattr(friction, name)
    return _named(name)


def __dir__() -> list[str]:
    return [*__all__]
