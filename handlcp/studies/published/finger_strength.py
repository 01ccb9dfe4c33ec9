"""`finger_strength`: finger strength: the force with which a fingertip presses on a fixed load cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, check_call, check_unit_vector, read_only
from handlcp.errors import InputError, URDFError
from handlcp.geometry import Box, Sphere
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.grasp.model.contact import Contact, contact_frame
from handlcp.hand import Hand, HandGrasp, HandGraspSolution, HandState
from handlcp.hand.closing import bending_rates
from handlcp.progress import track_progress
from handlcp.record import Record
from handlcp.words import TextTable, wrap_text

_SOURCE = "NIST SP 1227 (draft, October 2018), finger strength"


@dataclass(frozen=True, eq=False)
class FingerForce(Record):
    """How hard one fingertip presses on a load cell in one posture.

    finger, posture : names. force : the reading of the cell [N]; inf where no torque limit is known. direction (3,) :
    in which the tip presses, the cell's axis, world axes, which are those of the hand's base. at (3,) : the point of
    contact [m]. binds : the joint or the tendon at its limit; "" for none. torques (nv,) : of the joints then [N·m].
    q (nv,) : the posture [rad, m].
    """

    entries = (
        "finger", "posture", "force_N", "direction (3,)", "at_m (3,)", "binds", "torques_Nm (nv,)", "q_rad (nv,)",
    )  # fmt: skip

    finger: str
    posture: str
    force: float
    direction: Array
    at: Array
    binds: str
    torques: Array
    q: Array

    def __str__(self) -> str:
        limit = f"{self.binds} is at its limit" if self.binds else "no limit of its joints is known"
        return f"{self.finger}, {self.posture}: {_format_newtons(self.force)} N; {limit}"


@dataclass(frozen=True, eq=False)
class FingerStrength(Record):
    """How hard fingertips press on a fixed load cell; made by `finger_strength`.

    rows : one for each finger in each posture. source : the document that has the test.
    """

    entries = ("source", "weakest", "strongest", "rows")

    rows: tuple[FingerForce, ...]
    source: str = _SOURCE

    @property
    def weakest(self) -> FingerForce:
        """The row with the least force."""
        return min(self.rows, key=lambda row: row.force)

    @property
    def strongest(self) -> FingerForce:
        """The row with the largest force."""
        return max(self.rows, key=lambda row: row.force)

    def __str__(self) -> str:
        """What was asked, and a line for each finger in each posture."""
        head = "finger strength: each fingertip against a fixed load cell, until a joint is at its limit"
        rows = [(f"{row.finger}, {row.posture}", row.binds or "–", _format_newtons(row.force)) for row in self.rows]
        table = TextTable(("finger, posture", "at its limit", "force\nN"), tuple(rows), "<<>")
        return "\n".join([wrap_text(head, "  "), "", str(table)])

    def __repr__(self) -> str:
        weak, strong = self.weakest, self.strongest
        forces = f"{words.format_force(weak.force)} to {words.format_force(strong.force)}"
        return f"FingerStrength({forces}, {len(self.rows)} rows)"


def _format_newtons(force: float) -> str:
    return "any" if np.isinf(force) else f"{force:.3g}"


# ----------------------------------------------------------------
# `finger_strength`: a fingertip against a fixed load cell, up to what its joints bear.
#
# The tip presses with F n at a point p that does not move, and nothing across n, as on a cell that reads one axis and
# slides freely across it. The joints then hold τ = Jᵀ n F, and F grows until the first of them is at its limit:
#
#     F = min_j τ_max,j / |(Jᵀ n)_j|
#
# the largest static force along n. A motor that stalls at more than the limit of the hand's file presses harder.


NEUTRAL, MIDDLE = "neutral", "middle"
_CELL_EDGE = 0.02  # [m] edge of the load cell; its face is where the tip is highest along the axis
_CELL_DISTANCE = 1.0  # [m] at which the cell begins, before it comes to the tip
_LIMIT_TOLERANCE = 1e-9  # relative, to which the limit is reached
_MAX_ROUNDS = 64  # tendons with a pretension come nearer by that share of their limit in each
# Of the joints' levers: a tip that moves by less when its joints bend has no direction of its own
_MIN_TIP_MOTION = 1e-6


@check_call()
def finger_strength(
    hand: Hand,
    fingers: Sequence[str] | None = None,
    *,
    postures: Mapping[str, Any] | None = None,
    direction: Any = None,
) -> FingerStrength:
    """The force [N] with which each fingertip presses on a load cell that is fixed in front of it, as in NIST's test of
    finger strength (NIST SP 1227).

    fingers : names of fingertips; None: all. postures : by name, each as `hand.at` takes it; None: "neutral", the
        hand's neutral posture, and "middle", every joint in the middle of its range.
    direction : (3,) in which the tip presses, axes of the hand's base; None: the way in which the tip goes when the
        joints that bend this finger turn alike, as the hand closes from its neutral posture.

    The cell bears force along its axis alone. The limits are those by which postures are judged: of the hand's motors
    what they hold for good, else `torque_limits`; of tendons theirs. The finger's own weight is left out.
    Raises InputError, UnknownName; InputError where a tip has no way to press.
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    tips = hand.tip_numbers("fingers", fingers)
    way = None if direction is None else check_unit_vector("direction", direction, (3,))
    middle = hand.at(hand.neutral).tip_positions.mean(axis=0)
    speed = bending_rates(hand, hand.neutral, Sphere(_CELL_EDGE, middle, mass=0.0))
    rows = list[FingerForce]()
    with track_progress("pressing on a load cell"):
        for posture, state in _read_postures(hand, postures).items():
            for tip in tips:
                n, name = _closing_direction(state, tip, speed) if way is None else way, hand.fingertips[tip]
                at, pull = _contact_point(state, tip, n), np.append(-n, np.zeros(3))
                grasp = state.grasp({name: Contact(at, n, 0.0)}, gravity=np.zeros(3), wrench=pull, reference=at)
                force, solution, binds = _find_largest_force(grasp)
                q = read_only(state.q.copy())
                rows.append(FingerForce(name, posture, force, n, at, binds, solution.torques, q))
    return FingerStrength(tuple(rows))


def _read_postures(hand: Hand, postures: Any) -> dict[str, HandState]:
    """The postures by name. Raises InputError."""
    if postures is None:
        ranged = np.isfinite(hand.lower) & np.isfinite(hand.upper)
        middle = np.where(ranged, 0.5 * np.where(ranged, hand.lower + hand.upper, 0.0), hand.neutral)
        postures = {NEUTRAL: hand.neutral, MIDDLE: middle}
    if not isinstance(postures, Mapping) or not postures:
        raise InputError("postures", "a mapping of names to postures, at least one", repr(postures)[:80])
    return {str(name): hand.at(q) for name, q in postures.items()}


def _closing_direction(state: HandState, tip: int, speed: Array) -> Array:
    """(3,) the way of a tip when joints turn with speeds (nv,), as the hand closes. Raises InputError."""
    J = state.jacobian[3 * tip : 3 * tip + 3]
    way = J @ speed
    size = float(np.linalg.norm(way))
    if not size > _MIN_TIP_MOTION * float(np.linalg.norm(J)):
        expected = f"the way in which {state.hand.fingertips[tip]} presses: no joint that bends it moves it"
        raise InputError("direction", expected, None)
    return read_only(way / size)


def _contact_point(state: HandState, tip: int, n: Array) -> Array:
    """(3,) the point with which a tip touches a plane that it meets along n; its origin where it has no shape."""
    p, R = state.tip_positions[tip], state.tip_rotations[tip]
    try:
        shapes = state.hand.tip_shapes(tip)
    except URDFError:  # a link without geometry
        return read_only(p.copy())
    place = pin.SE3(contact_frame(n), p + (_CELL_DISTANCE + 0.5 * _CELL_EDGE) * n)
    near = nearest_proximity(shapes, p, R, Box(_CELL_EDGE, place, mass=0.0))
    return read_only(near.position - near.gap * n)


def _find_largest_force(grasp: HandGrasp) -> tuple[float, HandGraspSolution, str]:
    """The force [N], the solution under it, and what is at its limit. Torques are proportional to the force; the
    tension of a tendon begins with its pretension, and each round takes it nearer to its limit.
    """
    force, one = 1.0, grasp.spec.wrench
    for _ in range(_MAX_ROUNDS):
        solution = grasp.replace(wrench=force * one).solve()
        check, effort = solution.torque_check, solution.effort
        shares = dict(zip(check.joints, check.utilisation.tolist(), strict=True))
        if effort is not None:
            shares |= dict(zip(effort.names, effort.used.tolist(), strict=True))
        binds = max(shares, key=lambda name: shares[name])
        if shares[binds] == 0.0:
            return np.inf, solution, ""
        if abs(shares[binds] - 1.0) <= _LIMIT_TOLERANCE:
            break
        force /= shares[binds]
    return force, solution, binds
