"""The hand that touches an object where its links are: each contact is a site, a place on a link with its own shape."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError, NotReached, UnknownName, Unsupported
from handlcp.hand.elasticity.stiffness import Pads
from handlcp.hand.objects.detect import nearest
from handlcp.hand.objects.inside import ball_around
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.solid import size_of
from handlcp.hand.robot.fingertips import TipFrames, TipPlace
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.posture import Posture
from handlcp.hand.robot.tip_geometry import TipGeometry, TipShape
from handlcp.hand.sites.patch import patch
from handlcp.hand.sites.touchers import ALL, Toucher, link_names, touchers

MOST = 100  # sites of one grasp
_SAME, _ALIKE = 1.5e-3, 0.98  # [m], cosine of normals: nearer and more alike, two contacts of what moves as one are one
_DEEP = 5e-3  # [m] deeper in the object a link cannot begin

T = TypeVar("T", bound=Posture)


@dataclass(frozen=True, eq=False)
class Site:
    """A place on a link that may touch. shape : there, in the link's frame. position (3,) on the object and normal (3,)
    into it, world axes; gap [m].
    """

    link: Toucher
    shape: TipShape
    position: Array
    normal: Array
    gap: float


def sited(state: T, obj: Object, links: Any, max_gap: float) -> T:
    """The posture of a hand whose fingertips are the sites of these links that are within `max_gap` [m] of an object.

    Raises NotReached for none, InputError for a link deep inside the object, and what `touchers` raises.
    """
    among = touchers(state.hand, links)
    near = sites(state, among, obj, max_gap)
    if not near:
        least = nearest_links(gaps_of(state, among, obj))
        expected = (
            f"a link within max_gap = {max_gap * 1e3:g} mm of the object: hand.close_on(obj, wrap=True) closes the "
        )
        raise NotReached("links", expected + "hand first, or closing_torque= here does", least)
    made = touching_there(state.hand, near)
    if not (isinstance(links, str) and links == ALL):
        made = made.with_parts(may_touch=_links_of(state.hand, among))
    return type(state)(made, state.q)


def _links_of(hand: HandModel, among: Iterable[Toucher]) -> frozenset[str]:
    """The names of the links that these stand for."""
    names = {toucher.name for toucher in among}
    tips = [i for i in hand.tips.every if hand.fingertips[i] in names]
    return frozenset(names.union(*(hand.tip_links(i) for i in tips)))


def sites(state: Posture, among: Iterable[Toucher], obj: Object, reach: float) -> list[Site]:
    """All that are within reach [m] of the object, in the order of the links. Raises InputError."""
    centre, around = ball_around(obj)
    found, deepest = list[Site](), ("", 0.0)
    for toucher, R, p in placed(state, among):
        for shape in toucher.shapes:
            middle = p + R @ shape.translation
            if float(np.linalg.norm(middle - centre)) > np.sqrt(3.0) * size_of(shape.geometry) + around + reach:
                continue
            gap = nearest((shape,), p, R, obj).gap
            if gap > reach:
                continue
            deepest = min(deepest, (toucher.name, gap), key=lambda one: one[1])
            others = tuple(found)
            for made, gap in patch(shape, p, R, obj):
                there = nearest((made,), p, R, obj)
                site = Site(toucher, made, there.position, there.normal, gap)
                if gap <= reach and not any(_same(site, other) for other in others):
                    found.append(site)
    if len(found) > MOST:
        expected = f"at most {MOST} contacts (name fewer links, or use coarser collision geometry)"
        raise InputError("links", expected, f"{len(found)} places that touch")
    ask_for_outside("target", *deepest)
    return found


def gaps_of(state: Posture, among: Iterable[Toucher], obj: Object) -> list[tuple[Toucher, float]]:
    """Signed distances of links and the object [m]; those of which none is known left out."""
    found = []
    for toucher, R, p in placed(state, among):
        try:
            found.append((toucher, nearest(toucher.shapes, p, R, obj).gap))
        except Unsupported:
            continue
    return found


def nearest_links(gaps: Iterable[tuple[Toucher, float]]) -> dict[str, float]:
    """The five nearest of links and their gaps [m], by name, for messages."""
    return dict(sorted([(link.name, gap) for link, gap in gaps], key=lambda one: one[1])[:5])


def placed(state: Posture, among: Iterable[Toucher]) -> list[tuple[Toucher, Array, Array]]:
    """Links with rotation (3, 3) and position (3,) of their frames."""
    among = list(among)
    hand = state.hand
    joints, _ = hand.kinematics.joints_at(state.q, [t.place.joint for t in among])
    out = []
    for toucher, at in zip(among, joints, strict=True):
        own = toucher.place.placement
        out.append((toucher, at[:3, :3] @ own.rotation, at[:3, :3] @ own.translation + at[:3, 3]))
    return out


def _same(site: Site, other: Site) -> bool:
    near = np.linalg.norm(site.position - other.position) <= _SAME and site.normal @ other.normal >= _ALIKE
    return bool(near and site.link.place.joint == other.link.place.joint)


def ask_for_outside(argument: str, link: str, gap: float) -> None:
    """Raises InputError where the link whose gap [m] is the least of all is deep inside the object."""
    if gap < -_DEEP:
        expected = "an object beside the hand, where no link begins inside it"
        raise InputError(argument, expected, f"{link}, {words.length(-gap)} inside it")


# ----------------------------------------------------------------
# A hand whose contacts are sites.


def touching_there(hand: HandModel, near: list[Site]) -> HandModel:
    """The hand with these sites as its fingertips, named by their links and numbered where a link has several."""
    model, counts = hand.model, dict[str, int]()
    for site in near:
        counts[site.link.name] = counts.get(site.link.name, 0) + 1
    seen, names, frames, places, shapes = dict[str, int](), [], [], [], []
    taken = {frame.name for frame in model.frames}
    for site in near:
        link = site.link.name
        seen[link] = seen.get(link, 0) + 1
        names.append(f"{link} {seen[link]}" if counts[link] > 1 else link)
        about = site.shape.middle
        shapes.append((_moved(site.shape, -about),))
        place = site.link.place.placement * pin.SE3(np.eye(3), about.copy())
        marked = names[-1] if names[-1] not in taken else f"{names[-1]} (contact)"
        carrier = site.link.place
        frames.append(
            int(model.addFrame(pin.Frame(marked, carrier.joint, carrier.link, place, pin.FrameType.OP_FRAME)))
        )
        places.append(TipPlace(carrier.link, carrier.joint, place))
    support = np.array([site.link.support for site in near]).reshape(len(near), 1, -1)
    tips = TipFrames(tuple(names), tuple(frames), tuple(places), support)
    pads = np.array([site.link.pad for site in near]).reshape(-1, 3, 3)
    return hand.with_parts(
        tips=tips, fingertips=tips.names, kinematics=Kinematics(model, hand.kinematics.facts), pads=Pads(pads),
        links_of_sites=tuple(site.link.name for site in near), own_tips=hand.fingertips,
        _geometry=TipGeometry.of(hand.description, tips, shapes),
    )  # fmt: skip


def _moved(shape: TipShape, by: Array) -> TipShape:
    """The shape in a frame that stands elsewhere in the same axes."""
    at = read_only(shape.translation + by)
    face = None if shape.face is None else shape.face._replace(centre=read_only(shape.face.centre + by))
    return replace(shape, translation=at, face=face, central=shape.radius is not None and not at.any())


def by_site(argument: str, value: Any, hand: HandModel) -> Any:
    """What was said by link, by site: a mapping whose keys are sites or links. Anything else stays as it is.

    Raises UnknownName for what is neither; what is said of a link that does not touch is left out.
    """
    of = hand.links_of_sites
    if of is None or not isinstance(value, Mapping):
        return value
    links = (*dict.fromkeys(of), *hand.own_tips, *link_names(hand))
    if unknown := [str(name) for name in value if name not in hand.fingertips and name not in links]:
        raise UnknownName(argument, "a link", unknown, tuple(dict.fromkeys((*hand.fingertips, *links))))
    said = {site: value[link] for site, link in zip(hand.fingertips, of, strict=True) if link in value}
    return said | {site: value[site] for site in hand.fingertips if site in value}
