"""`find_link_contacts`: what of a hand may touch, its fingertips and the collision geometry of its links and palm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, TypeVar

import coal
import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.actuation.joint_stiffness import FingertipPads
from handlcp.check import Array, read_only
from handlcp.errors import InputError, NotReached, UnknownName, Unsupported, URDFError
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.geometry.contact_patch import find_contact_patch
from handlcp.geometry.distance import shape_size
from handlcp.geometry.link_penetration import bounding_ball
from handlcp.geometry.object import Object
from handlcp.robot.description import COLLISION, RobotDescription
from handlcp.robot.fingertip import TipFrames, TipGeometry, TipPlacement, TipShape, make_convex_shape
from handlcp.robot.hand_model import HandModel, HandPosture
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_surface import convex_parts, mesh_triangles

TIPS_ONLY, ALL_LINKS = "tips", "all"


@dataclass(frozen=True, eq=False)
class ContactBody:
    """A fingertip, or a link. place : its frame in that of its joint. support (1, joints) : 1 where a joint moves it.
    shapes : convex, in its frame. pad (3, 3) : flexibility of its surface in its axes [m/N].
    """

    name: str
    place: TipPlacement
    support: Array
    shapes: tuple[TipShape, ...]
    pad: Array


def contact_bodies(hand: HandModel, links: Any) -> tuple[ContactBody, ...]:
    """Those named by `links`: "all", or names of links and fingertips; fingertips first. A link whose geometry is that
    of a fingertip comes under the fingertip's name.

    Raises UnknownName; InputError for a link without collision geometry; URDFError for meshes that cannot be read.
    """
    every = _all_contact_bodies(hand)
    if isinstance(links, str) and links == ALL_LINKS:
        if not every:
            raise InputError("links", "links with collision geometry", f"{hand.name!r}, whose links have none")
        return tuple(every.values())
    links = links.tolist() if isinstance(links, np.ndarray) else links
    if isinstance(links, str) or not isinstance(links, Sequence) or not links:
        expected = '"tips", "all", or a list with the names of links, at least one'
        raise InputError("links", expected, repr(links)[:80])
    if repeated := [str(name) for name in dict.fromkeys(links) if list(links).count(name) > 1]:
        raise InputError("links", "names of links, each once", f"{', '.join(repeated)} several times")
    frames = hand.description.model.frames
    known: list[str] = [f.name for f in frames if f.type == pin.FrameType.BODY and f.name != "universe"]
    if unknown := [str(name) for name in links if name not in known and name not in every]:
        raise UnknownName("links", "a link", unknown, tuple(dict.fromkeys((*known, *hand.fingertips))))
    tip_of = {link: hand.fingertips[i] for i in hand.tips.numbers for link in hand.tip_links(i)}
    chosen: dict[str, None] = dict.fromkeys(str(name if name in every else tip_of.get(name, name)) for name in links)
    if bare := [name for name in chosen if name not in every]:
        expected = f"links with collision geometry (such as {', '.join(list(every)[:3])})"
        raise InputError("links", expected, f"{', '.join(bare)}, which {'has' if len(bare) == 1 else 'have'} none")
    return tuple(every[name] for name in chosen)


def contact_body_names(hand: HandModel) -> tuple[str, ...]:
    """What may be named where something is said by link: fingertips and links with collision geometry."""
    return tuple(dict.fromkeys([*hand.fingertips, *hand.description.links_with(COLLISION)]))


def _all_contact_bodies(hand: HandModel) -> dict[str, ContactBody]:
    """All bodies of the hand that may touch, by name.

    Fingertips come first, then links with collision geometry that is no fingertip's, in the file's order.
    """
    found, covered = dict[str, ContactBody](), set[str]()
    for i, name in enumerate(hand.fingertips):
        if hand.tip_kind(i):
            found[name] = ContactBody(
                name, hand.tips.places[i], hand.tips.support[i], hand.tip_shapes(i), hand.pads.blocks[i]
            )
        covered |= hand.tip_links(i)
    model = hand.description.model
    for number, shapes in _link_shapes(hand.description, hand.in_parts_of):
        frame = model.frames[number]
        if shapes and frame.name not in covered and frame.name not in hand.fingertips:
            # a fingertip with a radius takes the place of its link's geometry
            place = TipPlacement(number, int(frame.parentJoint), pin.SE3(frame.placement))
            support = np.zeros((1, model.nv))
            moving = (model.joints[j] for j in model.supports[frame.parentJoint] if j)
            support[0, [joint.idx_v for joint in moving if joint.nv]] = 1.0
            pad = hand.pads.link_pad(frame.name)
            found[frame.name] = ContactBody(frame.name, place, read_only(support), shapes, pad)
    return found


@lru_cache(maxsize=32)
def _link_shapes(description: RobotDescription, parted: frozenset[str]) -> tuple[tuple[int, tuple[TipShape, ...]], ...]:
    """Numbers of the links' frames, and their convex shapes. A mesh that is not convex counts as its hull, or comes in
    parts on the links that `parted` names.
    """
    found = dict[int, list[TipShape]]()
    for part in description.load_shapes(COLLISION):
        name = description.model.frames[part.frame].name
        own = found.setdefault(part.frame, [])
        try:
            whole = make_convex_shape(name, part.shape, pin.SE3.Identity(), part)
        except URDFError:
            continue  # a flat mesh, or a shape that no distance is known of
        split = name in parted and isinstance(part.shape, coal.BVHModelBase)
        pieces = convex_parts(mesh_triangles(part.shape)) if split else (whole.geometry,)
        own += [replace(whole, geometry=piece) for piece in pieces]
    return tuple((frame, tuple(shapes)) for frame, shapes in found.items())


# ----------------------------------------------------------------
# The hand that touches an object where its links are: each contact is a site, a place on a link with its own shape.


MAX_CONTACTS = 100  # sites of one grasp
# [m], cosine of normals: nearer and more alike, two contacts of what moves as one are one
_SAME_CONTACT_DISTANCE, _SAME_NORMAL_COSINE = 1.5e-3, 0.98
_MAX_START_DEPTH = 5e-3  # [m] deeper in the object a link cannot begin

PostureT = TypeVar("PostureT", bound=HandPosture)


@dataclass(frozen=True, eq=False)
class LinkContact:
    """A place on a link that may touch. shape : there, in the link's frame. position (3,) on the object and normal (3,)
    into it, world axes; gap [m].
    """

    link: ContactBody
    shape: TipShape
    position: Array
    normal: Array
    gap: float


def touch_with_links(state: PostureT, obj: Object, links: Any, max_gap: float) -> PostureT:
    """The posture of a hand whose fingertips are the sites of these links that are within `max_gap` [m] of an object.

    Raises NotReached for none, InputError for a link deep inside the object, and what `contact_bodies` raises.
    """
    among = contact_bodies(state.hand, links)
    near = find_link_contacts(state, among, obj, max_gap)
    if not near:
        least = nearest_links(body_gaps(state, among, obj))
        advice = "hand.close_on(obj, wrap=True) closes the hand first, or closing_torque= here does"
        raise NotReached("links", f"a link within max_gap = {max_gap * 1e3:g} mm of the object: {advice}", least)
    made = make_contact_hand(state.hand, near)
    if not (isinstance(links, str) and links == ALL_LINKS):
        hand, names = state.hand, {body.name for body in among}
        tips = [i for i in hand.tips.numbers if hand.fingertips[i] in names]
        made = made.with_parts(may_touch=frozenset(names.union(*(hand.tip_links(i) for i in tips))))
    return type(state)(made, state.q)


def find_link_contacts(
    state: HandPosture, among: Iterable[ContactBody], obj: Object, reach: float
) -> list[LinkContact]:
    """All that are within reach [m] of the object, in the order of the links. Raises InputError."""
    centre, around = bounding_ball(obj)
    found, deepest = list[LinkContact](), ("", 0.0)
    for toucher, R, p in body_frames(state, among):
        for shape in toucher.shapes:
            middle = p + R @ shape.translation
            if float(np.linalg.norm(middle - centre)) > np.sqrt(3.0) * shape_size(shape.geometry) + around + reach:
                continue
            gap = nearest_proximity((shape,), p, R, obj).gap
            if gap > reach:
                continue
            deepest = min(deepest, (toucher.name, gap), key=lambda one: one[1])
            others = tuple([other for other in found if other.link.place.joint == toucher.place.joint])
            for made, gap in find_contact_patch(shape, p, R, obj):
                there = nearest_proximity((made,), p, R, obj)
                is_known = any(
                    np.linalg.norm(there.position - other.position) <= _SAME_CONTACT_DISTANCE
                    and there.normal @ other.normal >= _SAME_NORMAL_COSINE
                    for other in others
                )
                if gap <= reach and not is_known:
                    found.append(LinkContact(toucher, made, there.position, there.normal, gap))
    if len(found) > MAX_CONTACTS:
        expected = f"at most {MAX_CONTACTS} contacts (name fewer links, or use coarser collision geometry)"
        raise InputError("links", expected, f"{len(found)} places that touch")
    check_outside("target", *deepest)
    return found


def body_gaps(state: HandPosture, among: Iterable[ContactBody], obj: Object) -> list[tuple[ContactBody, float]]:
    """Signed distances of links and the object [m]; those of which none is known left out."""
    found = []
    for toucher, R, p in body_frames(state, among):
        try:
            found.append((toucher, nearest_proximity(toucher.shapes, p, R, obj).gap))
        except Unsupported:
            continue
    return found


def nearest_links(gaps: Iterable[tuple[ContactBody, float]]) -> dict[str, float]:
    """The five nearest of links and their gaps [m], by name, for messages."""
    return dict(sorted([(link.name, gap) for link, gap in gaps], key=lambda one: one[1])[:5])


def body_frames(state: HandPosture, among: Iterable[ContactBody]) -> list[tuple[ContactBody, Array, Array]]:
    """Links with rotation (3, 3) and position (3,) of their frames."""
    among = list(among)
    hand = state.hand
    joints, _ = hand.kinematics.joints_at(state.q, [t.place.joint for t in among])
    out = []
    for toucher, at in zip(among, joints, strict=True):
        own = toucher.place.placement
        out.append((toucher, at[:3, :3] @ own.rotation, at[:3, :3] @ own.translation + at[:3, 3]))
    return out


def check_outside(argument: str, link: str, gap: float) -> None:
    """Raises InputError where the link whose gap [m] is the least of all is deep inside the object."""
    if gap < -_MAX_START_DEPTH:
        expected = "an object beside the hand, where no link begins inside it"
        raise InputError(argument, expected, f"{link}, {words.format_length(-gap)} inside it")


# ----------------------------------------------------------------
# A hand whose contacts are sites.


def make_contact_hand(hand: HandModel, near: list[LinkContact]) -> HandModel:
    """The hand with these sites as its fingertips, named by their links and numbered where a link has several."""
    model, counts, seen = hand.model, Counter(site.link.name for site in near), Counter[str]()
    names, frames, places, shapes = [], [], [], []
    taken = {frame.name for frame in model.frames}
    for site in near:
        link = site.link.name
        seen[link] += 1
        names.append(f"{link} {seen[link]}" if counts[link] > 1 else link)
        about, shape = site.shape.middle, site.shape
        at = read_only(shape.translation - about)
        face = None if shape.face is None else shape.face._replace(centre=read_only(shape.face.centre - about))
        central = shape.radius is not None and not at.any()
        shapes.append((replace(shape, translation=at, face=face, is_central=central),))
        place = site.link.place.placement * pin.SE3(np.eye(3), about.copy())
        marked = names[-1] if names[-1] not in taken else f"{names[-1]} (contact)"
        carrier = site.link.place
        frame = pin.Frame(marked, carrier.joint, carrier.link, place, pin.FrameType.OP_FRAME)
        frames.append(int(model.addFrame(frame)))
        places.append(TipPlacement(carrier.link, carrier.joint, place))
    support = np.array([site.link.support for site in near]).reshape(len(near), 1, -1)
    tips = TipFrames(tuple(names), tuple(frames), tuple(places), support)
    pads = np.array([site.link.pad for site in near]).reshape(-1, 3, 3)
    return hand.with_parts(
        tips=tips,
        fingertips=tips.names,
        kinematics=Kinematics(model, hand.kinematics.facts),
        pads=FingertipPads(pads),
        links_of_sites=tuple(site.link.name for site in near),
        own_tips=hand.fingertips,
        _geometry=TipGeometry.from_shapes(hand.description, tips, shapes),
    )


def expand_link_values(argument: str, value: Any, hand: HandModel) -> Any:
    """What was said by link, by site: a mapping whose keys are sites or links. Anything else stays as it is.

    Raises UnknownName for what is neither; what is said of a link that does not touch is left out.
    """
    of = hand.links_of_sites
    if of is None or not isinstance(value, Mapping):
        return value
    links = (*dict.fromkeys(of), *hand.own_tips, *contact_body_names(hand))
    if unknown := [str(name) for name in value if name not in hand.fingertips and name not in links]:
        raise UnknownName(argument, "a link", unknown, tuple(dict.fromkeys((*hand.fingertips, *links))))
    said = {site: value[link] for site, link in zip(hand.fingertips, of, strict=True) if link in value}
    return said | {site: value[site] for site in hand.fingertips if site in value}
