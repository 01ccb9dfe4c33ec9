"""Holdability within limits: is there a contact force within friction and the effects' limits that balances the load?

    W a = -load,  A F a ≤ b,  a ≥ 0

with a generator of the friction cones in every column of F, its wrench in W. If there is none, a twist t and motions
y ≥ 0 of what gives way prove it (Farkas): Wᵀt + (A F)ᵀy ≥ 0 and load·t > b·y. The object escapes along t while the
limits give way by y, and the load does more work on the one than the limits dissipate in the other. Stiffness and
preload play no part (the kinematic theorem of plastic limit analysis).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.holdable import generators, is_escape
from handlcp.grasp.verify.limits_at_answer import every_limit, stacked
from handlcp.tolerances import ACTIVE


def overload(scene: Scene, section: Section, effects: tuple[Effect, ...]) -> Array | None:
    """(dof + limits,) a certified proof (t, y) in natural units, limits in the effects' order; None: none gives way,
    or some force within all of them balances the load.
    """
    rows, room = stacked(scene, every_limit(scene, effects))
    if not len(room):
        return None
    from scipy.optimize import linprog  # half a second of import that only a failed solve should pay

    load, (F, W) = scene.natural.w, generators(scene, section)
    lp = linprog(
        np.append(-load, room),
        A_ub=-np.hstack([W.T, (rows @ F).T]),
        b_ub=np.zeros(W.shape[1]),
        bounds=[(-1.0, 1.0)] * scene.dof + [(0.0, 1.0)] * len(room),
        method="highs",
    )
    if lp.x is None or not lp.x[scene.dof :].max() > ACTIVE * abs(lp.x).max():
        return None  # without any limit nothing would hold the object: not a question of limits
    return lp.x if is_escape(scene, section, lp.x, effects) else None
