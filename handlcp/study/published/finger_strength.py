"""`finger_strength`: a fingertip against a fixed load cell, up to what its joints bear.

The tip presses with F n at a point p that does not move, and nothing across n, as on a cell that reads one axis and
slides freely across it. The joints then hold τ = Jᵀ n F, and F grows until the first of them is at its limit:

    F = min_j τ_max,j / |(Jᵀ n)_j|

the largest static force along n. A motor that stalls at more than the limit of the hand's file presses harder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only, unit
from handlcp.errors import InputError, URDFError
from handlcp.geometry import Box, Sphere
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.grasp.model.contact import Contact, contact_frame
from handlcp.hand import Hand, HandGrasp, HandGraspSolution, HandState
from handlcp.hand.closing import bending_rates
from handlcp.keywords import helped
from handlcp.progress import told
from handlcp.study.published.finger_result import FingerForce, FingerStrength

NEUTRAL, MIDDLE = "neutral", "middle"
_CELL = 0.02  # [m] edge of the load cell; its face is where the tip is highest along the axis
_AWAY = 1.0  # [m] at which the cell begins, before it comes to the tip
_AT = 1e-9  # relative, to which the limit is reached
_ROUNDS = 64  # tendons with a pretension come nearer by that share of their limit in each
_STILL = 1e-6  # of the joints' levers: a tip that moves by less when its joints bend has no direction of its own


@helped()
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
    way = None if direction is None else unit("direction", direction, (3,))
    speed = _closing(hand)
    rows = list[FingerForce]()
    with told("pressing on a load cell"):
        for name, state in _states(hand, postures).items():
            for tip in tips:
                rows.append(_pressed(state, tip, name, _way(state, tip, speed) if way is None else way))
    return FingerStrength(tuple(rows))


def _states(hand: Hand, postures: Any) -> dict[str, HandState]:
    """The postures by name. Raises InputError."""
    if postures is None:
        ranged = np.isfinite(hand.lower) & np.isfinite(hand.upper)
        middle = np.where(ranged, 0.5 * np.where(ranged, hand.lower + hand.upper, 0.0), hand.neutral)
        postures = {NEUTRAL: hand.neutral, MIDDLE: middle}
    if not isinstance(postures, Mapping) or not postures:
        raise InputError("postures", "a mapping of names to postures, at least one", repr(postures)[:80])
    return {str(name): hand.at(q) for name, q in postures.items()}


def _closing(hand: Hand) -> Array:
    """(nv,) how the joints that bend fingers turn, towards the middle of the fingertips of the neutral posture."""
    middle = hand.at(hand.neutral).tip_positions.mean(axis=0)
    return bending_rates(hand, hand.neutral, Sphere(_CELL, middle, mass=0.0))


def _way(state: HandState, tip: int, speed: Array) -> Array:
    """(3,) the way of a tip when joints turn with speeds (nv,). Raises InputError."""
    J = state.jacobian[3 * tip : 3 * tip + 3]
    way = J @ speed
    size = float(np.linalg.norm(way))
    if not size > _STILL * float(np.linalg.norm(J)):
        expected = f"the way in which {state.hand.fingertips[tip]} presses: no joint that bends it moves it"
        raise InputError("direction", expected, None)
    return read_only(way / size)


def _pressed(state: HandState, tip: int, posture: str, n: Array) -> FingerForce:
    """Press a tip against a load cell whose axis is n (3,), world axes, up to the first limit of its joints."""
    name, at = state.hand.fingertips[tip], _touched(state, tip, n)
    contact = Contact(at, n, 0.0)
    grasp = state.grasp({name: contact}, gravity=np.zeros(3), wrench=np.append(-n, np.zeros(3)), reference=at)
    force, solution, binds = _largest(grasp)
    return FingerForce(name, posture, force, n, at, binds, solution.torques, read_only(state.q.copy()))


def _touched(state: HandState, tip: int, n: Array) -> Array:
    """(3,) the point with which a tip touches a plane that it meets along n; its origin where it has no shape."""
    p, R = state.tip_positions[tip], state.tip_rotations[tip]
    try:
        shapes = state.hand.tip_shapes(tip)
    except URDFError:  # a link without geometry
        return read_only(p.copy())
    cell = Box((_CELL, _CELL, _CELL), pin.SE3(contact_frame(n), p + (_AWAY + 0.5 * _CELL) * n), mass=0.0)
    near = nearest_proximity(shapes, p, R, cell)
    return read_only(near.position - near.gap * n)


def _largest(grasp: HandGrasp) -> tuple[float, HandGraspSolution, str]:
    """The force [N], the solution under it, and what is at its limit. Torques are proportional to the force; the
    tension of a tendon begins with its pretension, and each round takes it nearer to its limit.
    """
    force, one = 1.0, grasp.spec.wrench
    for _ in range(_ROUNDS):
        solution = grasp.replace(wrench=force * one).solve()
        share, binds = _used(solution)
        if share == 0.0:
            return np.inf, solution, ""
        if abs(share - 1.0) <= _AT:
            break
        force /= share
    return force, solution, binds


def _used(solution: HandGraspSolution) -> tuple[float, str]:
    """The largest share of a limit, of joints and tendons, and whose it is."""
    check, effort = solution.torque_check, solution.effort
    shares = dict(zip(check.joints, check.utilisation.tolist(), strict=True))
    if effort is not None:
        shares |= dict(zip(effort.names, effort.used.tolist(), strict=True))
    who = max(shares, key=lambda name: shares[name])
    return shares[who], who
