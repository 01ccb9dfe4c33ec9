"""What drives the joints of an MJCF model: torque limits and servos from its actuators, couplings from its equalities,
springs and friction of the joints themselves.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.hand.robot.joints import TOGETHER, Doubt
from handlcp.hand.robot.source.mjcf_parts import MOVES_TENDON, add
from handlcp.hand.robot.source.mjcf_scene import of_scene, tied

_JOINT, _IN_PARENT = 0, 1  # what an actuator moves
_OF_JOINTS, _WRAPS_JOINT = 2, 1  # an equality of joints; a tendon that is a sum of joint angles
_CONNECTS, _BODY = 0, 1  # an equality in a point; of bodies, and not of sites
_FIXED, _AFFINE = 0, 1  # gains and biases of actuators

Follows = dict[int, tuple[int, float, float]]  # joint → the joint it follows, factor, offset

# ---------------------------------------------------------------- How hard actuators pull.


def efforts(model: Any, names: list[str], follows: Follows) -> tuple[Array, list[str], list[Doubt]]:
    """(joints, 2) torque or force of each joint's actuators to its smaller and to its larger side [N·m, N], inf where
    the file says none; the word of the file that says it; and doubts about tendons that move several joints, and about
    limits that no joint has on its own.
    """
    ends, said = np.zeros((model.njnt, 2)), [""] * model.njnt  # against and with the joint's axis
    free = np.ones(model.njnt, dtype=bool)
    pulled, limited = dict[str, dict[int, float]](), dict[str, list[int]]()
    for a in range(model.nu):
        own, word = _ends(model, a)
        arms = _moved(model, a)
        target = int(model.actuator_trnid[a, 0])
        if int(model.actuator_trntype[a]) == MOVES_TENDON and model.tendon_actfrclimited[target]:
            cut = np.clip(np.sort(own), *model.tendon_actfrcrange[target])
            own, word = (cut, "actuatorfrcrange") if (cut != np.sort(own)).any() else (own, word)
        if int(model.actuator_trntype[a]) == MOVES_TENDON and len(arms) > 1:
            pulled[model.tendon(target).name or f"tendon {target}"] = arms
        if np.isfinite(own).any() and any(arms.values()):
            limited[model.actuator(a).name or f"actuator {a}"] = [j for j, arm in arms.items() if arm]
        for j, arm in arms.items():
            ends[j] += np.sort(arm * own) if arm else 0.0
            said[j], free[j] = word, False
    ends[free] = -np.inf, np.inf
    for j in np.flatnonzero(model.jnt_actfrclimited).tolist():
        cut = np.clip(ends[j], *model.jnt_actfrcrange[j])
        if (cut != ends[j]).any():
            ends[j], said[j] = cut, "actuatorfrcrange"
    sides = np.sort(np.maximum(ends * (-1.0, 1.0), 0.0), axis=1)
    doubts = _shared(pulled, names) if pulled else []
    return sides, said, [*doubts, *_together(limited, names, follows)]


def _moved(model: Any, a: int) -> dict[int, float]:
    """Joints that an actuator moves, and how far its length changes with each, before its gear; none for one that pulls
    along a path in space.
    """
    what, target = int(model.actuator_trntype[a]), int(model.actuator_trnid[a, 0])
    if what in (_JOINT, _IN_PARENT):
        return {target: 1.0}
    if what != MOVES_TENDON:
        return {}
    first = int(model.tendon_adr[target])
    wraps = range(first, first + int(model.tendon_num[target]))
    return {int(model.wrap_objid[w]): float(model.wrap_prm[w]) for w in wraps if model.wrap_type[w] == _WRAPS_JOINT}


def _ends(model: Any, a: int) -> tuple[Array, str]:
    """(2,) the least and the largest force of an actuator times its gear, and the word that says them; ±inf where none
    is said.
    """
    gear = float(model.actuator_gear[a, 0])
    if model.actuator_forcelimited[a]:
        return gear * model.actuator_forcerange[a], "forcerange"
    plain = int(model.actuator_gaintype[a]) == _FIXED and int(model.actuator_biastype[a]) == 0  # a motor
    if plain and model.actuator_ctrllimited[a]:
        return gear * model.actuator_gainprm[a, 0] * model.actuator_ctrlrange[a], "ctrlrange of a motor"
    return np.array([-np.inf, np.inf]), ""


def _shared(pulled: dict[str, dict[int, float]], names: list[str]) -> list[Doubt]:
    """Of tendons that pull several joints each."""
    joints = [names[j] for arms in pulled.values() for j in arms]
    first, arms = next(iter(pulled.items()))
    given = ", ".join(f"{names[j]!r}: {arm:g}" for j, arm in arms.items())
    what = f"one actuator pulls several of them by a tendon ({', '.join(pulled)}); here each has a spring of its own"
    advice = f"joint_stiffness=Tendons(...) with {{{first!r}: {{{given}}}, …}}"
    return [Doubt(", ".join(dict.fromkeys(joints)), what, advice, "serious", "tendon")]


def _together(limited: dict[str, list[int]], names: list[str], follows: Follows) -> list[Doubt]:
    """Of limits that are those of actuators, and of no joint alone: where a joint has several actuators one of which
    moves other joints, too, and where one drives a joint that follows another. limited : actuator → the joints that it
    moves. Where one actuator alone moves several joints, it pulls no harder than the joint asks that asks for most.
    """
    reached = dict[int, list[str]]()
    for actuator, joints in limited.items():
        for j in joints:
            reached.setdefault(j, []).append(actuator)
    mixed = [a for a, joints in limited.items() if len(joints) > 1 and any(len(reached[j]) > 1 for j in joints)]
    found = dict.fromkeys(mixed)
    found |= dict.fromkeys([a for j, those in reached.items() if set(those) & set(mixed) for a in those])
    found |= dict.fromkeys([a for a, joints in limited.items() if any(j in follows for j in joints)])
    if not found:
        return []
    moved = dict.fromkeys([names[_leader(follows, j)] for a in found for j in limited[a]])
    what = (
        f"limits of actuators that move several joints, or one that follows another, are read joint by joint "
        f"({words.listed(list(found))}): what the motors hold is not judged"
    )
    advice = "torque_limits of these joints, as large as the actuators can hold together"
    return [Doubt(", ".join(moved), what, advice, "serious", TOGETHER)]


# ----------------------------------------------------------------
# Position servos: force = g u + b₀ + b₁ l, so that kp = -b₁, whatever the gain g; l = gear × joint angle or tendon.


def write_servos(root: ET.Element, model: Any, names: list[str]) -> dict[int, float]:
    """Write each that moves joints by fixed arms as a <servo> with kp times the gear squared and the arm of each joint.
    Returns number of the actuator → that kp, of all.
    """
    found = dict[int, float]()
    for a in range(model.nu):
        kp, gear = -float(model.actuator_biasprm[a, 1]), float(model.actuator_gear[a, 0])
        if int(model.actuator_gaintype[a]) != _FIXED or int(model.actuator_biastype[a]) != _AFFINE or kp <= 0.0:
            continue
        found[a] = kp * gear * gear
        if arms := _moved(model, a):
            servo = add(root, "servo", name=model.actuator(a).name or f"actuator {a}", kp=found[a])
            for j, arm in arms.items():
                add(servo, "arm", joint=names[j], per_rad=arm)
    return found


def reaches(model: Any) -> dict[int, tuple[float, float]]:
    """Joint → where its own servo can be told to go [rad, m]."""
    found = dict[int, tuple[float, float]]()
    for a in range(model.nu):
        gain, kp, gear = (
            float(x) for x in (model.actuator_gainprm[a, 0], -model.actuator_biasprm[a, 1], model.actuator_gear[a, 0])
        )
        own = int(model.actuator_trntype[a]) in (_JOINT, _IN_PARENT) and int(model.actuator_biastype[a]) == _AFFINE
        if own and kp > 0.0 and gear and model.actuator_ctrllimited[a]:
            low, high = sorted((gain * u + float(model.actuator_biasprm[a, 0])) / (kp * gear)
                               for u in model.actuator_ctrlrange[a])  # fmt: skip
            found[int(model.actuator_trnid[a, 0])] = (low, high)
    return found


def write_passive(joint: ET.Element, model: Any, j: int) -> None:
    """What resists the joint itself: friction as a URDF has it, spring, rest and armature in a tag of its own."""
    dof, at = int(model.jnt_dofadr[j]), int(model.jnt_qposadr[j])
    add(joint, "dynamics", damping=float(model.dof_damping[dof]), friction=float(model.dof_frictionloss[dof]))
    add(joint, "passive", stiffness=float(np.ravel(model.jnt_stiffness[j])[0]), rest=float(model.qpos_spring[at]),
        armature=float(model.dof_armature[dof]))  # fmt: skip


# ---------------------------------------------------------------- Joints that follow others.


def couplings(model: Any, names: list[str], scene: frozenset[int]) -> tuple[Follows, list[Doubt]]:
    """Joints that follow others, also one after the other, and doubts about constraints that are read in part or not at
    all. Where an equality's first joint follows another already, the second one follows the first. scene : bodies that
    are no part of the hand, whose constraints are left out with them.
    """
    follows, doubts = Follows(), list[Doubt]()
    for e in range(model.neq):
        if not model.eq_active0[e] or of_scene(model, e, scene):
            continue
        kind, name = int(model.eq_type[e]), model.eq(e).name or f"equality {e}"
        if kind != _OF_JOINTS or int(model.eq_obj2id[e]) < 0:
            what = f"the constraint {name!r} is left out: only couplings of two joints are read"
            doubts.append(Doubt("hand", what, "an MJCF file that couples joints by <equality><joint>", "serious"))
            continue
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        c0, c1, *curved = (float(x) for x in model.eq_data[e, :5])
        at_one, at_two = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (one, two))
        offset = c0 + at_one - c1 * at_two
        if one not in follows:
            follows[one] = (two, c1, offset)
        elif two not in follows and c1 and _leader(follows, one) != two:
            follows[two] = (one, 1.0 / c1, -offset / c1)
        else:
            what = f"the constraint {name!r} is left out: {names[one]} and {names[two]} are coupled by others already"
            doubts.append(
                Doubt(f"{names[one]}, {names[two]}", what, "one coupling for each joint", "serious", "coupling")
            )
        if any(curved):
            what = f"follows {names[two]} along a curve, of which the straight part alone is read"
            doubts.append(Doubt(names[one], what, "a posture near the file's reference posture", "serious"))
    return follows, doubts


def write_pins(root: ET.Element, model: Any, bodies: list[str], scene: frozenset[int]) -> None:
    """Write each constraint that connects two bodies in a point as a <pin>, with the point in the frame of each [m]."""
    for e in range(model.neq):
        own = tied(model, e)
        if int(model.eq_type[e]) != _CONNECTS or not model.eq_active0[e] or len(own) != 2 or of_scene(model, e, scene):
            continue
        if int(model.eq_objtype[e]) == _BODY:
            at, other = model.eq_data[e, :3], model.eq_data[e, 3:6]
        else:
            at, other = (model.site_pos[int(i)] for i in (model.eq_obj1id[e], model.eq_obj2id[e]))
        add(root, "pin", link=bodies[own[0]], other=bodies[own[1]], at=at, at_other=other)


def _leader(follows: Follows, j: int) -> int:
    """The joint at the end of a chain; the one where it meets itself, if it is a circle."""
    seen = {j}
    while j in follows and (j := follows[j][0]) not in seen:
        seen.add(j)
    return j
