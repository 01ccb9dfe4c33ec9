"""`StateFamily`: the equilibria near an answer in which every contact goes on doing what it does, as convex sets.

With the contact states kept, changes x of forces r, motion u of the object and motions s of limits that give way obey
linear equations (`derivatives/active_set.py`), and what else the states ask for is

    sticks       |r_T| ≤ μ r_N                    separated    v_N ≥ 0
    slides       r_N ≥ 0, v_T against r_T         limits       A r ≤ room, or s ≥ 0 where they give way

so that x = N y with h - G y in half-lines and second-order cones. Contacts that touch without force may push or
separate: every choice is a family of its own. What is not convex is replaced by more than it allows
(`StateFamily.wider`): contacts on a round cone whose direction of sliding may turn, and those that touch without force
and slip, may have any force within friction and any slip; a force that lies on a face of a pyramid which the slip is
not against may leave it, and the slip may turn against it; where many contacts rest, and where many limits are just
reached, each may do both at once; and pads and friction that are known to a range become inequalities:

    pads      v = E r + … + e,  e = (φ - 1) P r with φ from a to b:  |e_k - ((a+b)/2 - 1) (P r)_k| ≤ (b-a)/2 β_k r_N
              for each component k, where |(P r)_k| ≤ β_k r_N by friction: β_k = |P_kN| + μ |P_kT|
    friction  |r_T| ≤ b μ r_N; of a contact that slides against a face n also nᵀ r_T ≥ a μ r_N
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.contact.friction import Cone, Section, limit_set
from handlcp.grasp.assembly.problem import solution_candidate
from handlcp.grasp.derivatives.active_set import (
    LinearLaws,
    active_rows,
    least_norm_solutions,
    linear_laws,
    write_complement,
)
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solution.uniqueness import MAX_RESTING, resting_choices
from handlcp.grasp.verify.certifier import LimitsAtAnswer, certify_candidate, limits_at_answer
from handlcp.grasp.verify.contact_state import (
    GLIDING,
    RESTING,
    SEPARATED,
    SLIDING,
    STICKING,
    ContactStates,
    classify_contacts,
)
from handlcp.grasp.verify.load_capacity import ConeProduct, friction_rows
from handlcp.tolerances import ACTIVE_TOLERANCE, RANK_TOLERANCE

_TOUCHED_SHARE = 1e-10  # of a condition's size: directions that change it by less do not touch it
_TURN_TOLERANCE = 1e-9  # of a unit direction
_MIN_PAD_SHARE = 1e-9  # of the flexibility: a pad softer by less is rounding


class FactorRanges(NamedTuple):
    """Factors (least, largest) on the flexibility of pads and on coefficients of friction, on each contact's apart.
    own (n, 3, 3) : contacts' flexibilities without that of joints, contact axes [m/N].
    """

    pads: tuple[float, float]
    friction: tuple[float, float]
    own: Array


@dataclass(frozen=True, slots=True, eq=False)
class StateFamily:
    """All forces that satisfy the same conditions with the same contact states, natural units.

    basis (c, k) : the forces are those of the answer and basis · y, wherever h - G y, (m,), lies in the cones.
    wider (n,) : contacts that are allowed more than their laws allow.
    """

    basis: Array
    G: Array
    h: Array
    cones: ConeProduct
    wider: Bools


@dataclass(frozen=True, slots=True, eq=False)
class KeptStates:
    """An answer whose contact states are kept; natural units, laws' coordinates. forces and motion (c,). glides (n,) :
    contacts that touch without force and slip. spare (n, 3) : faces that a contact slides along which its force
    lies on, in the order of its states, but which its slip is not against.
    """

    scene: Scene
    section: Section
    states: ContactStates
    limited: LimitsAtAnswer
    forces: Array
    motion: Array
    glides: Bools
    spare: Bools


def keep_states(s: Any) -> KeptStates:
    """Of a `GraspSolution` that is held, with effects that are only limits."""
    candidate, units = solution_candidate(s.scene, s), s.scene.units
    verdict = certify_candidate(s.scene, s.spec.effects, s.section, candidate)
    states = classify_contacts(s.scene, s.section, candidate, verdict)
    limited = limits_at_answer(s.scene, s.spec.effects, candidate)
    forces, motion = candidate.components / units.force_unit, verdict.motion / units.motion_unit
    slow = ACTIVE_TOLERANCE * max(s.residuals.motion_scale / units.motion_unit, 1.0)
    glides, spare = np.zeros(s.scene.n, bool), np.zeros((s.scene.n, 3), bool)
    for i, slip in enumerate([motion[_tangents(s.scene, i)] for i in range(s.scene.n)]):
        glides[i] = states.kind[i] == RESTING and np.linalg.norm(slip) > slow
        against = _slip_against(states, i, len(slip)) @ slip
        spare[i, : len(against)] = against <= slow
    return KeptStates(s.scene, s.section, states, limited, forces, motion, glides, spare)


def _slip_against(states: ContactStates, i: int, tangents: int) -> Array:
    """(k, d) how far a slip goes against each of the k faces that a contact slides against, by its d tangents."""
    return np.asarray(-np.linalg.pinv(states.faces[i, : states.face_count[i], :tangents].T))


def iterate_families(kept: KeptStates, ranges: FactorRanges | None) -> Iterator[StateFamily]:
    """All of them, one for each choice of what is at rest; their union is what is asked for. ranges : None: pads and
    friction are what they are.
    """
    kinds, limits = resting_choices(kept.scene, kept.states.kind), kept.limited
    many = int((kept.states.kind == RESTING).sum()) > MAX_RESTING
    if many:
        kinds = [kept.states.kind]
    ways, loose = limits.choices(), np.zeros(len(limits.rows), bool)
    if limits.resting.sum() > MAX_RESTING:
        ways, loose = ways[:1], limits.resting
    for kind, gives in itertools.product(kinds, ways):
        slides = kept.glides & (kind == STICKING)
        yield _make_family(kept, _StateChoice(np.where(slides, SLIDING, kind), gives, loose), ranges)


class _StateChoice(NamedTuple):
    """One choice of what contacts and limits do.

    kind (n,) : of contacts; those that are RESTING may do anything.
    gives (m,) : limits that give way. loose (m,) : limits that may do anything.
    """

    kind: Ints
    gives: Bools
    loose: Bools


def _make_family(kept: KeptStates, way: _StateChoice, ranges: FactorRanges | None) -> StateFamily:
    round_ = (way.kind == SLIDING) & (kept.states.turn > 0.0)
    wider = (way.kind == RESTING) | (kept.glides & (way.kind == SLIDING))
    if ranges is not None:
        wider = wider | round_
    laws, pads = _choice_laws(kept, way, ranges)
    N = _free_directions(kept, way, laws, pads, wider, ranges)
    if ranges is None and any(_turns_force(kept, N, i) for i in np.flatnonzero(round_).tolist()):
        wider = wider | round_
        N = _free_directions(kept, way, laws, pads, wider, ranges)
    flat, curved = _ConditionRows(N.shape[1]), list[tuple[int, Array, Array]]()
    _add_contacts(flat, kept, way, wider, laws.K, N)
    _add_friction(flat, curved, kept, way, wider, ranges, N)
    c = kept.scene.components
    for j, row in enumerate(kept.limited.rows):
        if way.gives[j] or way.loose[j]:
            flat.add(N[[c + kept.scene.dof + j]], kept.limited.motion[[j]])
        if not way.gives[j] or way.loose[j]:
            flat.add(-row[None] @ N[:c], kept.limited.slack[[j]], float(abs(row).max(initial=0.0)) or 1.0)
    if ranges is not None:
        _add_pads(flat, kept, way, pads, ranges, N)
    every = [-row for row in flat.rows] + [block for _, block, _ in curved]
    room = [max(value, 0.0) for value in flat.now] + [x for _, _, part in curved for x in part]
    G = np.concatenate([np.zeros((0, N.shape[1])), *(np.atleast_2d(row) for row in every)])
    sizes = [(d, sum(1 for e, _, _ in curved if e == d)) for d in sorted({d for d, _, _ in curved})]
    wider = wider | ((way.kind == SLIDING) & kept.spare.any(axis=1))
    return StateFamily(N[: kept.scene.components], G, np.array(room), ConeProduct(len(flat.rows), tuple(sizes)), wider)


# ----------------------------------------------------------------
# The equations: which directions are open.


def _choice_laws(kept: KeptStates, way: _StateChoice, ranges: FactorRanges | None) -> tuple[LinearLaws, Array]:
    """The laws with the middle of the pads' range, and a column more for what pads give way besides; the pads (n, 3, 3)
    in natural units.
    """
    scene, n = kept.scene, kept.scene.n
    laws = linear_laws(scene, scene.friction_coefficients(kept.section), kept.limited.rows, way.gives)
    pads = np.zeros((n, 3, 3))
    if ranges is None or ranges.pads[0] == ranges.pads[1]:
        return laws, pads
    S = np.ones(3 * n) if scene.scale is None else scene.scale[: 3 * n]
    S = S.reshape(n, 3)
    pads = S[:, :, None] * ranges.own * S[:, None] * laws.stiffness_unit
    pads[kept.scene.kind.contact_components[:, 0] < 0] = 0.0
    k, more = len(laws.K), 0.5 * (ranges.pads[0] + ranges.pads[1]) - 1.0
    K = np.zeros((k + 3 * n, k + 3 * n))
    K[:k, :k] = laws.K
    for i in range(n):
        own = slice(3 * i, 3 * i + 3)
        K[own, own] += more * pads[i]
    K[np.arange(3 * n), k + np.arange(3 * n)] = 1.0
    return laws._replace(K=K, kept=np.append(laws.kept, np.zeros(3 * n, bool))), pads


def _free_directions(
    kept: KeptStates, way: _StateChoice, laws: LinearLaws, pads: Array, wider: Bools, ranges: FactorRanges | None
) -> Array:
    """(c + …, k) an orthonormal basis of the changes that all equations allow."""
    scene, states = kept.scene, kept.states
    A, _ = active_rows(laws, states._replace(kind=way.kind))
    c = scene.components
    free = [c + scene.dof + j for j in np.flatnonzero(way.loose)]
    for i, own in enumerate(laws.contacts.tolist()):
        tangents = [j for j in own[1:] if j >= 0]
        if own[0] < 0:
            continue
        if way.kind[i] == RESTING:
            free += own[:1]
        if wider[i]:
            free += tangents
        elif way.kind[i] == SLIDING:
            loose = ranges is not None and ranges.friction[0] < ranges.friction[1]
            free += [j for a, j in enumerate(tangents[: states.face_count[i]]) if loose or kept.spare[i, a]]
        if pads[i].any() and way.kind[i] != SEPARATED:
            k, P = len(laws.K) - 3 * scene.n, pads[i]
            free += [k + j for j in own if 0 <= j < 3 * scene.n and P[j - 3 * i].any()]
    A = np.delete(A, free, axis=0)
    return least_norm_solutions(A, np.zeros((len(A), 0)), RANK_TOLERANCE)[1]


def _turns_force(kept: KeptStates, N: Array, i: int) -> bool:
    """Whether these directions turn the force of a contact that slides on a round set."""
    t = _tangents(kept.scene, i)
    across = np.zeros((3, 3))
    write_complement(kept.states.faces[i], 1, len(t), across)
    return bool((abs(across[: len(t) - 1, : len(t)] @ N[t]) > _TURN_TOLERANCE).any())


def _tangents(scene: Scene, i: int) -> list[int]:
    own: list[int] = scene.kind.contact_components[i, 1:].tolist()
    return own[: scene.kind.tangent_count[i]]


# ----------------------------------------------------------------
# What the states ask for besides: now + row · y ≥ 0.


class _ConditionRows:
    """Conditions that k directions touch."""

    def __init__(self, k: int) -> None:
        self.k, self.rows, self.now = k, list[Array](), list[float]()

    def add(self, rows: Array, now: Array, size: float = 1.0) -> None:
        """Rows (m, k) and now (m,); size : of a row before it was written in these directions."""
        for row, value in zip(rows, now.tolist(), strict=True):
            if abs(row).max(initial=0.0) > _TOUCHED_SHARE * size:
                self.rows.append(row / size)
                self.now.append(value / size)


def _add_contacts(flat: _ConditionRows, kept: KeptStates, way: _StateChoice, wider: Bools, K: Array, N: Array) -> None:
    """Forces push, gaps stay open, slip is against the faces."""
    moved = K @ N
    for i, own in enumerate(kept.scene.kind.contact_components.tolist()):
        z, t = own[0], _tangents(kept.scene, i)
        if z < 0:
            continue
        size = float(abs(K[[z, *t]]).max())
        if way.kind[i] != SEPARATED:
            flat.add(N[[z]], kept.forces[[z]])
        if way.kind[i] in (SEPARATED, RESTING):
            flat.add(moved[[z]], kept.motion[[z]], size)
        if way.kind[i] == SLIDING and not wider[i]:  # the slip is -Σ λ n with λ ≥ 0
            against = _slip_against(kept.states, i, len(t))
            flat.add(against @ moved[t], against @ kept.motion[t], size)


def _add_friction(
    flat: _ConditionRows,
    curved: list[tuple[int, Array, Array]],
    kept: KeptStates,
    way: _StateChoice,
    wider: Bools,
    ranges: FactorRanges | None,
    N: Array,
) -> None:
    """Forces within friction; of contacts that slide on a round set in one direction they are on it."""
    least, most = (1.0, 1.0) if ranges is None else ranges.friction
    scene, r, states = replace(kept.scene, mu=most * kept.scene.mu), kept.forces, kept.states
    rolls = (way.kind == SEPARATED) | (way.kind == GLIDING) | ((states.turn > 0.0) & ~wider & (way.kind == SLIDING))
    own = np.where(rolls[:, None], -1, scene.kind.contact_components)
    lines, _, balls = friction_rows(scene, kept.section, own, scene.components)
    R = N[: scene.components]
    for row in -lines:
        flat.add((row @ R)[None], np.array([row @ r]), float(abs(row).max()))
    for d, (blocks, _) in sorted(balls.items()):
        for block in blocks:
            size = float(abs(block).max())
            if (abs(block @ R) > _TOUCHED_SHARE * size).any():
                room = -block @ r
                room[0] = max(room[0], float(np.linalg.norm(room[1:])))
                curved.append((d, block @ R / size, room / size))
    if least < most:
        limits = least * kept.scene.friction_coefficients(kept.section)
        for i in np.flatnonzero((way.kind == SLIDING) & (states.turn == 0.0)).tolist():
            z, t = scene.kind.contact_components[i, 0], _tangents(scene, i)
            faces = states.faces[i, : states.face_count[i], : len(t)][~kept.spare[i, : states.face_count[i]]]
            flat.add(faces @ R[t] - limits[i] * R[z], faces @ r[t] - limits[i] * r[z])


def _add_pads(
    flat: _ConditionRows, kept: KeptStates, way: _StateChoice, pads: Array, ranges: FactorRanges, N: Array
) -> None:
    """|e_k| ≤ (b-a)/2 β_k r_N, of what pads give way beside the middle of their range."""
    scene, (a, b) = kept.scene, ranges.pads
    first, limits = len(N) - 3 * scene.n, ranges.friction[1] * scene.friction_coefficients(kept.section)
    for i in np.flatnonzero(pads.any(axis=(1, 2)) & (way.kind != SEPARATED)).tolist():
        t, z = _tangents(scene, i), 3 * i + 2
        reach = limits[i]  # the largest tangential force per newton of normal force
        if t and not isinstance(kept.section, Cone):
            reach *= float(np.linalg.norm(limit_set(kept.section, len(t)).vertices, axis=0).max())
        for j in (z, *[j for j in t if j < 3 * scene.n]):
            P = pads[i, j - 3 * i]
            most = 0.5 * (b - a) * (abs(P[2]) + reach * float(np.linalg.norm(P[:2])))
            if most == 0.0:
                continue
            now = -(0.5 * (a + b) - 1.0) * float(P @ kept.forces[3 * i : z + 1])
            for sign in (1.0, -1.0):
                row, room = most * N[z] - sign * N[first + j], most * kept.forces[z] - sign * now
                flat.add(row[None], np.array([room]), most)


def own_flexibility(s: Any) -> Array:
    """(n, 3, 3) of each contact without that of the joints, contact axes [m/N]: its pad."""
    n, mechanism = s.spec.n, s.spec.mechanism
    E = s.spec.flexibility[: 3 * n, : 3 * n]
    if mechanism is not None and mechanism.variation.has_joint_flexibility(s.spec):
        E = E - mechanism.contact_compliance(mechanism.jacobian_rows(())[: 3 * n])
    each = np.arange(n)
    own = E.reshape(n, 3, n, 3)[each, :, each]
    own = np.where(abs(own) > _MIN_PAD_SHARE * abs(s.spec.flexibility).max(initial=0.0), own, 0.0)
    if s.spec.planar:
        own[:, 1] = own[:, :, 1] = 0.0
    return np.asarray(own)
