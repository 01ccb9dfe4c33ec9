"""`make_contact_finder`: how a hand's fingertips find their contacts while the object moves, and how these turn.

In compiled code for balls on primitives, by detection for other shapes, on planes for contacts that were given without
an object.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from handlcp.check import Array
from handlcp.contact.moving_contact import GivenTips, SweptTips, write_ball_contacts, write_given_contacts
from handlcp.geometry.contact_tracker import ContactArrays, ContactTracker
from handlcp.geometry.object import Object
from handlcp.grasp.model.request import GraspSpec
from handlcp.robot.fingertip import TipShape

_NO_CORNER = np.full(3, np.nan)


class ContactFinder(Protocol):
    """Contacts of the first k of n fingertips. noise : of what is found, as a share of the object's size."""

    noise: float

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Fingertips stand at places (n, 3) with rotations turns (n, 3, 3); the object has moved by x ↦ R x + t. Writes
        the first k rows of positions (n, 3), normals (n, 3), gaps (n,), and of turn, shift (n, 3, 6) as `Touch` has
        them.
        """


def make_contact_finder(spec: GraspSpec, mechanism: Any) -> ContactFinder:
    """For the k fingers of a grasp. mechanism : its `HandMechanism`."""
    obj, hand = mechanism.target, mechanism.posture.hand
    if obj is None:
        return GivenContactFinder(spec, mechanism)
    shapes = [hand.tip_shapes(i) for i in mechanism.tips]
    if obj.known is not None and all(len(s) == 1 and s[0].swept_ball is not None for s in shapes):
        return SweptBallFinder(obj, [s[0] for s in shapes])
    return ContactTracker(obj, shapes)


class SweptBallFinder:
    """Fingertips that are swept balls, on an object whose surface is known in closed form."""

    noise = 0.0

    def __init__(self, obj: Object, tips: list[TipShape]) -> None:
        assert obj.known is not None  # `make_contact_finder` saw to it
        self.kind, self.sizes = obj.known[0], np.array(obj.known[1], dtype=float)
        self.own, self.at = np.ascontiguousarray(obj.placement.rotation), obj.placement.translation.copy()
        every = [tip.swept_ball for tip in tips]
        beside, spans, radii = (np.array([one[k] for one in every if one is not None], dtype=float) for k in range(3))
        corners = np.array([_NO_CORNER if tip.corner is None else tip.corner for tip in tips])
        self.swept = SweptTips(beside, spans, radii, corners)

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Find the contacts in these places, as `ContactFinder` documents."""
        write_ball_contacts(self.kind, self.sizes, R @ self.own, R @ self.at + t, places, turns, self.swept, *out)


class GivenContactFinder:
    """Points of the fingertips, on planes of the object."""

    noise = 0.0

    def __init__(self, spec: GraspSpec, mechanism: Any) -> None:
        k, tips, first = len(mechanism.tips), list(mechanism.tips), mechanism.posture
        turned, out = first.tip_rotations[tips], spec.frames[:k, :, 2].copy()
        points = np.einsum("nji,nj->ni", turned, spec.positions[:k] - first.tip_positions[tips])
        self.tips = GivenTips(points, np.einsum("nji,nj->ni", turned, out), spec.positions[:k].copy(), out)

    def __call__(self, places: Array, turns: Array, R: Array, t: Array, out: ContactArrays) -> None:
        """Find the contacts in these places, as `ContactFinder` documents."""
        write_given_contacts(self.tips, R, t, places, turns, *out)
