"""Effects that a hand's grasp leaves out, each evaluated once at an answer: limits, own weight, geometric stiffness."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import read_only
from handlcp.grasp import arguments
from handlcp.grasp.changed import changed
from handlcp.grasp.effects import GeometricStiffness, TorqueSaturation
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.suggest import Suggestion, change_of, of_force, percent
from handlcp.hand.weight import WEIGHT

if TYPE_CHECKING:
    from handlcp.hand.grasp import HandGrasp
    from handlcp.hand.solution import HandGraspSolution

__all__ = ["hand_left_out"]


def hand_left_out(grasp: HandGrasp, solution: HandGraspSolution, faces: int | str | Pyramid) -> Iterator[Suggestion]:
    """What only a hand can leave out, as far as it is left out."""
    kinds = {type(e) for e in grasp.effects}
    bends = GeometricStiffness in kinds
    if TorqueSaturation not in kinds and not bends:
        yield from _saturation(grasp, solution, faces)
    if not grasp.finger_weight and grasp.given_gravity.any() and not bends:
        yield _weight(grasp, solution, faces)
    if not (bends or grasp.scene.soft or TorqueSaturation in kinds):
        yield _geometric(grasp, solution, faces)


def _saturation(grasp: HandGrasp, solution: HandGraspSolution, faces: int | str | Pyramid) -> Iterator[Suggestion]:
    """Where a joint is asked for more than it has."""
    over = solution.torque_check.over
    if not over:
        if known := [r for r in solution.torque_check if r.known]:
            words = f"all joints within their limits, {max(r.utilisation for r in known):.0%} at most"
            yield Suggestion(TorqueSaturation.title, 0.0, words, "effects=[TorqueSaturation()]")
        return
    worst = max(over, key=lambda r: r.utilisation)
    s = change_of(
        grasp, _completed(grasp, (*grasp.effects, TorqueSaturation())), solution, faces, TorqueSaturation.title,
        "effects=[TorqueSaturation()]",
    )  # fmt: skip
    change = max(s.change, worst.utilisation - 1.0)
    yield replace(s, change=change, words=f"{worst.joint} at {100 * worst.utilisation:.3g} % of its limit: {s.words}")


def _weight(grasp: HandGrasp, solution: HandGraspSolution, faces: int | str | Pyramid) -> Suggestion:
    """The fingers' weight, in torques and elastic balance."""
    hand, gravity = grasp.state.hand, grasp.given_gravity
    weigh = read_only(hand.kinematics.gravity_torque(grasp.state.q, gravity))
    heavy = copy.copy(grasp)
    heavy.finger_weight, heavy.gravity, heavy.gravity_torque = True, gravity, weigh
    heavy.sag = read_only(hand.stiffness.deflection(weigh))
    heavy = _completed(changed(heavy, offset=heavy._shifted(grasp.tip_offset)), grasp.effects)
    s = change_of(grasp, heavy, solution, faces, WEIGHT.title, "finger_weight=True")
    held = float(abs(solution.torques).max()) or 1.0
    k = int(abs(weigh).argmax())
    share = float(abs(weigh[k])) / held
    if share <= s.change:
        return s
    return replace(s, change=share, words=f"{percent(share)} of the largest torque, at {hand.joint_names[k]}")


def _geometric(grasp: HandGrasp, solution: HandGraspSolution, faces: int | str | Pyramid) -> Suggestion:
    """One correction of the flexibility, under the answer's own forces."""
    share = grasp.geometric_change(solution, faces)
    k = int(np.argmax(share))
    words = of_force(grasp, k, share[k])
    if not math.isfinite(share[k]):
        words = "fingers buckle under their forces, or there is no equilibrium with it"
    return Suggestion(GeometricStiffness.title, float(share[k]), words, "effects=[GeometricStiffness()]")


def _completed(grasp: HandGrasp, effects: tuple[object, ...]) -> HandGrasp:
    """With these effects, told of the joints as they are in this grasp."""
    scene = grasp.scene
    return changed(grasp, effects=arguments.effects(effects, scene.n, grasp.joints, scene.fingers))
