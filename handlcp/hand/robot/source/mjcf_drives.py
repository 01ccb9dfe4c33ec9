"""What drives the joints of an MJCF model: torque limits from its actuators, couplings from its equalities."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.hand.robot.doubt import Doubt

_JOINT, _IN_PARENT, _TENDON = 0, 1, 3  # what an actuator moves
_OF_JOINTS, _WRAPS_JOINT = 2, 1  # an equality of joints; a tendon that is a sum of joint angles

Follows = dict[int, tuple[int, float, float]]  # joint → the joint it follows, factor, offset


def efforts(model: Any, names: list[str]) -> tuple[Array, list[Doubt]]:
    """(joints,) largest torque or force of each joint's actuators [N·m, N]; inf where the file says none. And a doubt
    for each tendon that moves several joints.
    """
    force = np.full(model.njnt, np.inf)
    pulled = dict[str, dict[int, float]]()
    for a in range(model.nu):
        most, what, target = _most(model, a), int(model.actuator_trntype[a]), int(model.actuator_trnid[a, 0])
        if what in (_JOINT, _IN_PARENT):
            arms = {target: 1.0}
        elif what == _TENDON:
            arms = _arms(model, target)
            if len(arms) > 1:
                pulled[model.tendon(target).name or f"tendon {target}"] = arms
        else:
            continue
        for j, arm in arms.items():
            torque = abs(arm) * most
            force[j] = torque if np.isinf(force[j]) else force[j] + torque
    bounded = model.jnt_actfrclimited.astype(bool)
    force[bounded] = np.minimum(force[bounded], abs(model.jnt_actfrcrange[bounded]).max(axis=1))
    return force, _shared(pulled, names) if pulled else []


def _most(model: Any, a: int) -> float:
    """The largest force of an actuator times its gear; inf where none is said."""
    gear = abs(float(model.actuator_gear[a, 0]))
    if model.actuator_forcelimited[a]:
        return gear * float(abs(model.actuator_forcerange[a]).max())
    plain = int(model.actuator_gaintype[a]) == 0 and int(model.actuator_biastype[a]) == 0  # a motor
    if plain and model.actuator_ctrllimited[a]:
        return gear * float(abs(model.actuator_gainprm[a, 0]) * abs(model.actuator_ctrlrange[a]).max())
    return float("inf")


def _arms(model: Any, tendon: int) -> dict[int, float]:
    """Joints of a tendon that is a sum of joint angles, and their coefficients; none for one with a path in space."""
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    return {int(model.wrap_objid[w]): float(model.wrap_prm[w]) for w in wraps if model.wrap_type[w] == _WRAPS_JOINT}


def _shared(pulled: dict[str, dict[int, float]], names: list[str]) -> list[Doubt]:
    """Of tendons that pull several joints each."""
    joints = [names[j] for arms in pulled.values() for j in arms]
    first, arms = next(iter(pulled.items()))
    given = ", ".join(f"{names[j]!r}: {arm:g}" for j, arm in arms.items())
    what = f"one actuator pulls several of them by a tendon ({', '.join(pulled)}); here each has a spring of its own"
    advice = f"joint_stiffness=Tendons(...) with {{{first!r}: {{{given}}}, …}}"
    return [Doubt(", ".join(dict.fromkeys(joints)), what, advice, "serious", "tendon")]


def couplings(model: Any, names: list[str]) -> tuple[Follows, list[Doubt]]:
    """Joints that follow others, and doubts about constraints that are read in part or not at all."""
    follows, doubts = Follows(), list[Doubt]()
    for e in range(model.neq):
        if not model.eq_active0[e]:
            continue
        kind, name = int(model.eq_type[e]), model.eq(e).name or f"equality {e}"
        if kind != _OF_JOINTS or int(model.eq_obj2id[e]) < 0:
            what = f"the constraint {name!r} is left out: only couplings of two joints are read"
            doubts.append(Doubt("hand", what, "an MJCF file that couples joints by <equality><joint>", "serious"))
            continue
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        c0, c1, *curved = (float(x) for x in model.eq_data[e, :5])
        at_one, at_two = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (one, two))
        follows[one] = (two, c1, c0 + at_one - c1 * at_two)
        if any(curved):
            what = f"follows {names[two]} along a curve, of which the straight part alone is read"
            doubts.append(Doubt(names[one], what, "a posture near the file's reference posture", "serious"))
    return follows, doubts
