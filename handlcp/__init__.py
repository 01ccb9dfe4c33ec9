"""Does this hand hold this object under this load? With which forces, what slips, which joint gives out first?

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)  # N·m/rad; hl.Hand.from_urdf reads your own
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)  # m and kg, in the frame of the hand's base
q = hand.close_on(cube)  # each finger bends until its tip touches
grasp = hand.at(q).grasp(cube, friction=0.8, squeeze=0.005)
print(grasp.check())  # the hand squeezes, then the weight comes, in steps

Contacts without a hand are a hl.Grasp([hl.Contact(...), ...], wrench, flexibility=1e-4).

The names are listed in `__init__.pyi`, by room; the rooms' own lists say which file each is in. A file is imported when
its name is first asked for, with what it stands on and nothing else.
"""

import os
from importlib import import_module
from typing import Any

from lazy_loader import attach_stub

from handlcp.version import VERSION

__version__ = VERSION

for _descriptor in range(3):  # closed ones lead nowhere: a file opened in their place would get what C code prints
    try:
        os.fstat(_descriptor)
    except OSError:
        os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)

_load_name, _, __all__ = attach_stub(__name__, __file__)
_ROOMS = ("actuation", "errors", "geometry", "grasp", "hand", "lcp", "robot", "simulator")


def __getattr__(name: str) -> Any:
    """A name, a room, or an effect or a friction law in a file of its own: these are found by their class and need no
    line in the list.
    """
    if name in __all__:
        return _load_name(name)
    if name in _ROOMS:
        return import_module(f"handlcp.{name}")
    if not name.startswith("_"):
        from handlcp.contact.friction import friction_laws
        from handlcp.grasp.effects import effect_kinds

        for kind in (*[kind for kind in effect_kinds() if kind.file_key is not None], *friction_laws()):
            if kind.__name__ == name:
                return kind
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *[name for name in globals() if name.startswith("__") and name.endswith("__")]])
