"""`Brief`: what a hand must do: objects to hold, loads on them, and how far is far enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from handlcp.check import (
    Array,
    check_array,
    check_call,
    check_integer,
    check_method_calls,
    check_number,
    count_dimensions,
    read_only,
)
from handlcp.contact.friction import as_law
from handlcp.errors import InputError, as_path
from handlcp.geometry.object import Object
from handlcp.hand.find.find import PINCH, check_closing
from handlcp.hand.squeeze import read_by_tip
from handlcp.hand.torque_closing import read_torque_by_joint
from handlcp.studies.payload.largest_mass import SIX, check_orientations
from handlcp.write_file import write_file

WEIGHT_NAME = "weight"  # what the object's own weight is called among its loads
_WRENCH_EXPECTED = "force [N] and torque [N·m] beside the weight"
_CLOSING_ARGUMENTS = (
    "squeeze",
    "grip_force",
    "closing_torque",
)  # arguments of `find_grasp` that say how hard the hand closes


@check_method_calls
@dataclass(frozen=True, eq=False)
class Brief:
    """What a hand must do, for `evaluate`. Immutable.

    objects : shapes and masses to hold: one, a sequence, or a mapping of names to them. Their placements do not count:
        the hand finds its grasps.
    loads : on each object beside its weight, about the grasp's reference: (6,) force [N] and torque [N·m], axes of the
        hand's base, gravity along its -z; a sequence of them, or a mapping of names to them. None: the weight alone.
    friction : of all contacts: a coefficient or a law.
    orientations, acceleration : in which directions gravity pulls on the object, 6 or "any", and how fast the hand
        speeds up [m/s²], as in `Grasp.payload`.
    motion : how far an object may move [m] under its weight or a load, after the hand has closed; None: any distance.
    most_force : the largest normal force that an object bears at a contact [N], such as 3 N for an egg; None: any.
    safety : > 0: how many times the weight, and each load, must be held.
    kind : of grasp: "pinch", "power" or "any". squeeze, grip_force, closing_torque : how hard the hand closes; these,
        and seed, as in `find_grasp`. tries : placements to begin with, at most: with more of them the grasp that is
        found holds what is asked, or as much of it, at least as well.
    `from_toml` reads one from a file, `to_toml` writes it. Raises InputError.
    """

    objects: Any
    loads: Any = None
    friction: Any = 0.6
    orientations: Any = SIX
    acceleration: float = 0.0
    motion: float | None = None
    most_force: float | None = None
    safety: float = 1.0
    kind: str = PINCH
    squeeze: Any = None
    grip_force: Any = None
    closing_torque: Any = None
    tries: int = 256
    seed: int = 0

    def __post_init__(self) -> None:
        above = partial(check_number, above=0.0)
        put = partial(object.__setattr__, self)
        put("objects", _read_objects(self.objects))
        put("loads", _read_loads(self.loads))
        as_law(self.friction)
        check_orientations(self.orientations)
        put("acceleration", check_number("acceleration", self.acceleration, minimum=0.0))
        for name in ("motion", "most_force"):
            value = getattr(self, name)
            put(name, None if value is None else above(name, value))
        put("safety", above("safety", self.safety))
        check_closing(self.kind, self.squeeze, self.grip_force, self.closing_torque)
        for name, value in self.closing.items():  # for a hand whose joints and fingertips are not known yet
            _ = read_torque_by_joint(value) if name == "closing_torque" else read_by_tip(name, value)
        put("tries", check_integer("tries", self.tries, 1))
        put("seed", check_integer("seed", self.seed, 0))

    @classmethod
    def from_toml(cls, path: Any) -> Self:
        """The brief of a TOML file, whose keys `handlcp keys --brief` lists. Raises SceneFileError for a file that is
        missing, is no TOML, or holds other keys or kinds of values; otherwise InputError. Both name file and key.
        """
        from handlcp.design.brief_file import load_brief  # pydantic is paid for by those who read files

        return load_brief(path, cls)

    def to_toml(self, path: Any = None) -> str | Path:
        """The brief as TOML: the text, or the file that it was written to; `from_toml` reads the same brief. Placements
        of objects, which do not count, are left out; files of meshes are relative to the file.

        Raises InputError for what a file has no key for, such as a mesh from memory, and one that cannot be written.
        """
        from handlcp.design.brief_file import brief_to_toml  # pydantic, as above

        if path is None:
            return brief_to_toml(self, Path())
        file = as_path("path", path)
        text = brief_to_toml(self, file.parent)
        return write_file("path", file, text)

    @property
    def closing(self) -> dict[str, Any]:
        """How hard the hand closes, as arguments of `find_grasp`."""
        return {name: value for name in _CLOSING_ARGUMENTS if (value := getattr(self, name)) is not None}

    @property
    def most_motion(self) -> float:
        """How far an object may move [m]; inf: any distance."""
        return np.inf if self.motion is None else self.motion


Brief.__init__ = check_call(mass="it is the object's: Box(..., mass=...)")(Brief.__init__)  # type: ignore[method-assign]


def _read_objects(given: Any) -> dict[str, Object]:
    """The objects of a brief by name, from what a user gives for them. Raises InputError."""
    expected = "an object such as Sphere(0.03), a sequence of them, or a mapping of names to them; at least one"
    if isinstance(given, Object):
        return {"object": given}
    if isinstance(given, Mapping):
        named = {str(name): obj for name, obj in given.items()}
    elif isinstance(given, Sequence) and not isinstance(given, str):
        named = {f"object {k + 1}": obj for k, obj in enumerate(given)}
    else:
        raise InputError("objects", expected, repr(given)[:80])
    for name, obj in named.items():
        if not isinstance(obj, Object):
            raise InputError(f"objects[{name!r}]", "an object such as Sphere(0.03)", repr(obj)[:80])
    if not named:
        raise InputError("objects", expected, repr(given)[:80])
    return named


def _read_loads(given: Any) -> dict[str, Array]:
    """The loads of a brief by name, (6,) each [N, N·m], from what a user gives for them. Raises InputError."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        named = {str(name): load for name, load in given.items()}
    else:
        rows = given if isinstance(given, Sequence | np.ndarray) and count_dimensions(given) != 1 else [given]
        named = {f"load {k + 1}": load for k, load in enumerate(rows)}
    found = {name: check_array(f"loads[{name!r}]", load, (6,), what=_WRENCH_EXPECTED) for name, load in named.items()}
    for name, load in found.items():
        if not load.any():
            raise InputError(f"loads[{name!r}]", "a load that is not zero: the weight is there anyway", load.tolist())
        if name == WEIGHT_NAME:
            raise InputError(
                "loads", f"another name than {WEIGHT_NAME!r}, which the object's own weight has", repr(name)
            )
    return {name: read_only(load) for name, load in found.items()}
