"""`Uniqueness`: the changes of forces and object motion that keep every active condition of a solution.

Around a solution with given contact states the model is linear in the changes Δr, Δu (`derivatives/active_set.py`). The
system is square; what its null space spans stays free. A contact that rests, touching without force, may either begin
to push or open: each choice is a branch of its own, with one-sided changes. So is each choice for an effect's limit
that is just reached; one that gives way adds Δv = AᵀΔs and the row A Δr = 0.

One factorisation finds a branch and its least member. What contacts at rest allow of it is asked for when somebody
reads it, and needs a linear program only where the directions that are certainly allowed are fewer than those that the
equations leave free.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.contact.friction import Cone, Section, limit_set
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.derivatives.active_set import active_rows, linear_laws, matrix_rank
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.contact import shift_twist
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.certifier import Certification, limits_at_answer
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.grasp.verify.load_capacity import ConeProduct, find_smallest, friction_rows
from handlcp.tolerances import RANK_TOLERANCE

MAX_RESTING = 4  # contacts at rest whose 2^k branches are all looked at; beyond that only all-open and all-closed
_OPEN_SHARE = 1e-9  # of a unit direction: what changes by less stays as it is
_ROUNDING_SHARE = 1e-14  # of a unit vector's entries


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """One choice for what is at rest, and the changes (Δr, Δu) that the equations leave free there; natural units.

    kind (n,) : as in `ContactStates`. active (m,) : which of the effects' limits give way.
    basis (c + dof, k) : orthonormal changes, k ≥ 1. multipliers (active.sum(), k) : the Δs that go with them.
    equations (e, c + dof) : independent ones, whose null space the basis spans; None beside limits.
    resting : conditions that keep what contacts at rest do; the changes allowed are those with rows · (Δr, Δu) ≥ 0.
    at_limits (j, k) : the same along the basis, of limits at rest.
    """

    kind: Ints
    active: Bools
    basis: Array
    multipliers: Array
    equations: Array | None
    resting: StateConditions
    at_limits: Array


def free_branches(
    scene: Scene, effects: tuple[Effect, ...], section: Section, states: ContactStates, candidate: SolverCandidate
) -> tuple[Branch, ...]:
    """The branches whose equations leave something free; none when the solution is locally unique (decided by
    elimination). What is at rest may forbid it all, which `find_uniqueness` says.
    """
    limited, out, moves = limits_at_answer(scene, effects, candidate), [], scene.components + scene.dof
    nothing, at_rest = np.zeros(scene.components), np.flatnonzero(states.kind == RESTING)
    outward = {d: limit_set(section, d).normals.T for d in set(scene.kind.tangent_count) - {0}}  # around a round set
    for kind, active in itertools.product(resting_choices(scene, states.kind), limited.choices()):
        laws = linear_laws(scene, scene.friction_coefficients(section), limited.rows, active)
        A, _ = active_rows(laws, states._replace(kind=kind))
        if matrix_rank(A.copy()) == len(A):
            continue
        independent, basis = split_row_space(A)
        multipliers = np.zeros((0, basis.shape[1]))
        if len(A) > moves:
            # Directions of multipliers alone move nothing: dropped, and the rest made orthonormal in (r, u)
            U, s, Wt = np.linalg.svd(basis[:moves], full_matrices=False)
            own = s > _OPEN_SHARE
            basis, multipliers = U[:, own], basis[moves:][active] @ Wt[own].T / s[own]
        if basis.shape[1]:
            basis = np.where(abs(basis) > _ROUNDING_SHARE, basis, 0.0)  # between rigid bodies all motion counts
            resting = state_inequalities(scene, section, kind, states, nothing, nothing, at_rest, outward)
            at_limits = limited.conditions(basis, active, multipliers)[0][limited.resting]
            equations = A[independent] if len(A) == moves else None
            out.append(Branch(kind, active, basis, multipliers, equations, resting, at_limits))
    return tuple(out)


def split_row_space(A: Array, least: float = 0.0) -> tuple[Ints, Array]:
    """Which rows of A (m, k) span all of them, and an orthonormal basis (k, j) of what A takes to zero: by one
    factorisation. Pivots up to `least`, or below `RANK_TOLERANCE` of the largest, count as zero.
    """
    if not len(A):
        return np.zeros(0, dtype=np.int64), np.eye(A.shape[1])
    Q, R, order = scipy.linalg.qr(A.T, pivoting=True)
    pivots = abs(np.diagonal(R))
    rank = int((pivots > max(least, RANK_TOLERANCE * pivots[0])).sum())
    return order[:rank], Q[:, rank:]


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


class StateConditions(NamedTuple):
    """Conditions that keep contacts in their states: now + rows · (Δr, Δu) ≥ 0, natural units.

    rows (p, c + dof) : the largest entry of each is one. now (p,). owners (p,) : the contact that each is about.
    """

    rows: scipy.sparse.csr_array
    now: Array
    owners: Ints


def state_inequalities(
    scene: Scene,
    section: Section,
    kind: Ints,
    states: ContactStates,
    forces: Array,
    motion: Array,
    contacts: Ints,
    outward: Mapping[int, Array],
) -> StateConditions:
    """The conditions that keep these contacts in their states; forces, motion (c,) : natural units. outward : normals
    (f, d) of friction sets by their number d of tangents; those without any are left out.
    """
    limits, size, every = scene.friction_coefficients(section), scene.components + scene.dof, []
    move = np.hstack([scene.flexibility * (scene.units.force_unit / scene.units.motion_unit), scene.natural.full_G.T])
    whole = np.arange(size)
    for i in contacts.tolist():
        z, *own = scene.kind.contact_components[i].tolist()
        t = own[: scene.kind.tangent_count[i]]
        if z < 0:
            continue
        if kind[i] == SEPARATED:
            every.append((i, whole, move[[z]], motion[[z]]))
            continue
        every.append((i, np.array([z]), np.ones((1, 1)), forces[[z]]))
        if kind[i] != GLIDING and len(t) in outward:
            normals = outward[len(t)]
            within = np.column_stack([np.full(len(normals), limits[i]), -normals])
            every.append((i, np.array([z, *t]), within, within @ forces[[z, *t]]))
        if kind[i] == SLIDING:  # the slip is -Σ λ n with λ ≥ 0
            against = -np.linalg.pinv(states.faces[i, : states.face_count[i], : len(t)].T)
            every.append((i, whole, against @ move[t], against @ motion[t]))
    return _stack_conditions(size, every)


def _stack_conditions(size: int, every: list[tuple[int, Ints, Array, Array]]) -> StateConditions:
    """The conditions over so many unknowns, of groups (contact, columns, their entries in each row, values)."""
    if not every:
        return StateConditions(scipy.sparse.csr_array((0, size)), np.zeros(0), np.zeros(0, dtype=np.int64))
    rows = [block for _, _, block, _ in every]
    # Rows of a friction beyond measure are as long as it is; only their directions matter
    longest = [np.maximum(abs(block).max(axis=1), np.finfo(float).tiny) for block in rows]
    entries = [(block / most[:, None]).ravel() for block, most in zip(rows, longest, strict=True)]
    columns = [np.tile(at, len(block)) for _, at, block, _ in every]
    ends = np.cumsum(np.concatenate([np.full(len(block), len(at)) for _, at, block, _ in every]))
    made = scipy.sparse.csr_array(
        (np.concatenate(entries), np.concatenate(columns), np.append(0, ends)), shape=(len(ends), size)
    )
    made.eliminate_zeros()
    now = [values / most for (_, _, _, values), most in zip(every, longest, strict=True)]
    owners = [np.full(len(block), i) for i, _, block, _ in every]
    return StateConditions(made, np.concatenate(now), np.concatenate(owners))


# ----------------------------------------------------------------
# The member of least norm where there is a choice.


class LeastNorm(NamedTuple):
    """The member of least norm, and the changes c (k,) along each branch's basis that lead to that branch's own; None
    where none was found.
    """

    candidate: SolverCandidate
    changes: tuple[Array | None, ...]


def minimum_norm_candidate(
    scene: Scene,
    effects: tuple[Effect, ...],
    section: Section,
    states: ContactStates,
    candidate: SolverCandidate,
    verdict: Certification,
    branches: tuple[Branch, ...],
) -> LeastNorm:
    """The member of least norm (natural units) that keeps every contact in its state; verdict : on the candidate.

    In each branch min ‖x₀ + B c‖ subject to the inequalities of the states (forces push, gaps stay open, friction
    within its limit, slip against the faces). What effects limit stays within its limit, and what gives way goes on
    giving way.
    """
    c, units, changes = scene.components, scene.units, list[Array | None]()
    forces, moved = candidate.components / units.force_unit, verdict.motion / units.motion_unit
    x0 = np.concatenate([forces, scene.natural_twist(candidate.twist)])
    best, extra, limited = x0, candidate.extra, limits_at_answer(scene, effects, candidate)
    sets = set(scene.kind.tangent_count) - {0}
    flat = {d: limit_set(section, d).normals.T for d in sets if d == 1 or not isinstance(section, Cone)}
    for branch in branches:
        kept = state_inequalities(scene, section, branch.kind, states, forces, moved, np.arange(scene.n), flat)
        at_limits = limited.conditions(branch.basis, branch.active, branch.multipliers)
        change = _find_least_change(branch, kept, at_limits, _round_cones(scene, section, branch.kind), x0)
        changes.append(change)
        if change is None:
            continue
        x = x0 + branch.basis @ change
        if x @ x < best @ best:
            best, extra = x, limited.move_extra(scene, branch.active, branch.multipliers @ change)
    least = SolverCandidate(best[:c] * units.force_unit, scene.twist(best[c:]), extra, candidate.soft)
    return LeastNorm(least, tuple(changes))


_MISSED_SHARE = 1e-12  # of the answer: conditions that are missed by less are met


def _round_cones(scene: Scene, section: Section, kind: Ints) -> tuple[scipy.sparse.csr_array, ConeProduct]:
    """Rows C (m, c + dof) with C x in cones, of contacts that stick or slide on a round set."""
    own = scene.kind.contact_components
    rubs = ((kind == STICKING) | (kind == SLIDING)) & (np.array(scene.kind.tangent_count) > 1)
    _, _, balls = friction_rows(scene, section, np.where(rubs[:, None], own, -1), scene.components + scene.dof)
    every = [block for _, (blocks, _) in sorted(balls.items()) for block in blocks]
    rows = -np.concatenate([np.zeros((0, scene.components + scene.dof)), *every])
    return scipy.sparse.csr_array(rows), ConeProduct(0, tuple((d, len(of)) for d, (of, _) in sorted(balls.items())))


def _find_least_change(
    branch: Branch,
    kept: StateConditions,
    limits: tuple[Array, Array],
    cones: tuple[scipy.sparse.csr_array, ConeProduct],
    x0: Array,
) -> Array | None:
    """The c (k,) of the smallest x₀ + B c that keeps all conditions, those of limits (D, slack) along the basis; None:
    rounding leaves none.

    With y = c + Bᵀx₀: min ‖y‖ subject to A y ≥ h, a least-distance problem, solved as nonnegative least squares
    (Lawson & Hanson, Solving Least Squares Problems, chapter 23). Few conditions bind of very many: those that y misses
    most join, of each contact one, until it misses none. Where forces leave a round cone then, the program is one of
    second-order cones. Rounding must neither shut out the present member (now ≥ 0) nor make a condition of a row that
    these directions do not touch.
    """
    B, (D, slack) = branch.basis, limits
    now, start, count = np.maximum(np.append(kept.now, slack), 0.0), B.T @ x0, len(kept.now)
    least, y = -_MISSED_SHARE * max(1.0, float(abs(x0).max())), np.zeros(B.shape[1])
    joined, binding, beyond = np.zeros(len(now), bool), [np.zeros((0, len(y)))], [np.zeros(0)]
    groups = np.append(kept.owners, -1 - np.arange(len(D)))
    while True:
        c = y - start
        room = now + np.append(kept.rows @ (B @ c), D @ c)
        missed = np.flatnonzero((room < least) & ~joined)
        if not len(missed):
            break
        worst = missed[np.argsort(room[missed], kind="stable")]
        missed = np.sort(worst[np.unique(groups[worst], return_index=True)[1]])
        joined[missed] = True
        rows = np.concatenate([kept.rows[missed[missed < count]] @ B, D[missed[missed >= count] - count]])
        touched = abs(rows).max(axis=1) > 1e-10
        if not touched.any():
            continue
        binding.append(rows[touched])
        beyond.append(rows[touched] @ start - now[missed[touched]])
        found = _solve_least_distance(np.concatenate(binding), np.concatenate(beyond))
        if found is None:
            return None
        y = found
    if _cone_room(cones, x0 + B @ c) >= least:
        return c
    return _find_least_in_cones(branch, kept._replace(now=now[:count]), (D, now[count:]), cones, x0)


def _cone_room(cones: tuple[scipy.sparse.csr_array, ConeProduct], x: Array) -> float:
    """The least t - |u| of all cones, which is below zero where x leaves one."""
    values, at, room = cones[0] @ x, 0, [0.0]
    for d, count in cones[1].second_order:
        parts = values[at : at + d * count].reshape(count, d)
        room.append(float((parts[:, 0] - np.sqrt((parts[:, 1:] ** 2).sum(axis=1))).min()))
        at += d * count
    return min(room)


def _find_least_in_cones(
    branch: Branch,
    kept: StateConditions,
    limits: tuple[Array, Array],
    cones: tuple[scipy.sparse.csr_array, ConeProduct],
    x0: Array,
) -> Array | None:
    """As `_find_least_change`, by a conic program; over x itself where it has fewer equations than directions."""
    B, (D, slack), (C, curved) = branch.basis, limits, cones
    touched = np.flatnonzero(abs(kept.rows) @ abs(B).max(axis=1) > 1e-10)
    rows, now, equations = kept.rows[touched], kept.now[touched], branch.equations
    size = max(1.0, float(abs(x0).max()))
    if equations is not None and len(equations) < B.shape[1]:
        A, G, right = equations, scipy.sparse.vstack([rows, C]), equations @ x0
        room = np.append(now - rows @ x0, np.zeros(C.shape[0]))
        found = find_smallest(
            scipy.sparse.csr_array(A), right / size, -G, room / size, ConeProduct(len(now), curved.second_order)
        )
        return None if found is None else np.asarray(B.T @ (found * size - x0))
    start, fixed = B.T @ x0, x0 - B @ (B.T @ x0)
    G = np.concatenate([rows @ B, D, C @ B])
    room = np.concatenate([now - (rows @ B) @ start, slack - D @ start, C @ fixed])
    every = ConeProduct(len(now) + len(D), curved.second_order)
    found = find_smallest(np.zeros((0, len(start))), np.zeros(0), -G, room / size, every)
    return None if found is None else found * size - start


def _solve_least_distance(A: Array, h: Array) -> Array | None:
    """The smallest y with A y ≥ h, A (p, k); None: there is none, to rounding."""
    Q, R = np.linalg.qr(A.T)  # y is in the span of the rows: with more columns than rows the problem is smaller there
    E, e = np.vstack([R, h]), np.append(np.zeros(len(R)), 1.0)
    try:
        left = e - E @ scipy.optimize.nnls(E, e)[0]
    except RuntimeError:  # its steps do not end
        return None
    return np.asarray(Q @ (-left[:-1] / left[-1])) if left[-1] > 0.0 else None


# ----------------------------------------------------------------
# What a solution leaves free, in words and SI.


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
    proven : False where contacts at rest may allow less than is said: what decides it would take too long.

    Without friction there are no others: the laws are a monotone LCP then, whose solutions form one convex set
    (Cottle, Pang & Stone, The Linear Complementarity Problem, 1992, theorem 3.1.7). With friction there may be.
    """

    loose_motions: int
    directions: Array
    forces_determined: bool
    others: bool | None = None
    smallest: bool = True
    proven: bool = True

    def __str__(self) -> str:
        forces, motion = f"forces {'' if self.forces_determined else 'NOT '}determined", "object motion determined"
        if k := self.loose_motions:
            given = "the smallest motion" if self.smallest else "that of the loading"
            motion = f"object motion free in {k} direction{'s' if k > 1 else ''} ({given} is given)"
        return f"{forces}, {motion}, {_OTHERS_TEXT[self.others]}{'' if self.proven else _AT_MOST_TEXT}"


_OTHERS_TEXT = {
    True: "other equilibria exist",
    False: "no other equilibrium exists",
    None: "other equilibria not ruled out (grasp.equilibria() looks for them)",
}
_AT_MOST_TEXT = "; no more than that is free, maybe less: what decides it takes more than the work set aside for that"
_NO_DIRECTIONS = read_only(np.zeros((0, 6)))
_NOTHING_FREE = {others: Uniqueness(0, _NO_DIRECTIONS, True, others) for others in (False, None)}


def find_uniqueness(
    scene: Scene, branches: tuple[Branch, ...], arm: Array, changes: Sequence[Array | None] = ()
) -> Uniqueness:
    """In SI; arm (3,) [m] leads from the contacts' centre to the grasp's reference. changes : of `LeastNorm`, where
    they are known; they prove some of what is free.
    """
    others = None if scene.frictional else False
    if not branches:
        return _NOTHING_FREE[others]
    c = scene.components
    doubts = [_find_doubts(b, x) for b, x in itertools.zip_longest(branches, changes)]
    most = [b.basis for b in branches]
    least = [d.allowed_directions(b) for b, d in zip(branches, doubts, strict=True)]
    motions, proven = _span([x[c:] for x in most]), True
    forces = _has_entries([x[:c] for x in most])
    if len(_span([x[c:] for x in least]).T) < len(motions.T) or forces != _has_entries([x[:c] for x in least]):
        known = [d.decide(b) for b, d in zip(branches, doubts, strict=True)]
        proven = all(x is not None for x in known)
        spans = [x if x is not None else b.basis for x, b in zip(known, branches, strict=True)]
        motions, forces = _span([x[c:] for x in spans]), _has_entries([x[:c] for x in spans])
    if motions.size:  # whichever way a basis comes out, a direction is told by its largest component, upwards
        motions = motions * np.sign(motions[abs(motions).argmax(axis=0), np.arange(motions.shape[1])])
    twists = np.array([shift_twist(scene.twist(t), arm) for t in motions.T]).reshape(-1, 6)
    return Uniqueness(motions.shape[1], read_only(twists), not forces, others, proven=proven)


def _span(parts: list[Array]) -> Array:
    """(d, k) an orthonormal basis of what the columns of these (d, …) span together."""
    U, s, _ = np.linalg.svd(np.hstack(parts), full_matrices=False)
    return np.asarray(U[:, s > _OPEN_SHARE])


def _has_entries(parts: list[Array]) -> bool:
    return any(float(abs(x).max(initial=0.0)) >= _OPEN_SHARE for x in parts)


# ----------------------------------------------------------------
# What is at rest allows changes along a branch in a cone; what is free is the span of that cone.
#
# cone {c : D c ≥ 0},    span {c : D_i c = 0 for the rows that are 0 throughout the cone}
#
# A member with D_i c > 0 proves that row i is not among them. Where it proves all others, no more is needed; and
# directions that keep all rows in doubt at zero are in the span in any case, since a bit of them can be added to it.

_PROGRAM_BOUND = 1e6  # of unknowns; a condition that stays below its inverse within it is always zero
MAX_PROGRAM_WORK = 2e8  # entries of its matrix times steps of the simplex method: one or two seconds
_CERTAIN_SHARE = 1e-6  # of the largest: a condition by which a member has so much room is not zero
_CONE_TOLERANCE = 1e-9  # the same: a member that misses a condition by less is one


class _Doubts(NamedTuple):
    """Conditions of a branch that may be zero throughout its cone: of contacts, and of limits along the basis."""

    resting: StateConditions
    at_limits: Array

    def allowed_directions(self, branch: Branch) -> Array:
        """(c + dof, k) a basis of the directions that are certainly in the span."""
        return _keep_at_zero(branch, self.resting, self.at_limits)

    def decide(self, branch: Branch) -> Array | None:
        """(c + dof, k) a basis of the span; None: the work for that is more than `MAX_PROGRAM_WORK`.

        One linear program finds every row that is 0 throughout: the largest Σ t with D c ≥ t, 0 ≤ t ≤ 1, has t = 1 for
        the others, because the cone holds the sum of its members. Its unknowns are the changes themselves where these
        have fewer equations than directions, for the sake of the zeros of D.
        """
        (D, _, owners), at_limits = self.resting, self.at_limits
        if not len(owners) + len(at_limits):
            return branch.basis
        equations = branch.equations
        if equations is None or len(equations) >= branch.basis.shape[1]:
            D = scipy.sparse.csr_array(np.vstack([D @ branch.basis, at_limits]))
            equations = np.zeros((0, D.shape[1]))
        rows, k = D.shape
        within = scipy.sparse.hstack([-D, scipy.sparse.eye_array(rows)], format="csr")
        same = scipy.sparse.csr_array(np.hstack([equations, np.zeros((len(equations), rows))]))
        found = scipy.optimize.linprog(
            np.append(np.zeros(k), -np.ones(rows)),
            within,
            np.zeros(rows),
            same if len(equations) else None,
            np.zeros(len(equations)) if len(equations) else None,
            bounds=[(-_PROGRAM_BOUND, _PROGRAM_BOUND)] * k + [(0.0, 1.0)] * rows,
            method="highs",
            options={"maxiter": int(MAX_PROGRAM_WORK / (within.nnz + same.nnz))},
        )
        if found.status != 0:
            return None
        zero = found.x[k:] < 0.5
        at_rest, limits = zero[: len(owners)], zero[len(owners) :]
        return _keep_at_zero(branch, _select_conditions(self.resting, at_rest), at_limits[limits])


def _find_doubts(branch: Branch, change: Array | None) -> _Doubts:
    """Those that a change of `LeastNorm` leaves in doubt; all of them without one, or where it is no member."""
    resting, at_limits = branch.resting, branch.at_limits
    if change is None or not change.any():
        return _Doubts(resting, at_limits)
    room = np.append(resting.rows @ (branch.basis @ change), at_limits @ change)
    size = float(abs(change).max())
    if room.min(initial=0.0) < -_CONE_TOLERANCE * size:
        return _Doubts(resting, at_limits)
    doubt = room <= _CERTAIN_SHARE * size
    count = len(resting.owners)
    return _Doubts(_select_conditions(resting, doubt[:count]), at_limits[doubt[count:]])


def _select_conditions(every: StateConditions, which: Bools) -> StateConditions:
    return StateConditions(every.rows[np.flatnonzero(which)], every.now[which], every.owners[which])


def _keep_at_zero(branch: Branch, resting: StateConditions, at_limits: Array) -> Array:
    """(c + dof, k) a basis of the branch's directions that change none of these conditions."""
    parts = [at_limits]
    for i in np.unique(resting.owners):  # the many faces of a contact's friction come to as many rows as it has forces
        rows = resting.rows[np.flatnonzero(resting.owners == i)]
        at = np.unique(rows.indices)
        own = rows[:, at].toarray()
        parts.append(own[split_row_space(own, _OPEN_SHARE)[0]] @ branch.basis[at])
    D = np.concatenate(parts)
    D = D[abs(D).max(axis=1, initial=0.0) > _OPEN_SHARE]
    return branch.basis @ split_row_space(D, _OPEN_SHARE)[1] if len(D) else branch.basis
