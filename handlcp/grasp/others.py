"""All the equilibria of a grasp, as far as they can be found: with Coulomb friction there may be several.

Without friction there are no others (`Uniqueness`). On a pyramid, and in a plane, every choice of contact modes, and of
limits that give way, is solved where that is affordable. The exact cone has a continuum of modes: there, and beyond
what is affordable, Newton's method starts from all equilibria of coarser pyramids and from other seeds, which proves
nothing.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array, number
from handlcp.grasp.assemble import GraspContact, assemble_contact
from handlcp.grasp.candidate import Candidate, of_solution
from handlcp.grasp.catalogue import asked_for
from handlcp.grasp.certify import judge
from handlcp.grasp.equilibria import Believer, applicable
from handlcp.grasp.mode_table import PER_SECOND, Table, mode_table
from handlcp.grasp.overload import overload
from handlcp.grasp.pyramid import Pyramid, Section, as_section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_form import GraspBalls, chain_form
from handlcp.grasp.solution import GraspSolution
from handlcp.lcp import Auto, proposals
from handlcp.lcp.kernels.lemke import lemke
from handlcp.lcp.reduce import reduce
from handlcp.lcp.solvers.nsngrk import NSNGRK
from handlcp.lcp.status import Status
from handlcp.tolerances import ACTIVE, PIVOT

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["Equilibria", "equilibria", "seeded"]

_COARSER = (12, 8, 6, 5, 4, 3)  # faces of pyramids whose equilibria are good places to start from
_RUNS = 8  # other seeds and starts
_APART = 1e-6  # of the largest force, or of the scene's: forces that differ by less are the same


@dataclass(frozen=True, slots=True)
class Equilibria:
    """The equilibria of a grasp, every one certified: `for solution in equilibria`, `len(equilibria)`.

    found : smallest forces first; their `uniqueness.others` says whether others exist. Members of one family of
        undetermined forces count as one, which gives its smallest.
    complete : whether it is proven that there are no others.
    why : what proves it, or why that is open.
    seconds : wall time.
    """

    found: tuple[GraspSolution, ...]
    complete: bool
    why: str
    seconds: float

    def __len__(self) -> int:
        """How many were found."""
        return len(self.found)

    def __iter__(self) -> Iterator[GraspSolution]:
        """Smallest forces first."""
        return iter(self.found)

    def __str__(self) -> str:
        k = len(self.found)
        if not k:
            return f"no equilibrium {'exists' if self.complete else 'was found'}: {self.why}"
        proof = f"{'proven' if self.complete else 'not proven'}: {self.why}"
        if k == 1:
            head = "one equilibrium and no other" if self.complete else "one equilibrium found; others may exist"
            return f"{head} ({proof})\n  {_line(self.found[0])}"
        head = f"{k} equilibria{' and no more' if self.complete else ' found; more may exist'} ({proof})"
        lines = [f"  {i}. {_line(s)}" for i, s in enumerate(self.found, 1)]
        which = "  in which of them the hand ends up depends on how it gets there: friction remembers the way"
        return "\n".join([head, *lines, which])


def _line(s: GraspSolution) -> str:
    noise = ACTIVE * s.residuals.force_scale  # below this a contact is said not to push
    forces = ", ".join("0" if abs(f) <= noise else f"{f:.3g}" for f in s.normal_force)
    return f"normal forces ({forces}) N, {replace(s, uniqueness=None).diagnosis}"


def equilibria(grasp: Grasp, faces: int | str | Pyramid, seconds: float) -> Equilibria:
    """See `Grasp.equilibria`."""
    start, section = time.monotonic(), as_section(faces, planar=grasp.scene.plane is not None)
    number("seconds", seconds, above=0.0)
    first = grasp.solve(faces, Auto(search_seconds=0.0), throw=False)
    if first.status is Status.NOT_HOLDABLE:
        return _result(grasp, [], True, "no forces within friction balance the load", start)
    if not first.held and overload(grasp.scene, section, grasp.effects) is not None:
        return _result(grasp, [], True, "no forces within friction and limits balance the load", start)
    found = [first] if first.held else []
    if grasp.scene.soft:
        _from_other_seeds(grasp, section, found, start + seconds)
        return _result(grasp, found, False, "contact modes know no moments about normals", start)
    problem = assemble_contact(grasp.scene, section, grasp.effects)
    if found and not len(problem.blocks):
        return _result(grasp, found, True, "without friction the laws are monotone", start)
    believed = Believer(grasp.scene, problem.effects, section)
    table = mode_table(problem) if section.faces and applicable(problem.effects) else None
    complete, why, end = False, _open(problem, section, table), start + seconds
    passed: list[Candidate | None] = []
    noise = _APART * grasp.scene.units.force
    if table is not None and table.choices <= PER_SECOND * seconds:
        candidates, every = table.visit()
        end = time.monotonic() + seconds - table.choices / PER_SECOND  # whatever was compiled before
        passed = [believed([c]) for c in _until(end, candidates)]
        late = time.monotonic() > end
        complete = (
            every and not late and None not in passed and (not found or _contains(grasp.scene, passed, found[0], noise))
        )
        why = "the time was too short" if late else "some are degenerate"
        if complete:
            why = f"all {table.choices:,.0f} choices of contact modes were solved"
    if not complete:
        passed += [believed([c]) for c in _starts(problem, section, end)]
    for candidate in passed:
        if candidate is not None:
            _add(grasp, problem, section, found, candidate)
    return _result(grasp, found, complete, why, start)


def _from_other_seeds(grasp: Grasp, section: Section, found: list[GraspSolution], end: float) -> None:
    """What the chain of stages ends at with other seeds."""
    problem, seed = chain_form(grasp.scene, section, grasp.stamped), 0
    while time.monotonic() < end and seed < _RUNS:
        seed += 1
        for _, p in proposals(problem, Auto(seed=seed)):
            candidate = problem.candidate(p.z)
            if judge(grasp.scene, problem.effects, section, candidate).residuals.passes:
                _add(grasp, problem, section, found, candidate)


def _contains(scene: Scene, candidates: list[Candidate | None], s: GraspSolution, noise: float) -> bool:
    """Whether the answer that is known is among them, as it must be; of a family any member may be."""
    determined = s.uniqueness is not None and s.uniqueness.forces_determined
    return not determined or any(
        c is not None and _close(scene.physical(c.forces), s.forces, noise) for c in candidates
    )


def _open(problem: GraspContact, section: Section, table: Table | None) -> str:
    """Why contact modes prove nothing, where they don't."""
    if not applicable(problem.effects):
        return "an effect moves the contacts, so their modes do not describe them"
    if not section.faces:
        return "the exact cone has a continuum of slip directions"
    if table is None:
        return "forces of rigid fingers are not determined where they stick"
    return f"{table.choices:.2g} choices of contact modes are too many for the time"


def _starts(problem: GraspContact, section: Section, end: float) -> Iterator[Candidate]:
    """Answers of coarser pyramids, as many as the time allows, then of other seeds and starts."""
    asked = asked_for(problem.effects)
    coarser = _COARSER if applicable(problem.effects) and section.faces != 2 else ()
    for faces in coarser:
        if faces == section.faces:
            continue
        table = mode_table(assemble_contact(problem.scene, Pyramid(faces), asked))
        if table is not None and table.choices <= 0.5 * PER_SECOND * (end - time.monotonic()):
            yield from _until(end, table.visit()[0])
    for candidate in seeded(problem, _RUNS):
        yield candidate
        if time.monotonic() > end:
            return


def _until(end: float, candidates: Iterator[Candidate | None]) -> Iterator[Candidate]:
    for candidate in candidates:
        if candidate is not None:
            yield candidate
        if time.monotonic() > end:
            return


def _add(
    grasp: Grasp,
    problem: GraspContact | GraspBalls,
    section: Section,
    found: list[GraspSolution],
    candidate: Candidate,
) -> None:
    """Append what is no member of a family already found: its smallest member is that one's, or halfway to that one
    there is an equilibrium as well (what one choice of modes allows is convex).
    """
    noise = _APART * grasp.scene.units.force
    if any(_close(grasp.scene.physical(candidate.forces), s.forces, noise) for s in found):
        return
    verdict = judge(grasp.scene, problem.effects, section, candidate)
    made = grasp._solution(problem.effects, section, candidate, verdict, 0, ("another equilibrium",))
    for s in found:
        if _close(made.forces, s.forces, noise):
            return
        loose = [x for x in (s, made) if x.uniqueness is not None and not x.uniqueness.forces_determined]
        if loose and judge(grasp.scene, problem.effects, section, _halfway(grasp, s, made)).residuals.passes:
            return
    found.append(made)


def _close(a: Array, b: Array, noise: float) -> bool:
    """Within `noise` [N] too: where no force is needed, what rounding leaves of it differs by all of its size."""
    return float(abs(a - b).max()) <= max(_APART * float(abs(a).max()), _APART * float(abs(b).max()), noise)


def _halfway(grasp: Grasp, a: GraspSolution, b: GraspSolution) -> Candidate:
    one, other = of_solution(grasp.scene, a), of_solution(grasp.scene, b)
    extra = {name: 0.5 * (a.extra[name] + b.extra[name]) for name in a.extra}
    forces, twist = 0.5 * (one.forces + other.forces), 0.5 * (one.twist + other.twist)
    return Candidate(forces, twist, extra, 0.5 * (one.torsion + other.torsion))


def _result(grasp: Grasp, found: list[GraspSolution], complete: bool, why: str, start: float) -> Equilibria:
    others = len(found) > 1 or (False if complete else None)
    known = [replace(s, uniqueness=replace(s.uniqueness, others=others)) for s in found if s.uniqueness is not None]
    known.sort(key=lambda s: float((s.forces**2).sum()))
    return Equilibria(tuple(known), complete, why, time.monotonic() - start)


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
