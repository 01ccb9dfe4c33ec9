"""How hard a grasp may be pushed in the direction in which it holds least, and whether it only lies there.

An object that lies on a fingertip is held as long as its weight presses it there. So the push comes in six directions
beside the load, along the world's axes through the reference.

Solved: each push was solved and certified, in the posture of the grasp, and no joint is past its torque limit. Pushes
grow by a factor of two, then by its fourth root, as long as all six are held. It is quick, and knows no path.
Followed: the hand closes, the load comes, and then each push grows until something gives out.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import as_section
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.followed import Before, anything_else
from handlcp.grasp.model.contact import AXIS_DIRECTIONS
from handlcp.grasp.path.advance import PATIENT, Patience
from handlcp.grasp.path.state import STILL
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.hand.hand_grasp import HandGrasp

_PUSHES = read_only(np.hstack([AXIS_DIRECTIONS, np.zeros((6, 3))]))
_NOTHING = 1e-12  # of the load: no more is what rounding leaves of a load beside the weight
_FIRST, _DOUBLED, _FINER = 0.01, 9, 2.0 ** (0.25 * np.arange(1, 4))  # of the size of the forces; how often


class Held(NamedTuple):
    """force : the largest [N] that is held beside the load in each of six directions; 0 where the load is not. cradled
    : whether it is the load that holds the object: turned round, it is not held. A grasp without load is not. gives_out
    : what gives out first under that force, in words; "" where that is not known.

    Of a cradle that was followed the force is the one against the load alone.
    """

    force: float
    cradled: bool
    gives_out: str = ""


def solved(grasp: HandGrasp, solution: GraspSolution) -> Held:
    """As single solves say it. solution : the answer of the grasp."""
    load = grasp.spec.wrench
    return Held(_force(grasp, solution), bool(load.any()) and not _all_held(grasp, -2.0 * load[None]))


def followed(grasp: HandGrasp, least: float = 0.0, patience: Patience = PATIENT) -> Held | None:
    """As paths say it; None: the load alone is not held, or in some direction no more than `least` [N]. patience : with
    each path. Raises Unsupported for what cannot be followed.
    """
    spec, section = grasp.spec, as_section("cone", planar=False)
    load = spec.wrench
    beside = load - grasp.mechanism.weight_of_object(spec.reference)
    beside = beside if abs(beside).max() > _NOTHING * abs(load).max() else STILL
    before = Before(spec, section, anything_else(spec), beside=beside, patience=patience)
    if not before.held:
        return None
    if load.any() and (turned := before.limit(-2.0 * load, until=1.0)).factor < 1.0:
        return Held(2.0 * turned.factor * float(np.linalg.norm(load[:3])), True, describe_failures(turned.binds, spec))
    force, gives_out = np.inf, ""
    for k in np.argsort(before.bounds(_PUSHES), kind="stable"):  # what holds more than a weaker one does not matter
        limit = before.limit(_PUSHES[k], until=force)
        if limit.factor < force:
            force, gives_out = limit.factor, describe_failures(limit.binds, spec)
        if force <= least:
            return None
    return Held(force, False, gives_out)


def _force(grasp: HandGrasp, solution: GraspSolution) -> float:
    """By single solves."""
    size = max(float(np.linalg.norm(grasp.spec.wrench[:3])), float(solution.normal_force.sum()))
    most = 0.0
    for level in _FIRST * size * 2.0 ** np.arange(_DOUBLED):
        if not _all_held(grasp, level * _PUSHES):
            break
        most = float(level)
    for share in _FINER if most else ():
        if not _all_held(grasp, share * most * _PUSHES):
            break
        best = share * most
    else:
        return most * (float(_FINER[-1]) if most else 0.0)
    return most if share == _FINER[0] else float(best)


def _all_held(grasp: HandGrasp, pushes: Iterable[Array]) -> bool:
    """Whether one solve holds each of the pushes (6,) beside the load."""
    spec = grasp.spec
    pushed = [HandGrasp(spec.replace(wrench=read_only(spec.wrench + push))) for push in pushes]
    return all(s.held and _within(s) for s in solve_many(pushed, "cone", workers=1, proof=False))


def _within(solution: Any) -> bool:
    """Whether no joint is past its torque limit."""
    return bool(solution.torque_check.utilisation.max(initial=0.0) <= 1.0)
