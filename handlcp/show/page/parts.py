"""The solids of a page, each with what moves it: a joint of the hand, the object, or nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand import HandState
from handlcp.show.page.simplify import simplified
from handlcp.show.picture.bodies import Body, Colour, environment_bodies
from handlcp.show.picture.content import Content
from handlcp.show.style import INK, RED

FIXED = -1
MOST = 100_000  # triangles of a hand, and of an object; more are simplified
_LEAST = 200  # of one link
_MARK = 0.55  # share of the mark's colour in that of a link inside the object


@dataclass(frozen=True, slots=True)
class Part:
    """triangles (m, 3, 3) [m], in axes of what moves it when nothing has moved. layer : "hand", "inside" (a link inside
    the object), "tips" (the shape that finds a contact), "environment", "object". joint : number of the joint that
    moves it; FIXED: none. before : how many triangles it had.
    """

    triangles: Array
    colour: Colour
    layer: str
    joint: int = FIXED
    before: int = 0


def parts_of(shown: Content) -> list[Part]:
    """Everything that a picture shows, simplified where it has very many triangles."""
    table = environment_bodies(shown.grasp)
    hand = shown.solids[: len(shown.solids) - len(table)]
    state = getattr(shown.grasp, "state", None)
    found = [_part(b, "hand") for b in hand] if state is None else list(_links(state, hand, shown.tips))
    found = _fewer(found) + [_part(b, "environment") for b in table]
    return found + _fewer([_part(shown.glass, "object")] if shown.glass is not None else [])


def notes_of(shown: Content, parts: Sequence[Part]) -> list[str]:
    """What a reader should know of how things are drawn."""
    notes = list[str]()
    if not hasattr(shown.grasp, "state"):
        notes.append("The grasp has no hand: rods stand for its fingers.")
    if shown.glass is not None and shown.glass.label != "object":
        notes.append("The object is not known: the hull of the contacts stands for it.")
    for name, layers in (("hand", ("hand", "inside")), ("object", ("object",))):
        drawn = [p for p in parts if p.layer in layers]
        now, before = sum(len(p.triangles) for p in drawn), sum(p.before for p in drawn)
        if now < before:
            notes.append(f"The {name} is simplified: it is drawn with {now} of its {before} triangles.")
    return notes


def _part(body: Body, layer: str) -> Part:
    return Part(body.triangles, body.colour, layer, before=len(body.triangles))


def _links(state: HandState, bodies: Sequence[Body], tips: Sequence[Array]) -> Iterator[Part]:
    """Bodies and fingertips in world axes, taken to those of their joints."""
    hand = state.hand
    model, data = hand.model, hand.model.createData()
    pin.forwardKinematics(model, data, hand.kinematics.configuration(state.q))
    joint_of = {f.name: int(f.parentJoint) for f in model.frames if f.type == pin.FrameType.BODY}
    for b in bodies:
        joint, layer = joint_of.get(b.link, 0), "inside" if b.marked else "hand"
        yield Part(_taken(b.triangles, data.oMi[joint]), _marked(b), layer, joint, len(b.triangles))
    ink = _rgb(INK)
    for triangles in tips:
        away = np.linalg.norm(state.tip_positions - triangles.mean(axis=(0, 1)), axis=1)
        joint = int(model.frames[hand.tips.frames[int(away.argmin())]].parentJoint)
        yield Part(_taken(triangles, data.oMi[joint]), ink, "tips", joint, len(triangles))


def _taken(triangles: Array, joint: Any) -> Array:
    """World axes to those of a joint."""
    return np.asarray((triangles - joint.translation) @ joint.rotation)


def _marked(body: Body) -> Colour:
    if not body.marked:
        return body.colour
    r, g, b = ((1.0 - _MARK) * np.array(body.colour) + _MARK * np.array(_rgb(RED))).tolist()
    return (r, g, b)


def _rgb(colour: str) -> Colour:
    r, g, b = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return (r, g, b)


def _fewer(parts: list[Part]) -> list[Part]:
    """With at most so many triangles in all, each part's share as it was."""
    share = MOST / max(sum(len(p.triangles) for p in parts), 1)
    if share >= 1.0:
        return parts
    return [replace(p, triangles=simplified(p.triangles, max(_LEAST, int(share * len(p.triangles))))) for p in parts]
