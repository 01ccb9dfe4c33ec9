"""`Capacity`: holdability: is there any contact force within friction that balances the load? Compliance plays no part.

If not, a twist t proves it (Farkas): every force the contacts can exert does work ≥ 0 on t, and so does the load, > 0.
The object escapes along t, and no contact resists.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Cone, Section, limit_set
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.model.effect import Limit
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.certifier import effect_limits, stack_limits
from handlcp.grasp.verify.contact_state import BALANCED, ESCAPES, find_escape
from handlcp.lazy_property import lazy_property
from handlcp.tolerances import ACTIVE_TOLERANCE, CERTIFY_TOLERANCE


def find_escape_twist(scene: Scene, section: Section) -> Array | None:
    """(6,) certified motion about the contacts' centre in which the object escapes, for one metre of travel.

    None: some forces within friction balance the load, or no proof was found that none does.
    """
    t = np.zeros(scene.dof)
    own, full_G = scene.kind.contact_components, scene.natural.full_G
    found = find_escape(full_G, scene.natural.w, own, scene.friction_coefficients(section), section.faces, t)
    if found == BALANCED:
        return None
    if found == ESCAPES:
        return escape_in_si(scene, t)
    # A linear program's vertex keeps every sign, but is an arbitrary one of the motions in which it escapes
    load, (_, W) = scene.natural.w, edge_forces(scene, section)
    W = W if W.size else np.zeros((scene.dof, 1))
    lp = scipy.optimize.linprog(
        -load, A_ub=-W.T, b_ub=np.zeros(W.shape[1]), bounds=[(-1.0, 1.0)] * scene.dof, method="highs"
    )
    return escape_in_si(scene, lp.x) if lp.x is not None and is_escape(scene, section, lp.x) else None


def escape_in_si(scene: Scene, t: Array) -> Array:
    """(6,) the motion t (dof,), natural units, in SI, for one metre of travel."""
    return read_only(scene.twist(t / float(np.sqrt(t @ t))) / scene.units.motion_unit)


def is_escape(scene: Scene, section: Section, proof: Array, effects: tuple[Effect, ...] = ()) -> bool:
    """Whether a twist t (dof,), natural units, proves that nothing balances the load; or t and, behind it, motions y of
    the effects' limits, that nothing within those does (`prove_overload`). Signs recomputed, no solver involved.

    The gain must exceed what the resisting work could hide: forces of a thousand times the load.
    """
    rows, room = stack_limits(scene, effect_limits(scene, effects))
    load, (F, W) = scene.natural.w, edge_forces(scene, section)
    if proof.shape != (scene.dof + len(room),) or not np.isfinite(proof).all():
        return False
    t, y = np.split(proof, [scene.dof])
    resisting = float(np.minimum(W.T @ t + (rows @ F).T @ y, 0.0).sum() + 1e3 * np.minimum(y, 0.0).sum())
    gain = float(load @ t - room @ y)
    size = float(np.sqrt(load @ load) * np.sqrt(t @ t) + abs(room) @ abs(y))
    return gain > CERTIFY_TOLERANCE * size and gain > -1e3 * resisting


def least_normal_sum(scene: Scene, section: Section) -> float | None:
    """Least sum of the fingers' unknown normal forces [N] with which friction balances the load; None: none does."""
    F, W = edge_forces(scene, section)
    if not W.size:
        return None
    normals = F[2 : 3 * (scene.n - scene.environment) : 3]  # each generator has a normal force of one, its finger's
    lp = scipy.optimize.linprog(normals.sum(axis=0), A_eq=W, b_eq=-scene.natural.w, method="highs")
    return None if lp.x is None else float(lp.fun) * scene.units.force_unit


def is_jammed(scene: Scene) -> bool:
    """Whether rigid fingers overlap the object wherever it goes: no small motion of it opens all gaps."""
    m = len(scene.kind.normal_index)
    if scene.kind.flexible or not m:
        return False
    G, d = scene.natural.G[:, :m], scene.natural.d[:m]
    # The widest least gap g: gaps Gᵀu + d ≥ g
    A = np.column_stack([-G.T, np.ones(len(d))])
    size = float(abs(d).max())
    free: list[tuple[float | None, float | None]] = [(None, None)] * scene.dof
    lp = scipy.optimize.linprog(
        np.append(np.zeros(scene.dof), -1.0), A_ub=A, b_ub=d, bounds=[*free, (None, size)], method="highs"
    )
    return lp.x is not None and float(lp.x[-1]) < -CERTIFY_TOLERANCE * size


def edge_forces(scene: Scene, section: Section) -> tuple[Array, Array]:
    """(c, g) forces along the edges of all friction pyramids (the normals where there is no friction), each with a
    normal force of one; and their (dof, g) wrenches.
    """
    limits, parts = scene.friction_coefficients(section), []
    for own, tangents, limit in zip(scene.kind.contact_components, scene.kind.tangent_count, limits, strict=True):
        if own[0] < 0:
            continue
        edges = limit * limit_set(section, tangents).vertices if tangents else np.zeros((0, 1))
        part = np.zeros((scene.components, edges.shape[1]))
        part[own[1 : 1 + tangents]], part[own[0]] = edges, 1.0
        parts.append(part)
    forces = np.hstack(parts) if parts else np.zeros((scene.components, 0))
    return forces, scene.natural.full_G @ forces


# ----------------------------------------------------------------
# Small conic programs that share their cones: linear rows and second-order cones, solved by Clarabel.
#
#     min cᵀx    A_k x = b_k,    G x + s = h_k,    s ∈ K = R₊^l × Q_3 × … × Q_4 × …,    Q_d = {(t, u) : t ≥ |u|}
#
# An end, a ray along which the cost falls for ever, and a proof that nothing fits are what Clarabel proposes; each is
# measured here, by what it misses of its equations and by the gap between the cost and what the multipliers prove.
# Source: Goulart & Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives (2024).


STOPPED, ENDED, UNBOUNDED, NOTHING_FITS = 0, 1, 2, 3
_ASKED_GAP = 1e-12  # relative: what is asked for; where rounding allows no more, Clarabel stops with what it has
_END_GAP = 1e-5  # a gap up to this is an end
_PROOF_TOLERANCE = 1e-9  # how far a ray or a proof may miss its equations


class ConeProduct:
    """The cones of m rows: `linear` half-lines, then so many second-order cones of each dimension, in order."""

    def __init__(self, linear: int, more: tuple[tuple[int, int], ...]) -> None:
        """Make the product of so many half-lines and of second-order cones, (dimension, count) each."""
        self.linear, self.second_order = linear, tuple([(d, count) for d, count in more if count])
        self.rows = linear + sum(d * count for d, count in self.second_order)

    @lazy_property
    def unit(self) -> Array:
        """The unit element e (m,) of the cones: 1 on half-lines, (1, 0, …) on cones."""
        cones = [np.tile(np.append(1.0, np.zeros(d - 1)), count) for d, count in self.second_order]
        return np.concatenate([np.ones(self.linear), *cones])


class ConicPrograms(NamedTuple):
    """p programs of v unknowns, e equations and m rows: c (v,), A (p, e, v), b (p, e), G (m, v), h (p, m)."""

    c: Array
    A: Array
    b: Array
    G: Array
    h: Array
    cones: ConeProduct


@dataclass(frozen=True, slots=True, eq=False)
class ConicEnds:
    """Where p programs ended. status (p,) : one of the words above. x (p, v), z (p, m) multipliers of the rows; of a
    ray where the status is UNBOUNDED. gap (p,) : what separates the cost from a lower bound on it, or what equations
    are missed by, relative to the larger of one and the cost.
    """

    status: Ints
    x: Array
    z: Array
    gap: Array


def solve_conic(programs: ConicPrograms) -> ConicEnds:
    """All of them; where a program stops short of its end, the status says so and the gap how far."""
    p, _, v = programs.A.shape
    m = len(programs.G)
    ends = ConicEnds(np.zeros(p, dtype=np.int64), np.full((p, v), np.nan), np.full((p, m), np.nan), np.full(p, np.inf))
    for k, x, y, z, s in _proposals(programs):
        if not all(np.isfinite(a).all() for a in (x, y, z, s)):
            continue
        status, gap, size = assess_end(programs, k, x, y, z, s)
        ends.status[k], ends.gap[k], ends.x[k], ends.z[k] = status, gap, x / size, z / size
    return ends


def _proposals(programs: ConicPrograms) -> Iterator[tuple[int, Array, Array, Array, Array]]:
    """(k, x, y, z, s) of every program, as Clarabel leaves them."""
    import clarabel  # a tenth of a second, with sparse matrices, that only bounds should pay

    e, m = programs.A.shape[1], len(programs.G)
    kinds, settings = _clarabel_setup(e, programs.cones)
    none = scipy.sparse.csc_matrix((len(programs.c), len(programs.c)))
    for k in range(len(programs.A)):
        rows = scipy.sparse.csc_matrix(np.concatenate([programs.A[k], programs.G]))
        right = np.concatenate([programs.b[k], programs.h[k]])
        found = clarabel.DefaultSolver(none, programs.c, rows, right, kinds, settings).solve()
        x, z, s = (np.asarray(a, dtype=np.float64) for a in (found.x, found.z, found.s))
        yield k, x, z[:e], z[e : e + m], s[e : e + m]


def _clarabel_setup(equations: int, cones: ConeProduct) -> tuple[list[Any], Any]:
    """Clarabel's cones, of so many equations and then of these cones, and its settings."""
    import clarabel

    kinds: list[Any] = [clarabel.ZeroConeT(equations)] if equations else []
    kinds += [clarabel.NonnegativeConeT(cones.linear)] if cones.linear else []
    kinds += [clarabel.SecondOrderConeT(d) for d, count in cones.second_order for _ in range(count)]
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _ASKED_GAP
    settings.tol_infeas_abs = settings.tol_infeas_rel = 1e-3 * _PROOF_TOLERANCE  # its measure is another one
    return kinds, settings


def find_smallest(A: Any, b: Array, G: Any, h: Array, cones: ConeProduct) -> Array | None:
    """The x (v,) of least norm with A x = b and h - G x in the cones, A (e, v) and G (m, v) dense or sparse, as near as
    Clarabel comes; None where it finds nothing. What is missed is for the caller to measure.
    """
    import clarabel

    kinds, settings = _clarabel_setup(len(b), cones)
    rows, v = scipy.sparse.vstack([scipy.sparse.csc_array(A), scipy.sparse.csc_array(G)], format="csc"), A.shape[1]
    whole = scipy.sparse.csc_matrix(rows)
    found = clarabel.DefaultSolver(
        scipy.sparse.identity(v, format="csc"), np.zeros(v), whole, np.append(b, h), kinds, settings
    ).solve()
    x = np.asarray(found.x, dtype=np.float64)
    return x if np.isfinite(x).all() else None


def assess_end(programs: ConicPrograms, k: int, x: Array, y: Array, z: Array, s: Array) -> tuple[int, float, float]:
    """(status, gap, what the numbers are to be divided by) of what was proposed for program k: x (v,), multipliers y
    (e,) of the equations and z (m,) of the rows, and room s (m,).
    """
    c, A, b, G, h, _ = programs
    A, b, h = A[k], b[k], h[k]
    pull = A.T @ y + G.T @ z
    cost, bound = float(c @ x), -float(b @ y + h @ z)
    size = max(1.0, abs(cost))
    primal = max(_norm(A @ x - b) / (1.0 + _norm(b)), _norm(G @ x + s - h) / (1.0 + _norm(h)))
    missed = max(primal / (1.0 + 1e-3 * _norm(x)), _norm(pull + c) / (1.0 + _norm(c)))
    gap = max(float(s @ z) / size, abs(cost - bound) / size, missed)
    if gap <= _END_GAP:
        return ENDED, gap, 1.0
    if cost < 0.0 and max(_norm(A @ x), _norm(G @ x + s)) <= -_PROOF_TOLERANCE * cost:
        return UNBOUNDED, 0.0, -cost
    if bound > 0.0 and _norm(pull) <= _PROOF_TOLERANCE * bound:
        return NOTHING_FITS, 0.0, bound
    return STOPPED, gap, 1.0


def _norm(a: Array) -> float:
    return float(np.sqrt(a @ a))


# ----------------------------------------------------------------
# Holdability within limits: is there a contact force within friction and the effects' limits that balances the load?
#
# W a = -load,  A F a ≤ b,  a ≥ 0
#
# with a generator of the friction cones in every column of F, its wrench in W. If there is none, a twist t and motions
# y ≥ 0 of what gives way prove it (Farkas): Wᵀt + (A F)ᵀy ≥ 0 and load·t > b·y. The object escapes along t while the
# limits give way by y, and the load does more work on the one than the limits dissipate in the other. Stiffness and
# preload play no part (the kinematic theorem of plastic limit analysis).


def prove_overload(scene: Scene, section: Section, effects: tuple[Effect, ...]) -> Array | None:
    """(dof + limits,) a certified proof (t, y) in natural units, limits in the effects' order; None: none gives way,
    or some force within all of them balances the load.
    """
    rows, room = stack_limits(scene, effect_limits(scene, effects))
    if not len(room):
        return None
    load, (F, W) = scene.natural.w, edge_forces(scene, section)
    lp = scipy.optimize.linprog(
        np.append(-load, room),
        A_ub=-np.hstack([W.T, (rows @ F).T]),
        b_ub=np.zeros(W.shape[1]),
        bounds=[(-1.0, 1.0)] * scene.dof + [(0.0, 1.0)] * len(room),
        method="highs",
    )
    if lp.x is None or not lp.x[scene.dof :].max() > ACTIVE_TOLERANCE * abs(lp.x).max():
        return None  # without any limit nothing would hold the object: not a question of limits
    return lp.x if is_escape(scene, section, lp.x, effects) else None


# ----------------------------------------------------------------
# What the contacts, effects and joints of a grasp can bear, as cones and rows over its unknown forces.
#
#     r_i ∈ friction,    A r ≤ b,    |Jᵀ r + g| ≤ τ_max
#
# Stiffness and preload play no part. The rows carry the name of what they limit, so that an answer can say what binds.


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
    cones: ConeProduct
    contact: Ints
    joint: Ints
    effect: Ints
    effects: tuple[Effect, ...]
    equations: Array
    values: Array
    wrenches: Array


def build_capacity(scene: Scene, section: Section, effects: tuple[Effect, ...], torques: bool) -> Capacity:
    """Of a scene with these effects; torques : whether the joints' torque limits count, saturating or not."""
    own = scene.kind.contact_components
    place = np.full(scene.components, -1)
    index = scene.kind.index
    place[index] = np.arange(len(index))
    flat, owners, balls = friction_rows(scene, section, np.where(own >= 0, place[own], -1), len(index))
    beside = tuple([e for e in effects if not isinstance(e, TorqueSaturation)])
    rows, room, joint, effect = _limit_rows(scene, beside, torques)
    # Two rows that say that a force is what it is known to be: A_i = -A_j and b_i = -b_j, with j > i
    each = np.arange(len(rows))
    equal = (rows[:, None] == -rows[None]).all(axis=2) & (room[:, None] == -room[None]) & (each[:, None] < each)
    kept = ~equal.any(axis=0) & ~equal.any(axis=1)
    first = np.flatnonzero(equal.any(axis=1))
    k, cones = len(flat), [(d, len(part)) for d, (part, _) in sorted(balls.items())]
    lines = np.concatenate([flat, rows[kept][:, index]])
    curved = [np.concatenate(part) for _, (part, _) in sorted(balls.items())]
    of_curved = [np.repeat(who, d) for d, (_, who) in sorted(balls.items())]
    tail = sum(d * count for d, count in cones)
    none = np.full(tail, -1)
    return Capacity(
        np.concatenate([lines, *curved]),
        np.concatenate([np.zeros(k), room[kept], np.zeros(tail)]),
        ConeProduct(len(lines), tuple(cones)),
        np.concatenate([owners, np.full(kept.sum(), -1), *of_curved]),
        np.concatenate([np.full(k, -1), joint[kept], none]),
        np.concatenate([np.full(k, -1), effect[kept], none]),
        beside,
        rows[first][:, index],
        room[first],
        scene.natural.full_G[:, index],
    )


def friction_rows(
    scene: Scene, section: Section, own: Ints, m: int
) -> tuple[Array, Ints, dict[int, tuple[list[Array], list[int]]]]:
    """Friction as rows over m forces, -G r in cones: flat ones (k, m) with the contact of each (k,); and by dimension
    the blocks of friction cones with theirs. own (n, 4) : where each contact's normal and tangents are among the
    forces; contacts with -1 in front are left out.
    """
    limits, flat, owners = scene.friction_coefficients(section), list[Array](), list[int]()
    balls: dict[int, tuple[list[Array], list[int]]] = {}
    for i, (at, tangents) in enumerate(zip(own, scene.kind.tangent_count, strict=True)):
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


def _limit_rows(scene: Scene, effects: tuple[Effect, ...], torques: bool) -> tuple[Array, Array, Ints, Ints]:
    """Rows (k, c) and room (k,) of effects, then of joints, and of which joint (k,) or effect (k,) each is."""
    every = effect_limits(scene, effects)
    rows, room = stack_limits(scene, every)
    which = [np.full(sum(len(limit.room) for limit in e.present(scene)), k) for k, e in enumerate(effects)]
    effect = np.concatenate([np.zeros(0, dtype=np.int64), *which])
    joint = np.full(len(room), -1)
    if torques and scene.mechanism is not None:
        motors = TorqueSaturation()
        both: tuple[Limit, ...] = motors.limits(scene)
        bounded, most = stack_limits(scene, both)
        _, _, joints = motors.limited(scene)
        rows, room = np.concatenate([rows, bounded]), np.concatenate([room, most])
        joint = np.concatenate([joint, joints, joints])
        effect = np.append(effect, np.full(len(most), -1))
    return rows, room, joint, effect
