"""The changes of forces and object motion that keep every active condition of a solution.

Around a solution with given contact states the model is linear in the changes Δr, Δu (`grasp/tangent/active_set`). The
system is square; what its null space spans stays free. A contact that rests, touching without force, may either begin
to push or open: each choice is a branch of its own, with one-sided changes. So is each choice for an effect's limit
that is just reached; one that gives way adds Δv = AᵀΔs and the row A Δr = 0.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section, limit_set
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.tangent.active_set import active_rows, rank_of
from handlcp.grasp.tangent.solutions import laws_of, smallest
from handlcp.grasp.verify.contact_states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, States
from handlcp.grasp.verify.judge import limits_at_answer
from handlcp.tolerances import RANK

MOST_RESTING = 4  # contacts at rest whose 2^k branches are all looked at; beyond that only all-open and all-closed
_FAR = 1e6  # bound of the linear program's unknowns; a condition that stays below 1 / _FAR within it is always active


@dataclass(frozen=True, slots=True)
class Branch:
    """One choice for what is at rest: kind (n,) as in `States`, active (m,) which of the effects' limits give way, and
    basis (c + dof, k), orthonormal changes (Δr, Δu) in natural units, k ≥ 1. multipliers (active.sum(), k): the Δs
    that go with them.
    """

    kind: Ints
    active: Bools
    basis: Array
    multipliers: Array


def free_branches(
    scene: Scene, effects: tuple[Effect, ...], section: Section, states: States, candidate: Candidate
) -> tuple[Branch, ...]:
    """The branches that leave something free; none when the solution is locally unique (decided by elimination)."""
    limited, out, moves = limits_at_answer(scene, effects, candidate), [], scene.components + scene.dof
    for kind, active in itertools.product(choices(scene, states.kind), limited.choices()):
        laws = laws_of(scene, scene.limits(section), limited.rows, active)
        A, _ = active_rows(laws, states._replace(kind=kind))
        if rank_of(A.copy()) == len(A):
            continue
        _, free = smallest(A, np.zeros((len(A), 0)), RANK)
        # Directions of multipliers alone move nothing: dropped, and the rest made orthonormal in (r, u)
        basis, multipliers = _orthonormal(np.vstack([free[:moves], free[moves:][active]]), moves)
        resting = np.flatnonzero(states.kind == RESTING)
        if (len(resting) or limited.resting.any()) and basis.shape[1]:
            nothing = np.zeros(scene.components)
            D, _ = inequalities(scene, section, kind, states, nothing, nothing, resting)
            # Rows of a friction beyond measure are as long as it is; only their directions matter
            D = D / abs(D).max(axis=1, keepdims=True) @ basis
            at_limits, _ = limited.conditions(basis, active, multipliers)
            span = _span(np.vstack([D, at_limits[limited.resting]]))
            basis, multipliers = basis @ span, multipliers @ span
        if basis.shape[1]:
            out.append(Branch(kind, active, basis, multipliers))
    return tuple(out)


def choices(scene: Scene, kind: Ints) -> list[Ints]:
    """The states with contacts at rest closed or open, in every way."""
    resting, out = np.flatnonzero(kind == RESTING), []
    closed = np.where(np.array(scene.kind.tangents) > 0, STICKING, GLIDING)
    every = resting if len(resting) <= MOST_RESTING else resting[:1]  # or all alike
    for pattern in itertools.product((False, True), repeat=len(every)):
        choice = kind.copy()
        choice[resting] = np.where(pattern, closed[resting], SEPARATED)
        out.append(choice)
    return out


def _orthonormal(columns: Array, k: int) -> tuple[Array, Array]:
    """An orthonormal basis of the first k rows, and the other rows that go with it."""
    U, s, Wt = np.linalg.svd(columns[:k], full_matrices=False)
    kept = s > 1e-9
    basis = U[:, kept]
    return basis, columns[k:] @ Wt[kept].T / s[kept] if len(columns) > k else np.empty((0, basis.shape[1]))


def _span(D: Array) -> Array:
    """(k, j) orthonormal basis of the span of the cone {c : D c ≥ 0}, D (rows, k).

    One linear program finds every row that is 0 throughout: the largest Σ t with D c ≥ t, 0 ≤ t ≤ 1, has t = 1 for the
    others, because the cone holds the sum of its members. Without an answer no row is called 0.
    """
    from scipy.optimize import linprog  # half a second of import that only degenerate, loose scenes should pay

    D = D[abs(D).max(axis=1) > 1e-9]
    rows, k = D.shape
    bounds = [(-_FAR, _FAR)] * k + [(0.0, 1.0)] * rows
    most, within = np.append(np.zeros(k), -np.ones(rows)), np.hstack([-D, np.eye(rows)])
    found = linprog(most, within, np.zeros(rows), bounds=bounds, method="highs").x
    _, sv, Vt = np.linalg.svd(D[:0] if found is None else D[found[k:] < 0.5])
    return Vt[int((sv > 1e-9).sum()) :].T


def inequalities(
    scene: Scene, section: Section, kind: Ints, states: States, forces: Array, motion: Array, contacts: Ints
) -> tuple[Array, Array]:
    """(rows, now): now + rows · (Δr, Δu) ≥ 0 keeps these contacts in their states; forces and motion (c,), natural
    units.
    """
    c, limits = scene.components, scene.limits(section)
    force = np.eye(c, c + scene.dof)
    move = np.hstack([scene.flexibility * (scene.units.force / scene.units.motion), scene.natural.every.T])
    rows, now = [np.zeros((0, c + scene.dof))], [np.zeros(0)]
    for i in contacts.tolist():
        z, *own = scene.kind.contact_components[i].tolist()
        t = own[: scene.kind.tangents[i]]
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
            against = -np.linalg.pinv(states.faces[i, : states.against[i], : len(t)].T)
            rows.append(against @ move[t])
            now.append(against @ motion[t])
    return np.concatenate(rows), np.concatenate(now)
