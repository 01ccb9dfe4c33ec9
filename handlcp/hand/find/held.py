"""How hard a grasp may be pushed in the direction in which it holds least, and whether it only lies there.

An object that lies on a fingertip is held as long as its weight presses it there. So the push comes in six directions
beside the weight, along the world's axes through the reference. What is said to be held is: each push was solved and
certified, in the posture of the grasp, and no joint is past its torque limit. Pushes grow by a factor of two, then by
its fourth root, as long as all six are held.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.hand.hand_grasp import HandGrasp

_PUSHES = np.hstack([np.vstack([np.eye(3), -np.eye(3)]), np.zeros((6, 3))])
_FIRST, _DOUBLED, _FINER = 0.01, 9, 2.0 ** (0.25 * np.arange(1, 4))  # of the size of the forces; how often


def held_force(grasp: HandGrasp, solution: GraspSolution) -> float:
    """The largest force [N] that is held beside the load in each of six directions; 0 where the least is not.

    solution : the answer of the grasp.
    """
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


def lies_there(grasp: HandGrasp) -> bool:
    """Whether it is the weight that holds the object: turned round, it is not held. A grasp without load does not."""
    return bool(grasp.spec.wrench.any()) and not _all_held(grasp, -2.0 * grasp.spec.wrench[None])


def _all_held(grasp: HandGrasp, pushes: Iterable[Array]) -> bool:
    """Whether one solve holds each of the pushes (6,) beside the load."""
    spec = grasp.spec
    pushed = [HandGrasp(spec.replace(wrench=read_only(spec.wrench + push))) for push in pushes]
    return all(s.held and _within(s) for s in solve_many(pushed, "cone", workers=1, proof=False))


def _within(solution: Any) -> bool:
    """Whether no joint is past its torque limit."""
    return bool(solution.torque_check.utilisation.max(initial=0.0) <= 1.0)
