"""What the contacts, effects and joints of a grasp can bear, as cones and rows over its unknown forces.

    r_i ∈ friction,    A r ≤ b,    |Jᵀ r + g| ≤ τ_max

Stiffness and preload play no part. The rows carry the name of what they limit, so that an answer can say what binds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.friction import Cone, Section, limit_set
from handlcp.grasp.model.limit import Limit
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.conic import Cones
from handlcp.grasp.verify.holdable import generators, is_escape
from handlcp.grasp.verify.judge import every_limit, stacked
from handlcp.tolerances import ACTIVE

# ----------------------------------------------------------------
# Holdability within limits: is there a contact force within friction and the effects' limits that balances the load?
#
# W a = -load,  A F a ≤ b,  a ≥ 0
#
# with a generator of the friction cones in every column of F, its wrench in W. If there is none, a twist t and motions
# y ≥ 0 of what gives way prove it (Farkas): Wᵀt + (A F)ᵀy ≥ 0 and load·t > b·y. The object escapes along t while the
# limits give way by y, and the load does more work on the one than the limits dissipate in the other. Stiffness and
# preload play no part (the kinematic theorem of plastic limit analysis).


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


# ----------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Capacity:
    """Natural units, over the m unknown force components of a scene in the coordinates of its friction laws.

    G (k, m), h (k,) : h - G r lies in `cones`: the rows of pyramids, intervals and normals (h is 0), then those of
    limits, then the friction cones. contact (k,) : the contact of a row of friction, -1 for others. joint (k,), effect
    (k,) : the same for the torque of a joint, and for an effect among `effects`.
    equations (e, m), values (e,) : forces that are known, as equations. wrenches (dof, m).
    """

    G: Array
    h: Array
    cones: Cones
    contact: Ints
    joint: Ints
    effect: Ints
    effects: tuple[Effect, ...]
    equations: Array
    values: Array
    wrenches: Array


def capacity_of(scene: Scene, section: Section, effects: tuple[Effect, ...], torques: bool) -> Capacity:
    """Of a scene with these effects; torques : whether the joints' torque limits count, saturating or not."""
    own = scene.kind.contact_components
    place = np.full(scene.components, -1)
    index = scene.kind.index
    place[index] = np.arange(len(index))
    flat, owners, balls = friction_rows(scene, section, np.where(own >= 0, place[own], -1), len(index))
    beside = tuple([e for e in effects if not isinstance(e, TorqueSaturation)])
    rows, room, joint, effect = _limits(scene, beside, torques)
    equal = _pairs(rows, room)
    kept = ~equal.any(axis=0) & ~equal.any(axis=1)
    first = np.flatnonzero(equal.any(axis=1))
    k, cones = len(flat), [(d, len(part)) for d, (part, _) in sorted(balls.items())]
    lines = np.concatenate([flat, rows[kept][:, index]])
    curved = [np.concatenate(part) for _, (part, _) in sorted(balls.items())]
    of_curved = [np.repeat(who, d) for d, (_, who) in sorted(balls.items())]
    tail = sum(d * count for d, count in cones)
    none = np.full(tail, -1)
    return Capacity(
        np.concatenate([lines, *curved]), np.concatenate([np.zeros(k), room[kept], np.zeros(tail)]),
        Cones(len(lines), tuple(cones)), np.concatenate([owners, np.full(kept.sum(), -1), *of_curved]),
        np.concatenate([np.full(k, -1), joint[kept], none]), np.concatenate([np.full(k, -1), effect[kept], none]),
        beside, rows[first][:, index], room[first], scene.natural.every[:, index],
    )  # fmt: skip


def friction_rows(
    scene: Scene, section: Section, own: Ints, m: int
) -> tuple[Array, Ints, dict[int, tuple[list[Array], list[int]]]]:
    """Friction as rows over m forces, -G r in cones: flat ones (k, m) with the contact of each (k,); and by dimension
    the blocks of friction cones with theirs. own (n, 4) : where each contact's normal and tangents are among the
    forces; contacts with -1 in front are left out.
    """
    limits, flat, owners = scene.limits(section), list[Array](), list[int]()
    balls: dict[int, tuple[list[Array], list[int]]] = {}
    for i, (at, tangents) in enumerate(zip(own, scene.kind.tangents, strict=True)):
        if at[0] < 0:
            continue
        if tangents > 1 and isinstance(section, Cone):
            block = np.zeros((1 + tangents, m))
            block[0, at[0]] = -scene.mu[i]
            block[np.arange(1, 1 + tangents), at[1 : 1 + tangents]] = -1.0
            part, who = balls.setdefault(1 + tangents, ([], []))
            part.append(block)
            who.append(i)
            continue
        normals = limit_set(section, tangents).normals if tangents else np.zeros((0, 1))
        block = np.zeros((normals.shape[1], m))
        block[:, at[0]] = -limits[i]
        block[:, at[1 : 1 + tangents]] = normals.T
        block = block if len(block) else -np.eye(m)[at[0]][None]
        flat.append(block)
        owners += [i] * len(block)
    return np.concatenate([np.zeros((0, m)), *flat]), np.array(owners, dtype=np.int64), balls


def _limits(scene: Scene, effects: tuple[Effect, ...], torques: bool) -> tuple[Array, Array, Ints, Ints]:
    """Rows (k, c) and room (k,) of effects, then of joints, and of which joint (k,) or effect (k,) each is."""
    every = every_limit(scene, effects)
    rows, room = stacked(scene, every)
    which = [np.full(sum(len(limit.room) for limit in e.present(scene)), k) for k, e in enumerate(effects)]
    effect = np.concatenate([np.zeros(0, dtype=np.int64), *which])
    joint = np.full(len(room), -1)
    if torques and scene.mechanism is not None:
        motors = TorqueSaturation()
        both: tuple[Limit, ...] = motors.limits(scene)
        bounded, most = stacked(scene, both)
        _, _, joints = motors.limited(scene)
        rows, room = np.concatenate([rows, bounded]), np.concatenate([room, most])
        joint = np.concatenate([joint, joints, joints])
        effect = np.append(effect, np.full(len(most), -1))
    return rows, room, joint, effect


def _pairs(rows: Array, room: Array) -> Array:
    """(k, k) bool: row i and row j > i say that a force is what it is known to be: A_i = -A_j, b_i = -b_j."""
    k = len(rows)
    same = (rows[:, None] == -rows[None]).all(axis=2) & (room[:, None] == -room[None])
    return np.asarray(same & (np.arange(k)[:, None] < np.arange(k)[None]))
