"""What looks like a fingertip: at the end of each chain of joints, a frame called one, or the link's far end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.hand.robot.fingertips.link_end import far_end
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description

_FEWEST, _MOST = 2, 5  # fingers of a hand whose fingertips may be taken without being named


@dataclass(frozen=True, slots=True)
class Candidate:
    """One fingertip that could be meant. name : as `fingertips` takes it. link : that carries it. point : (3,) on the
    link, in its frame [m]; None: the origin of the frame. reason : why it could be one. sure : whether nothing else of
    its finger could be.
    """

    name: str
    link: str
    point: Array | None
    reason: str
    sure: bool
    called_tip: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.reason}"


def candidates(description: Description) -> tuple[Candidate, ...]:
    """One or more for each chain of movable joints that ends, in Pinocchio's order of joints."""
    model = description.model
    inner = {int(model.parents[j]) for j in range(1, model.njoints)}
    ends = [j for j in range(1, model.njoints) if j not in inner and model.joints[j].nv]
    called = _called_tip(model)
    out: list[Candidate] = []
    for joint in sorted({*ends, *(model.frames[i].parentJoint for i in called)}):
        names = [model.frames[i].name for i in called if model.frames[i].parentJoint == joint]
        if names:
            out += [Candidate(name, name, None, 'its name ends in "tip"', True, True) for name in names]
        else:
            out += _of_end(description, joint)
    return tuple(out)


def obvious(found: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The fingertips that need no naming: those whose names say so; else all, if they are two to five and sure."""
    if called := [c for c in found if c.called_tip]:
        return tuple(called)
    return tuple(found) if _FEWEST <= len(found) <= _MOST and all(c.sure for c in found) else ()


def _called_tip(model: Any) -> list[int]:
    """Leaf frames that a joint moves, and whose names end in "tip"."""
    parents = {frame.parentFrame for frame in model.frames}
    frames = [(i, f) for i, f in enumerate(model.frames) if i not in parents and f.name.lower().endswith("tip")]
    return [i for i, f in frames if any(model.joints[j].nv for j in model.supports[f.parentJoint] if j)]


def _of_end(description: Description, joint: int) -> list[Candidate]:
    """Candidates on what the last joint of a chain moves: a marker fixed to it, else the far end of its geometry."""
    model, name = description.model, description.model.names[joint]
    links = [(i, f) for i, f in enumerate(model.frames) if f.parentJoint == joint and f.type == pin.FrameType.BODY]
    shaped = {kind: set(description.has(kind)) for kind in (COLLISION, VISUAL)}
    seen = shaped[COLLISION] | shaped[VISUAL]
    fixed_on = {int(model.frames[f.parentFrame].parentFrame) for _, f in links}
    markers = [f for i, f in links[1:] if f.name not in seen and i not in fixed_on]
    if markers:
        reason = f"a frame without geometry, fixed to what the last joint {name} moves"
        return [Candidate(f.name, f.name, None, reason, len(markers) == 1) for f in markers]
    for kind in (COLLISION, VISUAL):
        there = [f for _, f in links if f.name in shaped[kind]]
        if there and (made := _far_end(description, joint, there[-1], kind, len(there) == 1)):
            return [made]
    return [
        Candidate(f.name, f.name, None, f"the last link, moved by {name}; it has no geometry", False) for _, f in links
    ]


def _far_end(description: Description, joint: int, frame: Any, kind: str, alone: bool) -> Candidate | None:
    """The far end of a link's geometry; without a point where its meshes cannot be read."""
    model = description.model
    last = f"the last link, moved by {model.names[joint]}"
    try:
        parts = description.parts(kind, {frame.name})
    except HandLCPError:
        return Candidate(frame.name, frame.name, None, f"{last}; its meshes cannot be read", False)
    origin = frame.placement.inverse().translation.copy()
    axis = frame.placement.rotation.T @ _axis(model.joints[joint])
    point = far_end(parts, origin, axis)
    if point is None:
        return None
    x, y, z = (f"{1e3 * v:.1f}" for v in point)
    how = f"{last}; the point ({x}, {y}, {z}) mm is at the far end of its {kind} geometry"
    return Candidate(frame.name, frame.name, point, how, alone or kind == COLLISION)


def _axis(joint: Any) -> Array:
    """(3,) direction of a joint's axis, in its frame."""
    subspace = np.asarray(joint.createData().S if hasattr(joint.createData(), "S") else np.zeros((6, 1))).reshape(6, -1)
    way = subspace[3:, 0] if subspace[3:, 0].any() else subspace[:3, 0]
    return np.asarray(way, dtype=float)
