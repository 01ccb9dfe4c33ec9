"""What is watched while a grasp is loaded: states of contacts and tendons, limits of torques and tensions, ends of
joint ranges, and how far contacts have slid.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, NumbersByName
from handlcp.grasp.failure.failure_mode import StateLimits, state_limits
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.geometry import Geometry

# ----------------------------------------------------------------
# How far contacts slide.

MAX_SLIP = 1e-3  # [m] by which a contact may slide, unless something else is said
_TIED = 1e-3  # of how far it may: contacts that are this near to it have slid as far together


def read_max_slip(value: Any, names: tuple[str, ...]) -> Array:
    """(n,) how far each contact may slide [m], from a number, inf, or numbers by contact. Raises InputError,
    UnknownName.
    """
    return NumbersByName("contact", above=0.0, finite=False, rest=MAX_SLIP).read("max_slip", value, names)


def is_at_max_slip(slipped: Array, max_slip: Array) -> Bools:
    """(n,) which contacts have slid as far as they may, or nearly so, where the first has."""
    return np.asarray(slipped >= (1.0 - _TIED) * max_slip)


# ----------------------------------------------------------------

_NEAR = 1e-6  # of the contacts' distances from their centre: fingertips no farther than this touch already
# What happens, by the codes of `write_events`; of tendons in place of joints beyond the last joint
_KINDS = (
    "opens", "touches", "slips", "sticks", "over limit", "within limit", "slackens", "tightens", "yields", "holds",
    "range end", "range",
)  # fmt: skip
_OF_TENDONS = {"over limit": "over tension", "within limit": "within tension"}


@dataclass(frozen=True, slots=True)
class Watch:
    """limits : of torques and ranges. near : gaps up to this are none [m]. max_slip (n,) : how far each contact may
    slide [m].
    """

    limits: StateLimits
    near: float
    max_slip: Array

    def names(self, code: int, who: int) -> tuple[str, str]:
        """(kind, who) of an event, as `write_events` numbers them."""
        kind, joints = _KINDS[code], self.limits.joints
        if code < 4:
            return kind, self.limits.names[who]
        if kind in ("slackens", "tightens"):
            return kind, self.limits.tendons[who]
        if kind in _OF_TENDONS and who >= len(joints):
            return _OF_TENDONS[kind], self.limits.tendons[who - len(joints)]
        return kind, joints[who]


def watch_of(spec: GraspSpec, geometry: Geometry, max_slip: Array) -> Watch:
    """All contacts and joints of a grasp. max_slip (n,) : as in `Watch`."""
    near = _NEAR * float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
    limits = state_limits(spec, ranges=geometry.follows)  # elsewhere joints are measured from the posture
    return Watch(limits, near, max_slip)
