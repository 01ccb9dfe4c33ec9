"""Equilibria by what each contact does: one found, or none proved within bounds, by a mixed-integer search over modes.

A contact is open, sticks, slides against a face, or slides at an edge between two faces. In each mode its force r and
its motion v are nonnegative multiples of a few generators: edges of the friction pyramid, normal and face normals.

    G r + w = 0,  v = Gᵀu + E r + d,  r_i = F_i a_i,  v_i = V_i c_i
    0 ≤ a_i ≤ b A_iᵀ y_i,  0 ≤ c_i ≤ b B_iᵀ y_i,  Σ y_i = 1

with binary y_i, natural units: normal forces, gaps and slips along each face up to b, any u. HiGHS branches and bounds.
Its tolerances only widen what counts, so "none" stands. The exact cone is enclosed in sectors: a force within a thin
triangle around the arc, and a slip within the opposite sector. No point of that proves a solution; none proves none.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.assemble import Candidate, GraspContact, assemble_contact
from handlcp.grasp.certify import judge
from handlcp.grasp.effects import Effect, PrescribedForce, TotalForceBound
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.lcp.kernels.lemke import lemke
from handlcp.lcp.reduce import reduce
from handlcp.lcp.search import Outcome
from handlcp.lcp.solvers.nsngrk import NSNGRK
from handlcp.tolerances import PIVOT

__all__ = ["EquilibriumSearch", "OtherEquilibria", "applicable", "find_equilibrium", "other_equilibria", "seeded"]

_NARROW, _WIDE = 10.0, 1e3  # boxes, times 1 + max|d̂|
_CUTS = 8  # choices of modes cut off before the search gives up
_SECTORS = 16  # that enclose the exact cone


@dataclass(frozen=True, slots=True)
class EquilibriumSearch:
    """What a search established.

    outcome : "solution" (certified), "none" (proved within the bounds) or "unknown" (time or cuts spent).
    candidate : the certified answer, or None.
    force_bound [N], motion_bound [m] : "none" is said of normal forces up to the one, and of gaps and slips (along
        each face that is slid against) up to the other.
    seconds : wall time. cuts : choices of modes that the certifier refused.
    """

    outcome: Outcome
    candidate: Candidate | None
    force_bound: float
    motion_bound: float
    seconds: float
    cuts: int


def applicable(effects: tuple[Effect, ...]) -> bool:
    """Whether contact modes describe the scene: no effect opens contacts by unknowns of its own (TotalForceBound)."""
    return all(type(e).opening is Effect.opening for e in effects)


def find_equilibrium(
    scene: Scene,
    effects: tuple[Effect, ...],
    section: Section,
    seconds: float = 10.0,
    bound: float | None = None,
) -> EquilibriumSearch:
    """Search with forces and motions up to `bound` natural units; None: up to 1000 (1 + max|d̂|), and where that comes
    to nothing once more in a hundredth of it, where solutions are found more easily but none cannot be proved.

    effects : of the scene, as stamped; they must be `applicable` (ValueError otherwise). What the search finds is
    solved exactly for its modes, then by Newton's method from there (for the exact cone that is needed), and believed
    only when the certifier passes it.
    """
    if not applicable(effects):
        raise ValueError("an effect opens the contacts; search the assembled problem with handlcp.lcp.search")
    start, program = time.monotonic(), _Program(scene, effects, section)
    believed = _Believer(scene, effects, section)
    size = 1.0 + float(abs(program.offset).max(initial=0.0))
    boxes = [(_WIDE * size, 0.7 * seconds), (_NARROW * size, seconds)] if bound is None else [(float(bound), seconds)]
    outcome: Outcome = "unknown"
    candidate, cuts, b = None, 0, boxes[0][0]
    for b, until in boxes:
        for points in program.visit(b, start + until, _CUTS):
            candidate = believed(points)
            if candidate is not None:
                outcome = "solution"
                break
            cuts += 1
        if outcome == "unknown" and cuts == 0 and program.exhausted and b == boxes[0][0]:
            outcome = "none"
        if outcome != "unknown":
            break
    units = scene.units
    return EquilibriumSearch(outcome, candidate, b * units.force, b * units.motion, time.monotonic() - start, cuts)


@dataclass(frozen=True, slots=True)
class OtherEquilibria:
    """Certified equilibria whose forces differ from the known one's and from each other's by more than 1e-6, relative.

    candidates : the others found. Where forces are not determined (`Uniqueness`), they may be members of one continuum.
    exhaustive : whether every choice of modes was visited (within the bounds of `find_equilibrium`), so that there are
        no others: but of a choice that leaves forces undetermined one member only.
    """

    candidates: tuple[Candidate, ...]
    exhaustive: bool


def other_equilibria(
    scene: Scene,
    effects: tuple[Effect, ...],
    section: Section,
    known: Candidate,
    starts: Iterable[Candidate] = (),
    seconds: float = 2.0,
    most: int = 16,
) -> OtherEquilibria:
    """Other equilibria of a scene with the certified answer `known`.

    starts : answers of other seeds and starts (`seeded`), certified here. Then, where modes describe the scene and for
    the exact cone never, every choice of modes, one after the other, within `seconds`. most : stop at so many.
    """
    found, believed = [known], _Believer(scene, effects, section)

    def add(candidates: Iterable[Candidate]) -> bool:
        c = believed(candidates)
        if c is not None and all(_apart(c.forces, k.forces) for k in found):
            found.append(c)
        return c is not None

    for start in starts:
        add([start])
    exhaustive = False
    if applicable(effects) and section.faces and len(found) <= most:
        program = _Program(scene, effects, section)
        b = _WIDE * (1.0 + float(abs(program.offset).max(initial=0.0)))
        sound = True
        for points in program.visit(b, time.monotonic() + seconds, 64):
            sound = add(points) and sound
            if len(found) > most:
                break
        exhaustive = sound and program.exhausted
    return OtherEquilibria(tuple(found[1:]), exhaustive)


def seeded(problem: GraspContact, runs: int = 4, seed: int = 1) -> Iterator[Candidate]:
    """Candidates of NSNGRK from other starts with other seeds, and of Lemke's method with other covering vectors (on
    the pyramid, or an 8-face one for the exact cone, from which Newton's method goes on).
    """
    rng, method = np.random.default_rng(seed), NSNGRK(max_iterations=16 * problem.n)
    pyramid = None if problem.pyramid is None else problem.pyramid(problem.faces if problem.faces > 2 else 8)
    for k in range(runs):
        start = rng.exponential(size=problem.n) * rng.choice([-1.0, 0.0, 1.0], problem.n)
        start[problem.role == 1] = abs(start[problem.role == 1])
        yield problem.candidate(replace(method, seed=seed + k).propose_contact(problem, start).z)
        if pyramid is not None:
            lcp, back = pyramid
            r = reduce(lcp.scaled)
            _, _, v = lemke(r.M, r.q, 10.0 ** rng.uniform(-1, 1, len(r.q)), 50 + 20 * len(r.q), PIVOT)
            yield problem.candidate(method.propose_contact(problem, back(r.restore(v))).z)


def _apart(a: Array, b: Array) -> bool:
    return float(abs(a - b).max()) > 1e-6 * max(float(abs(a).max()), float(abs(b).max()))


class _Believer:
    """Called with candidates: the first that the certifier passes, as it is or after Newton's method from there."""

    def __init__(self, scene: Scene, effects: tuple[Effect, ...], section: Section) -> None:
        self.scene, self.effects, self.section = scene, effects, section
        asked = tuple(e for e in effects if isinstance(e, (PrescribedForce, TotalForceBound)))
        self.problem = assemble_contact(scene, section, asked)

    def __call__(self, candidates: Iterable[Candidate]) -> Candidate | None:
        for candidate in candidates:
            for c in (candidate, self._newton(candidate)):
                if judge(self.scene, self.effects, self.section, c).residuals.passes:
                    return c
        return None

    def _newton(self, c: Candidate) -> Candidate:
        s, problem = self.scene, self.problem
        forces = c.forces.ravel() / s.units.force
        twist = (c.twist if s.freedom is None else s.freedom @ c.twist) / s.twist_units
        x = np.zeros(problem.n)
        for group, value in (("r_N", forces[s.normal_index]), ("r_T", forces[s.tangent_index]), ("u", twist)):
            x[[label.startswith(f"{group}[") for label in problem.labels]] = value
        return problem.candidate(NSNGRK(max_iterations=0).propose_contact(problem, x).z)


def _modes(mu: float, section: Section) -> tuple[Array, Array, Bools, Bools]:
    """Force generators (3, a), motion generators (3, c), and which of them each mode allows, (modes, a), (modes, c).

    mu : the section's limit. Modes: open; stuck; sliding along each face's normal and at each edge (interval: at each
    end; cone: within each sector). Without friction: open, touching. Motion generators end with the normal: the gap.
    """
    up = np.array([[0.0], [0.0], [1.0]])
    if mu <= 0.0:
        return up, up, np.array([[False], [True]]), np.array([[True], [False]])
    if section.faces == 2:
        ends = np.array([[mu, -mu], [0.0, 0.0], [1.0, 1.0]])
        motion = np.hstack([np.array([[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]), up])
        return ends, motion, _rows([0, 0], [1, 1], np.eye(2)), _rows([1, 1, 1], [0, 0, 0], np.eye(2, 3))
    m = section.faces or _SECTORS
    a, one = 2 * np.pi * np.arange(m) / m, np.eye(m)
    inner = np.vstack([np.cos(a), np.sin(a)])  # face normals; for the cone: the rays between sectors
    outer = np.vstack([np.cos(a + np.pi / m), np.sin(a + np.pi / m)]) / np.cos(np.pi / m)  # between j and j + 1
    motion = np.hstack([np.vstack([-inner, np.zeros(m)]), up])
    both, neither = one + np.roll(one, 1, 1), np.zeros((m, 1))  # row j: j and j + 1
    if section.faces:
        before = one + np.roll(one, -1, 1)  # row j: the edges j - 1 and j on both sides of face j
        force = np.vstack([mu * outer, np.ones(m)])
        return (
            force,
            motion,
            _rows(np.zeros(m), np.ones(m), before, one),
            _rows(np.ones(m + 1), np.zeros(m + 1), np.hstack([one, neither]), np.hstack([both, neither])),
        )
    force = np.vstack([mu * np.hstack([outer, inner]), np.ones(2 * m)])
    stuck = np.append(np.ones(m), np.zeros(m))
    return (
        force,
        motion,
        _rows(np.zeros(2 * m), stuck, np.hstack([one, both])),
        _rows(np.ones(m + 1), np.zeros(m + 1), np.hstack([both, neither])),
    )


def _rows(*parts: Any) -> Bools:
    return np.vstack([np.atleast_2d(np.asarray(p)) for p in parts]) > 0


class _Program:
    """The program of the module's docstring. Unknowns: per governed contact a_i, c_i, y_i, β_i; then u.

    β_i are bits of the direction in which the contact slides, in Gray code: sums of y_i that have to be integers, too,
    so that branching can split directions in halves. Half the time at 8 and 16 faces.
    """

    def __init__(self, scene: Scene, effects: tuple[Effect, ...], section: Section) -> None:
        units, dof = scene.units, scene.dof
        self.scene, self.given, self.exhausted = scene, np.zeros(3 * scene.n), False
        for e in effects:
            if isinstance(e, PrescribedForce):
                self.given[3 * e.contact : 3 * e.contact + 3] = e.force / units.force
        E = scene.flexibility * (units.force / units.motion)
        self.offset = scene.offset.ravel() / units.motion + E @ self.given
        limits = section.limit(scene.mu)
        mine = [i for i in range(scene.n) if scene.governed[i]]
        kinds = [_modes(float(limits[i]), section) for i in mine]
        codes = [_gray(len(A) - 2, section.faces) for _, _, A, _ in kinds]
        sizes = [(F.shape[1], V.shape[1], len(A), len(c)) for (F, V, A, _), c in zip(kinds, codes, strict=True)]
        self.nv = nv = int(np.sum(sizes)) + dof
        self.force, self.motion = np.zeros((3 * scene.n, nv)), np.zeros((3 * scene.n, nv))
        self.allow, self.one = np.zeros((nv, nv), bool), np.zeros((len(mine), nv))
        self.share = np.zeros((len(mine), nv))  # Σ a_i: the normal force
        self.bits = np.zeros((sum(s[3] for s in sizes), nv))  # Σ y_i - β_i
        self.opened: list[int] = []
        rows, at, bit = [], 0, 0
        for k, (i, (F, V, A, B), code) in enumerate(zip(mine, kinds, codes, strict=True)):
            f, v, y, beta = np.split(np.arange(at, at + sum(sizes[k])), np.cumsum(sizes[k])[:-1])
            self.force[3 * i : 3 * i + 3, f], self.motion[3 * i : 3 * i + 3, v] = F, V
            self.allow[np.ix_(f, y)], self.allow[np.ix_(v, y)] = A.T, B.T
            self.one[k, y], self.share[k, f] = 1.0, 1.0
            self.bits[bit : bit + len(beta), y[2:]] = code
            self.bits[bit + np.arange(len(beta)), beta] = -1.0
            self.opened.append(int(y[0]))
            tangents = [] if limits[i] <= 0 else [3 * i] if scene.plane is not None else [3 * i, 3 * i + 1]
            rows += [*tangents, 3 * i + 2]
            at, bit = at + sum(sizes[k]), bit + len(beta)
        self.mode, self.bounded = self.one.any(0), self.allow.any(1)
        self.integer = self.mode | (self.bits < 0).any(0)
        twist = np.zeros((3 * scene.n, nv))
        twist[:, nv - dof :] = scene.natural.every.T
        self.eq = np.vstack([(self.motion - E @ self.force - twist)[rows], scene.natural.every @ self.force])
        self.rhs = np.append(self.offset[rows], -scene.natural.w - scene.natural.every @ self.given)
        self.low = np.where(np.arange(nv) < nv - dof, 0.0, -np.inf)
        self.cost = (self.motion != 0).any(0).astype(float)

    def visit(self, b: float, end: float, most: int) -> Iterator[Iterator[Candidate]]:
        """One choice of modes after the other (at most `most`), each as candidates; a choice is cut off once visited.

        `exhausted` says afterwards whether HiGHS proved that no choice within the bound b is left.
        """
        from scipy.optimize import Bounds, LinearConstraint, milp  # half a second of import that few solves should pay

        self.exhausted = False
        tight = self.share.copy()  # an open contact carries nothing
        tight[np.arange(len(tight)), self.opened] = b
        big = np.vstack([tight, np.eye(self.nv)[self.bounded] - b * self.allow[self.bounded]])
        top = np.append(np.full(len(tight), b), np.zeros(int(self.bounded.sum())))
        constraints = [
            LinearConstraint(np.vstack([self.eq, self.bits]), *[np.append(self.rhs, np.zeros(len(self.bits)))] * 2),
            LinearConstraint(self.one, 1, 1),
            LinearConstraint(big, -np.inf, top),
        ]
        bounds = Bounds(self.low, np.where(self.integer, 1.0, np.inf))
        for _ in range(most + 1):
            if (left := end - time.monotonic()) <= 0:
                return
            options = {"time_limit": left, "mip_rel_gap": 1e9}  # any feasible point will do
            r = milp(self.cost, constraints=constraints, integrality=self.integer, bounds=bounds, options=options)
            if r.x is None:
                self.exhausted = r.status == 2
                return
            y = self.mode & (r.x > 0.5)
            yield self._members(y, r.x)
            constraints.append(LinearConstraint(y.astype(float)[None], -np.inf, len(self.opened) - 1))

    def _members(self, y: Bools, near: Array) -> Iterator[Candidate]:
        """Of the modes y: a vertex, its support solved once more to the last digits, then without that; then `near`."""
        from scipy.optimize import linprog

        use = (~self.bounded | self.allow[:, y].any(1)) & ~self.integer
        lp = linprog(
            self.cost[use],
            A_eq=self.eq[:, use],
            b_eq=self.rhs,
            bounds=np.column_stack([self.low[use], np.full(int(use.sum()), np.inf)]),
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10},
        )
        if lp.x is not None:
            x = np.zeros(self.nv)
            x[use] = lp.x
            support = use & ((x > 0.0) | (self.low < 0.0))
            exact = x.copy()
            exact[support] += np.linalg.lstsq(self.eq[:, support], self.rhs - self.eq @ x, rcond=1e-13)[0]
            yield self._decode(np.maximum(exact, self.low))
            yield self._decode(x)
        yield self._decode(near)

    def _decode(self, x: Array) -> Candidate:
        s = self.scene
        forces = (self.force @ x + self.given) * s.units.force
        return Candidate(forces.reshape(-1, 3), s.twist(x[self.nv - s.dof :]), {})


def _gray(slides: int, faces: int) -> Array:
    """(bits, slides) Gray code of the directions in the order of their angles: faces, then the edges that follow each;
    or the sectors of the cone.
    """
    if slides <= 2:
        return np.zeros((0, max(slides, 0)))
    order = np.arange(slides) if not faces else np.append(2 * np.arange(faces), 2 * np.arange(faces) + 1)
    return np.array([((order ^ (order >> 1)) >> k) & 1 for k in range(int(slides - 1).bit_length())], dtype=float)
