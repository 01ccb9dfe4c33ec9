"""What of a hand may touch: its fingertips, and the collision geometry of its links, the palm's included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.errors import InputError, UnknownName, URDFError
from handlcp.hand.robot.convex import convex_parts
from handlcp.hand.robot.fingertips import TipPlace
from handlcp.hand.robot.link_surface import triangles_of
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.source.description import COLLISION, Description
from handlcp.hand.robot.tip_geometry import TipShape, convex_shape

TIPS, ALL = "tips", "all"


@dataclass(frozen=True, eq=False)
class Toucher:
    """A fingertip, or a link. place : its frame in that of its joint. support (1, joints) : 1 where a joint moves it.
    shapes : convex, in its frame. pad (3, 3) : flexibility of its surface in its axes [m/N].
    """

    name: str
    place: TipPlace
    support: Array
    shapes: tuple[TipShape, ...]
    pad: Array


def touchers(hand: HandModel, links: Any) -> tuple[Toucher, ...]:
    """Those named by `links`: "all", or names of links and fingertips; fingertips first. A link whose geometry is that
    of a fingertip comes under the fingertip's name.

    Raises UnknownName; InputError for a link without collision geometry; URDFError for meshes that cannot be read.
    """
    every = _every(hand)
    if isinstance(links, str) and links == ALL:
        if not every:
            raise InputError("links", "links with collision geometry", f"{hand.name!r}, whose links have none")
        return tuple(every.values())
    links = links.tolist() if isinstance(links, np.ndarray) else links
    if isinstance(links, str) or not isinstance(links, Sequence) or not links:
        expected = '"tips", "all", or a list with the names of links, at least one'
        raise InputError("links", expected, repr(links)[:80])
    if repeated := [str(name) for name in dict.fromkeys(links) if list(links).count(name) > 1]:
        raise InputError("links", "names of links, each once", f"{', '.join(repeated)} several times")
    known: list[str] = _names(hand)
    if unknown := [str(name) for name in links if name not in known and name not in every]:
        raise UnknownName("links", "a link", unknown, tuple(dict.fromkeys((*known, *hand.fingertips))))
    tip_of = {link: hand.fingertips[i] for i in hand.tips.every for link in hand.tip_links(i)}
    chosen: dict[str, None] = dict.fromkeys(str(name if name in every else tip_of.get(name, name)) for name in links)
    if bare := [name for name in chosen if name not in every]:
        expected = f"links with collision geometry (such as {', '.join(list(every)[:3])})"
        raise InputError("links", expected, f"{', '.join(bare)}, which {'has' if len(bare) == 1 else 'have'} none")
    return tuple(every[name] for name in chosen)


def link_names(hand: HandModel) -> tuple[str, ...]:
    """What may be named where something is said by link: fingertips and links with collision geometry."""
    return tuple(dict.fromkeys([*hand.fingertips, *hand.description.has(COLLISION)]))


def _names(hand: HandModel) -> list[str]:
    return [f.name for f in hand.description.model.frames if f.type == pin.FrameType.BODY and f.name != "universe"]


def _every(hand: HandModel) -> dict[str, Toucher]:
    """By name: fingertips, then links with collision geometry that is no fingertip's, in the file's order."""
    found, covered = dict[str, Toucher](), set[str]()
    for i, name in enumerate(hand.fingertips):
        if hand.tip_kind(i):
            own = hand.tips.places[i]
            pad = hand.pads.blocks[i]
            found[name] = Toucher(name, own, hand.tips.support[i], hand.tip_shapes(i), pad)
        covered |= hand.tip_links(i)
    model = hand.description.model
    for number, shapes in _shapes(hand.description, hand.in_parts_of):
        frame = model.frames[number]
        if shapes and frame.name not in covered and frame.name not in hand.fingertips:
            # a fingertip with a radius takes the place of its link's geometry
            place = TipPlace(number, int(frame.parentJoint), pin.SE3(frame.placement))
            pad = hand.pads.of_link(frame.name)
            found[frame.name] = Toucher(frame.name, place, _support(model, frame), shapes, pad)
    return found


@lru_cache(maxsize=32)
def _shapes(description: Description, parted: frozenset[str]) -> tuple[tuple[int, tuple[TipShape, ...]], ...]:
    """Numbers of the links' frames, and their convex shapes. A mesh that is not convex counts as its hull, or comes in
    parts on the links that `parted` names.
    """
    found = dict[int, list[TipShape]]()
    for part in description.parts(COLLISION):
        name = description.model.frames[part.frame].name
        own = found.setdefault(part.frame, [])
        try:
            whole = convex_shape(name, part.shape, pin.SE3.Identity(), part)
        except URDFError:
            continue  # a flat mesh, or a shape that no distance is known of
        split = name in parted and isinstance(part.shape, coal.BVHModelBase)
        pieces = convex_parts(triangles_of(part.shape)) if split else (whole.geometry,)
        own += [replace(whole, geometry=piece) for piece in pieces]
    return tuple((frame, tuple(shapes)) for frame, shapes in found.items())


def _support(model: Any, frame: Any) -> Array:
    row = np.zeros((1, model.nv))
    for joint in model.supports[frame.parentJoint]:
        if joint and model.joints[joint].nv:
            row[0, model.joints[joint].idx_v] = 1.0
    return read_only(row)
