"""What a solution leaves free, in words and SI; and the member of least norm where there is a choice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.active_conditions import Branch, inequalities
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.kind import shifted
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_states import States
from handlcp.grasp.verify.judge import Verdict, limits_at_answer


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
        return f"{forces}, {motion}, {_OTHERS[self.others]}"


_OTHERS = {
    True: "other equilibria exist",
    False: "no other equilibrium exists",
    None: "other equilibria not ruled out (grasp.equilibria() looks for them)",
}
_NOTHING = read_only(np.zeros((0, 6)))
_NOTHING_FREE = {others: Uniqueness(0, _NOTHING, True, others) for others in (False, None)}


def describe(scene: Scene, branches: tuple[Branch, ...], arm: Array) -> Uniqueness:
    """In SI; arm (3,) [m] leads from the contacts' centre to the grasp's reference."""
    others = None if scene.frictional else False
    if not branches:
        return _NOTHING_FREE[others]
    c = scene.components
    U, s, _ = np.linalg.svd(np.hstack([b.basis[c:] for b in branches]), full_matrices=False)
    moving = U[:, s > 1e-9]
    if moving.size:  # whichever way a basis comes out, a direction is told by its largest component, upwards
        moving = moving * np.sign(moving[abs(moving).argmax(axis=0), np.arange(moving.shape[1])])
    twists = np.array([shifted(scene.twist(t), arm) for t in moving.T]).reshape(-1, 6)
    determined = all(float(abs(b.basis[:c]).max()) < 1e-9 for b in branches)
    return Uniqueness(moving.shape[1], read_only(twists), determined, others)


_ROUNDING = 1e-14  # of a unit vector's entries


def minimum_norm(
    scene: Scene, effects: tuple[Effect, ...], section: Section, states: States, candidate: Candidate,
    verdict: Verdict, branches: tuple[Branch, ...],
) -> Candidate:  # fmt: skip
    """The member of least norm (natural units) that keeps every contact in its state; verdict : on the candidate.

    In each branch min ‖x₀ + B c‖ subject to the inequalities of the states (forces push, gaps stay open, friction
    within its limit, slip against the faces): a least-distance problem, solved as nonnegative least squares
    (Lawson & Hanson, Solving Least Squares Problems, chapter 23). What effects limit stays within its limit, and what
    gives way goes on giving way.
    """
    c, units = scene.components, scene.units
    forces, moved = candidate.components / units.force, verdict.motion / units.motion
    x0 = np.concatenate([forces, scene.natural_twist(candidate.twist)])
    best, extra, limited = x0, candidate.extra, limits_at_answer(scene, effects, candidate)
    for branch in branches:
        B = np.where(abs(branch.basis) > _ROUNDING, branch.basis, 0.0)  # between rigid bodies any motion would count
        rows, now = inequalities(scene, section, branch.kind, states, forces, moved, np.arange(scene.n))
        # With y = c + Bᵀx₀: min ‖y‖ subject to A y ≥ h. Rounding must neither shut out the present member (now ≥ 0)
        # nor make a condition of a row that these directions do not touch.
        D, slack = limited.conditions(B, branch.active, branch.multipliers)
        A, size = np.vstack([rows @ B, D]), np.append(abs(rows).max(axis=1), np.ones(len(D)))
        touched = abs(A).max(axis=1) > 1e-10 * size
        A, h = A[touched], np.maximum(np.append(now, slack)[touched], 0.0)
        y = _least(A, A @ (B.T @ x0) - h)
        if y is None:
            continue
        change = y - B.T @ x0
        x = x0 + B @ change
        if x @ x < best @ best:
            best, extra = x, limited.moved(scene, branch.active, branch.multipliers @ change)
    return Candidate(best[:c] * units.force, scene.twist(best[c:]), extra, candidate.soft)


def _least(A: Array, h: Array) -> Array | None:
    """The smallest y with A y ≥ h; None: there is none."""
    from scipy.optimize import nnls  # half a second of import that only loose scenes should pay

    if not len(A):  # scipy's nnls crashes without columns
        return np.zeros(A.shape[1])
    E, e = np.vstack([A.T, h]), np.append(np.zeros(A.shape[1]), 1.0)
    r = e - E @ nnls(E, e)[0]
    return -r[:-1] / r[-1] if r[-1] > 0.0 else None
