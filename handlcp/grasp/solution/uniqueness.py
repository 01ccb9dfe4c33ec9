"""`Uniqueness`: the changes of forces and object motion that keep every active condition of a solution.

Around a solution with given contact states the model is linear in the changes Δr, Δu (`derivatives/active_set.py`). The
system is square; what its null space spans stays free. A contact that rests, touching without force, may either begin
to push or open: each choice is a branch of its own, with one-sided changes. So is each choice for an effect's limit
that is just reached; one that gives way adds Δv = AᵀΔs and the row A Δr = 0.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import scipy

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.contact.friction import Section, limit_set
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.derivatives.active_set import active_rows, least_norm_solutions, linear_laws, matrix_rank
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.contact import shift_twist
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.certifier import Certification, limits_at_answer
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.tolerances import RANK_TOLERANCE

MAX_RESTING = 4  # contacts at rest whose 2^k branches are all looked at; beyond that only all-open and all-closed
# Bound of the linear program's unknowns; a condition that stays below 1 / _PROGRAM_BOUND within it is always active
_PROGRAM_BOUND = 1e6


@dataclass(frozen=True, slots=True)
class Branch:
    """One choice for what is at rest: kind (n,) as in `ContactStates`, active (m,) which of the effects' limits give
    way, and basis (c + dof, k), orthonormal changes (Δr, Δu) in natural units, k ≥ 1. multipliers (active.sum(), k):
    the Δs that go with them.
    """

    kind: Ints
    active: Bools
    basis: Array
    multipliers: Array


def free_branches(
    scene: Scene, effects: tuple[Effect, ...], section: Section, states: ContactStates, candidate: SolverCandidate
) -> tuple[Branch, ...]:
    """The branches that leave something free; none when the solution is locally unique (decided by elimination)."""
    limited, out, moves = limits_at_answer(scene, effects, candidate), [], scene.components + scene.dof
    for kind, active in itertools.product(resting_choices(scene, states.kind), limited.choices()):
        laws = linear_laws(scene, scene.friction_coefficients(section), limited.rows, active)
        A, _ = active_rows(laws, states._replace(kind=kind))
        if matrix_rank(A.copy()) == len(A):
            continue
        _, free = least_norm_solutions(A, np.zeros((len(A), 0)), RANK_TOLERANCE)
        # Directions of multipliers alone move nothing: dropped, and the rest made orthonormal in (r, u)
        U, s, Wt = np.linalg.svd(free[:moves], full_matrices=False)
        own = s > 1e-9
        basis, multipliers = U[:, own], free[moves:][active] @ Wt[own].T / s[own]
        resting = np.flatnonzero(states.kind == RESTING)
        if (len(resting) or limited.resting.any()) and basis.shape[1]:
            nothing = np.zeros(scene.components)
            D, _ = state_inequalities(scene, section, kind, states, nothing, nothing, resting)
            # Rows of a friction beyond measure are as long as it is; only their directions matter
            D = D / abs(D).max(axis=1, keepdims=True) @ basis
            at_limits, _ = limited.conditions(basis, active, multipliers)
            span = _cone_span(np.vstack([D, at_limits[limited.resting]]))
            basis, multipliers = basis @ span, multipliers @ span
        if basis.shape[1]:
            out.append(Branch(kind, active, basis, multipliers))
    return tuple(out)


def resting_choices(scene: Scene, kind: Ints) -> list[Ints]:
    """The states with contacts at rest closed or open, in every way."""
    resting, out = np.flatnonzero(kind == RESTING), []
    closed = np.where(np.array(scene.kind.tangent_count) > 0, STICKING, GLIDING)
    every = resting if len(resting) <= MAX_RESTING else resting[:1]  # or all alike
    for pattern in itertools.product((False, True), repeat=len(every)):
        choice = kind.copy()
        choice[resting] = np.where(pattern, closed[resting], SEPARATED)
        out.append(choice)
    return out


def _cone_span(D: Array) -> Array:
    """(k, j) orthonormal basis of the span of the cone {c : D c ≥ 0}, D (rows, k).

    One linear program finds every row that is 0 throughout: the largest Σ t with D c ≥ t, 0 ≤ t ≤ 1, has t = 1 for the
    others, because the cone holds the sum of its members. Without an answer no row is called 0.
    """
    D = D[abs(D).max(axis=1) > 1e-9]
    rows, k = D.shape
    bounds = [(-_PROGRAM_BOUND, _PROGRAM_BOUND)] * k + [(0.0, 1.0)] * rows
    most, within = np.append(np.zeros(k), -np.ones(rows)), np.hstack([-D, np.eye(rows)])
    found = scipy.optimize.linprog(most, within, np.zeros(rows), bounds=bounds, method="highs").x
    _, sv, Vt = np.linalg.svd(D[:0] if found is None else D[found[k:] < 0.5])
    return Vt[int((sv > 1e-9).sum()) :].T


def state_inequalities(
    scene: Scene, section: Section, kind: Ints, states: ContactStates, forces: Array, motion: Array, contacts: Ints
) -> tuple[Array, Array]:
    """Inequalities (rows, now) that keep these contacts in their states: now + rows · (Δr, Δu) ≥ 0.

    forces, motion (c,) : natural units.
    """
    c, limits = scene.components, scene.friction_coefficients(section)
    force = np.eye(c, c + scene.dof)
    move = np.hstack([scene.flexibility * (scene.units.force_unit / scene.units.motion_unit), scene.natural.full_G.T])
    rows, now = [np.zeros((0, c + scene.dof))], [np.zeros(0)]
    for i in contacts.tolist():
        z, *own = scene.kind.contact_components[i].tolist()
        t = own[: scene.kind.tangent_count[i]]
        if z < 0:
            continue
        rows.append((move if kind[i] == SEPARATED else force)[[z]])
        now.append((motion if kind[i] == SEPARATED else forces)[[z]])
        if kind[i] == SEPARATED:
            continue
        if kind[i] != GLIDING and t:
            outward = limit_set(section, len(t)).normals.T
            rows.append(limits[i] * force[z] - outward @ force[t])
            now.append(limits[i] * forces[z] - outward @ forces[t])
        if kind[i] == SLIDING:  # the slip is -Σ λ n with λ ≥ 0
            against = -np.linalg.pinv(states.faces[i, : states.face_count[i], : len(t)].T)
            rows.append(against @ move[t])
            now.append(against @ motion[t])
    return np.concatenate(rows), np.concatenate(now)


# ----------------------------------------------------------------
# What a solution leaves free, in words and SI; and the member of least norm where there is a choice.


@dataclass(frozen=True, slots=True)
class Uniqueness:
    """What the solution leaves free.

    loose_motions : dimension of the object motions that the contacts, in their present states, do not resist.
    directions : (loose_motions, 6) twists (m, rad) spanning them, about the grasp's reference, one natural unit each;
        a motion is one-sided where it opens a contact or turns a slip, and may be short.
    forces_determined : whether no other contact forces near these satisfy the same conditions.
    others : whether equilibria exist that no such family of forces connects with this one. True: at least one was
        found. False: proven, there are none. None: not looked for (`grasp.equilibria()` does), or looked for without
        finding any or a proof.

    smallest : whether the smallest of these forces and motions are given; False: those that a loading in steps led to.

    Without friction there are no others: the laws are a monotone LCP then, whose solutions form one convex set
    (Cottle, Pang & Stone, The Linear Complementarity Problem, 1992, theorem 3.1.7). With friction there may be.
    """

    loose_motions: int
    directions: Array
    forces_determined: bool
    others: bool | None = None
    smallest: bool = True

    def __str__(self) -> str:
        forces, motion = f"forces {'' if self.forces_determined else 'NOT '}determined", "object motion determined"
        if k := self.loose_motions:
            given = "the smallest motion" if self.smallest else "that of the loading"
            motion = f"object motion free in {k} direction{'s' if k > 1 else ''} ({given} is given)"
        return f"{forces}, {motion}, {_OTHERS_TEXT[self.others]}"


_OTHERS_TEXT = {
    True: "other equilibria exist",
    False: "no other equilibrium exists",
    None: "other equilibria not ruled out (grasp.equilibria() looks for them)",
}
_NO_DIRECTIONS = read_only(np.zeros((0, 6)))
_NOTHING_FREE = {others: Uniqueness(0, _NO_DIRECTIONS, True, others) for others in (False, None)}


def find_uniqueness(scene: Scene, branches: tuple[Branch, ...], arm: Array) -> Uniqueness:
    """In SI; arm (3,) [m] leads from the contacts' centre to the grasp's reference."""
    others = None if scene.frictional else False
    if not branches:
        return _NOTHING_FREE[others]
    c = scene.components
    U, s, _ = np.linalg.svd(np.hstack([b.basis[c:] for b in branches]), full_matrices=False)
    moving = U[:, s > 1e-9]
    if moving.size:  # whichever way a basis comes out, a direction is told by its largest component, upwards
        moving = moving * np.sign(moving[abs(moving).argmax(axis=0), np.arange(moving.shape[1])])
    twists = np.array([shift_twist(scene.twist(t), arm) for t in moving.T]).reshape(-1, 6)
    determined = all(float(abs(b.basis[:c]).max()) < 1e-9 for b in branches)
    return Uniqueness(moving.shape[1], read_only(twists), determined, others)


_ROUNDING_SHARE = 1e-14  # of a unit vector's entries


def minimum_norm_candidate(
    scene: Scene,
    effects: tuple[Effect, ...],
    section: Section,
    states: ContactStates,
    candidate: SolverCandidate,
    verdict: Certification,
    branches: tuple[Branch, ...],
) -> SolverCandidate:
    """The member of least norm (natural units) that keeps every contact in its state; verdict : on the candidate.

    In each branch min ‖x₀ + B c‖ subject to the inequalities of the states (forces push, gaps stay open, friction
    within its limit, slip against the faces): a least-distance problem, solved as nonnegative least squares
    (Lawson & Hanson, Solving Least Squares Problems, chapter 23). What effects limit stays within its limit, and what
    gives way goes on giving way.
    """
    c, units = scene.components, scene.units
    forces, moved = candidate.components / units.force_unit, verdict.motion / units.motion_unit
    x0 = np.concatenate([forces, scene.natural_twist(candidate.twist)])
    best, extra, limited = x0, candidate.extra, limits_at_answer(scene, effects, candidate)
    for branch in branches:
        B = np.where(abs(branch.basis) > _ROUNDING_SHARE, branch.basis, 0.0)  # between rigid bodies all motion counts
        rows, now = state_inequalities(scene, section, branch.kind, states, forces, moved, np.arange(scene.n))
        # With y = c + Bᵀx₀: min ‖y‖ subject to A y ≥ h. Rounding must neither shut out the present member (now ≥ 0)
        # nor make a condition of a row that these directions do not touch.
        D, slack = limited.conditions(B, branch.active, branch.multipliers)
        A, size = np.vstack([rows @ B, D]), np.append(abs(rows).max(axis=1), np.ones(len(D)))
        touched = abs(A).max(axis=1) > 1e-10 * size
        A, h = A[touched], np.maximum(np.append(now, slack)[touched], 0.0)
        # The smallest y with A y ≥ h, if any
        h, y = A @ (B.T @ x0) - h, np.zeros(A.shape[1])
        if len(A):  # scipy's nnls crashes without columns
            E, e = np.vstack([A.T, h]), np.append(np.zeros(A.shape[1]), 1.0)
            left = e - E @ scipy.optimize.nnls(E, e)[0]
            if not left[-1] > 0.0:
                continue
            y = -left[:-1] / left[-1]
        change = y - B.T @ x0
        x = x0 + B @ change
        if x @ x < best @ best:
            best, extra = x, limited.move_extra(scene, branch.active, branch.multipliers @ change)
    return SolverCandidate(best[:c] * units.force_unit, scene.twist(best[c:]), extra, candidate.soft)
