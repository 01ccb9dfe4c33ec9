"""What a posture says about holding an object: joints past the ends of their ranges, links inside the object."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.errors import URDFError
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.cause.judge import Limits, exceeded, used
from handlcp.hand.objects.inside import Inside, links_inside
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.posture import Posture

_FAR = 0.05  # [rad]; past its range by more, the joint cannot be there
_TOUCHES = 2e-4  # [m] collision geometry is no more exact than that
_DEEP = 1e-3  # [m] a link deeper in the object cannot be there
_DEEP_BESIDE_TIP = 4e-3  # [m] the same of a link with a fingertip on the object, half the radius of a usual one


def posture_reasons(posture: Posture, obj: Object | None, tips: tuple[int, ...]) -> Iterator[Reason]:
    """Of a hand that touches an object with the fingertips numbered `tips`; None: an object that is not known."""
    yield from _ranges(posture)
    if obj is None:
        return
    try:
        inside = links_inside(posture, obj, tips)
    except URDFError as error:
        text = f"whether links are inside the object is not known: {error}"
        yield Reason("link_inside", "warning", text)
        return
    if not posture.hand.link_surfaces:
        text = "no link has collision geometry: whether links are inside the object is not checked"
        yield Reason("link_inside", "warning", text)
    seen = [one for one in inside if one.depth > _TOUCHES]
    for beside_tip, deep in ((False, _DEEP), (True, _DEEP_BESIDE_TIP)):
        for far in (True, False):
            these = [one for one in seen if (one.tip is not None) is beside_tip and (one.depth > deep) is far]
            if these:
                yield _inside(these, beside_tip, far)


def _inside(links: list[Inside], beside_tip: bool, far: bool) -> Reason:
    """Links of one kind, the deepest first."""
    values = {"links": [{"link": one.link, "depth_m": one.depth, "fingertip": one.tip} for one in links]}
    first, more = links[0], len(links) - 1
    who = f"{first.link} and {more} more link{'s' if more > 1 else ''} are up to" if more else f"{first.link} is"
    if beside_tip:
        than = "their fingertips" if more else f"its fingertip {first.tip}"
        text = f"{who} {words.length(first.depth)} deeper in the object than {than}"
    else:
        text = f"{who} {words.length(first.depth)} inside the object"
    if far:
        return Reason("link_inside", "decides", f"{text}: the hand cannot take this posture", values)
    return Reason("link_inside", "warning", f"{text}: only fingertips are taken to touch it", values)


def _ranges(posture: Posture) -> Iterator[Reason]:
    hand, q = posture.hand, posture.q
    past = np.maximum(hand.lower - q, q - hand.upper)
    limits = Limits((), hand.joint_names, hand.torque_limits, hand.lower, hand.upper)
    shares = used(limits, np.zeros(hand.nv), q)[hand.nv :]
    for k in np.flatnonzero(exceeded(shares)):
        name, by = hand.joint_names[k], float(past[k])
        kinds = {f.name: f.kind for f in hand.kinematics.facts}
        much = words.length(by) if kinds[name] == "prismatic" else words.angle(by)
        text = f"{name} is {much} past the end of its range"
        values = {"joint": name, "position": float(q[k]), "lower": float(hand.lower[k]), "upper": float(hand.upper[k])}
        if by > _FAR:
            yield Reason("joint_range", "decides", f"{text}: the hand cannot take this posture", values)
        else:
            yield Reason("joint_range", "warning", text, values)
