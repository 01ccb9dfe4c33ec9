"""The geometry of fingertips: a sphere at the tip frame, or the geometry of its link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, number, per_name, read_only
from handlcp.errors import InputError, URDFError
from handlcp.hand.robot.fingertips import TipFrames
from handlcp.hand.robot.link_surface import hull
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description
from handlcp.hand.robot.source.part import Part

_LARGEST = 0.5  # [m] no fingertip is larger

_CONVEX = (coal.Sphere, coal.Box, coal.Cylinder, coal.Capsule, coal.Ellipsoid, coal.ConvexBase)


class Swept(NamedTuple):
    """A ball of this radius [m] about centre + s spans[0] + t spans[1], -1 ≤ s, t ≤ 1, in tip axes [m]. centre (3,).
    spans (2, 3) : half the edges, across each other; zero for a line's second and both of a ball's.
    """

    centre: Array
    spans: Array
    radius: float


@dataclass(frozen=True, slots=True)
class TipShape:
    """One convex shape of a fingertip: coal's geometry and its placement in the tip frame.

    radius : [m] of a sphere, None for other shapes. central : whether it is a sphere about the origin of the tip frame.
    name : for messages. face : the ball, line or face of it, in the tip frame, that alone is where it touches; None:
    not known, or a sphere's. corner (3,) : of the object, in the axes of its shape, which stands on the face; None:
    what is nearest touches.
    """

    geometry: Any
    rotation: Array
    translation: Array
    radius: float | None
    central: bool = False
    name: str = "a fingertip"
    face: Swept | None = None
    corner: Array | None = None

    @property
    def middle(self) -> Array:
        """(3,) where it touches, or near there, in the tip frame."""
        face = None if self.corner is not None else self.swept
        return self.translation if face is None else face.centre

    @property
    def swept(self) -> Swept | None:
        """The swept ball that it is, where it touches; None: another shape."""
        if self.radius is not None:
            return Swept(self.translation, np.zeros((2, 3)), self.radius)
        return self.face


class TipGeometry:
    """The shapes of the fingertips: spheres of given radii, else the robot's own geometry, read when asked for."""

    __slots__ = ("_found", "_round", "_tips", "description")

    def __init__(self, description: Description, tips: TipFrames, radii: Mapping[str, float]) -> None:
        self.description, self._tips = description, tips
        self._found = {i: sphere_tip(radii[name]) for i, name in enumerate(tips.names) if name in radii}
        self._round = frozenset(self._found)

    def shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The shapes of the tip numbered `tip`. Raises URDFError when there are none."""
        if tip not in self._found:
            self._found[tip] = self._own(tip)
        return self._found[tip]

    def kind(self, tip: int) -> str:
        """What makes a tip: "radius", "collision" or "visual" geometry, "" for nothing."""
        return "radius" if tip in self._round else self._links(tip)[0]

    def _links(self, tip: int) -> tuple[str, set[str]]:
        """Which kind of geometry is the tip's, and of which links: its own, or all that move as one with it."""
        model, frame = self.description.model, self._tips.places[tip]
        links = [(i, f) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY]
        for kind in (COLLISION, VISUAL):
            there = self.description.has(kind)
            shaped = [(i, f) for i, f in links if f.name in there]
            own = {f.name for i, f in shaped if frame.link in (i, f.parentFrame)}  # the link's frame, or its joint's
            if found := own or {f.name for _, f in shaped if f.parentJoint == frame.joint}:
                return kind, found
        return "", set()

    def _own(self, tip: int) -> tuple[TipShape, ...]:
        name, place = self._tips.names[tip], self._tips.places[tip].placement
        kind, links = self._links(tip)
        if not kind:
            raise URDFError("tip_radius", f"a radius for {name!r}, whose link has no geometry", "None")
        frames = self.description.model.frames
        parts = self.description.parts(kind, links)
        return tuple(convex_shape(name, p.shape, place.actInv(frames[p.frame].placement), p) for p in parts)

    def covers(self, tip: int) -> set[str]:
        """The links whose collision geometry is the tip's."""
        kind, links = self._links(tip)
        return links if kind == COLLISION and tip not in self._round else set()

    @classmethod
    def of(cls, description: Description, tips: TipFrames, shapes: Sequence[tuple[TipShape, ...]]) -> TipGeometry:
        """Of tips whose shapes are known, one tuple for each."""
        made = cls(description, tips, {})
        made._found = dict(enumerate(shapes))
        return made


def sphere_tip(radius: float) -> tuple[TipShape, ...]:
    """A sphere about the origin of the tip frame."""
    return (TipShape(coal.Sphere(radius), read_only(np.eye(3)), read_only(np.zeros(3)), radius, True),)


def read_radii(value: Any, tips: Sequence[str]) -> dict[str, float]:
    """Radii by tip name [m] from None (no radii), a number (all tips) or a mapping. Raises InputError, UnknownName."""
    if value is None:
        return {}
    if isinstance(value, Mapping):
        given = per_name("tip_radius", value, tips, "a fingertip")
        return {tip: _radius(f"tip_radius[{tip!r}]", r) for tip, r in given.items()}
    return dict.fromkeys(tips, _radius("tip_radius", value))


def _radius(argument: str, value: Any) -> float:
    radius = number(argument, value, above=0.0)
    if radius > _LARGEST:
        expected = f"a radius in metres (if millimetres are meant, {radius / 1e3:g})"
        raise InputError(argument, expected, f"{radius:g}, a fingertip {2 * radius:g} m wide")
    return radius


def convex_shape(name: str, geometry: Any, link: Any, part: Part) -> TipShape:
    """A part of a link as that of a tip; link : where the link's frame is in the tip's. A mesh becomes its hull."""
    if isinstance(geometry, coal.BVHModelBase):
        if (made := hull(np.array(geometry.vertices(), dtype=float))) is None:
            raise URDFError("source", f"a mesh for {name!r} that encloses a volume", "one that is flat")
        geometry = made
    elif not isinstance(geometry, _CONVEX):
        expected = f"a radius for {name!r}, whose geometry is no convex shape"
        raise URDFError("tip_radius", expected, type(geometry).__name__)
    placement = link * pin.SE3(part.rotation, part.position)
    radius = float(geometry.radius) if isinstance(geometry, coal.Sphere) else None
    rotation, translation = read_only(placement.rotation.copy()), read_only(placement.translation.copy())
    central = radius is not None and not translation.any()
    return TipShape(geometry, rotation, translation, radius, central, name)
