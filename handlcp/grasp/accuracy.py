"""Asking for an accuracy instead of settings: the cheapest setting whose force error is shown to keep it.

A solver that knows friction as a set takes the exact cone for any request: pyramids of 4 to 64 faces would take 5 or
6 % longer (median of 340 scenes), and an answer on one says nothing of its error. What is left of an error on the cone
is the solver's and rounding's (`force_error`). A plane's interval, and contacts without friction, are exact whatever
the solver.

A solver that knows no cones gets inscribed pyramids. Their error is measured against the cone's equilibrium next to
them, which Newton's method finds from their answer in less time than the pyramid took. On 216 scenes where something
slides its median is 0.13, 0.033, 0.011, 0.0044, 0.0018 and 0.0011 with 4, 8, …, 128 faces: at first it falls as 1/m²,
like the pyramid's limit, then as 1/m, because a sliding contact pulls along an edge, up to π/m beside its slip. So the
number of faces is predicted as m^-1.5, and the prediction is verified.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

from handlcp.check import Array, number
from handlcp.errors import NoSolutionFound, Unsupported
from handlcp.grasp.achieved import Accuracy, Bracket
from handlcp.grasp.assemble import assemble_contact
from handlcp.grasp.force_error import difference, force_error
from handlcp.grasp.pyramid import Cone, Pyramid, as_section
from handlcp.lcp import Auto, ContactSolver, SemismoothNewton, Solver, Status, as_chain

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp
    from handlcp.grasp.solution import GraspSolution

__all__ = ["solve_to"]

AnySolver = Solver | ContactSolver | Auto | None

_FEWEST, _MOST = 4, 256  # faces of the pyramids to choose from
_MOST_MULTIPLIERS = 2500  # of all contacts together, beyond which pivoting takes seconds
_FALL = 1.5  # the error falls about as this power of the number of faces
_LEAP = 4.0  # at most as many times the faces as before
_SURE = 16  # faces from which on the error is as regular as that
_BLIND = 4  # pyramids, each with twice the faces, that may pass without an equilibrium on the cone near them
_NEWTON = SemismoothNewton()
_FINEST = SemismoothNewton(tol=1e-13)  # as far as rounding lets Newton's method go
_BESIDE_CONE = 8  # faces of the bracket beside a cone


def solve_to(
    grasp: Grasp, accuracy: float, solver: AnySolver, throw: bool, start: GraspSolution | None = None
) -> GraspSolution:
    """The solution by the cheapest setting that keeps the force error below `accuracy`, with its `Accuracy`.

    A proof that nothing holds the object, or that there is no equilibrium, is a final answer and passes unchanged.
    Raises NoSolutionFound where there is no answer or no setting is shown to keep it, unless `throw` is False;
    InputError for anything but an accuracy > 0 and a solver.
    """
    asked = number("accuracy", accuracy, above=0.0)
    if grasp.scene.soft:
        raise Unsupported("accuracy= knows no soft fingers: solve(faces) and solve('cone') do")
    run = _Run(grasp, solver, start)
    found = _on_pyramids(run, asked) if run.plain and not run.exact else _on_cone(run, asked)
    reached = Accuracy(
        asked, found.error, found.setting, run.solves, time.perf_counter() - run.begun,
        None if run.exact or not found.solution.held else partial(_bracket, grasp, solver, found),
    )  # fmt: skip
    solution = replace(found.solution, accuracy=reached, trace=(*found.solution.trace, f"accuracy: {reached}"))
    if throw and not (solution.held and reached.met):
        lines = (str(solution), *solution.trace)
        if solution.held:
            lines = (
                f"no setting is shown to keep what was asked for: {reached}",
                _advice(reached, not found.faces),
                *lines,
            )
        section = as_section("cone", planar=grasp.scene.plane is not None)
        raise NoSolutionFound("\n  ".join(lines), assemble_contact(grasp.scene, section, grasp.effects), solution)
    return solution


@dataclass(frozen=True, slots=True)
class _Found:
    """A solution, its setting in words, its error (NaN: not known), its pyramid's faces (0: none) and the forces (n, 3)
    [N] of the cone's equilibrium next to it.
    """

    solution: GraspSolution
    setting: str
    error: float
    faces: int = 0
    cone: Array | None = None


@dataclass(slots=True)
class _Run:
    """One request: counts the solves and the time."""

    grasp: Grasp
    solver: AnySolver
    start: GraspSolution | None = None
    solves: int = 0
    begun: float = field(default_factory=time.perf_counter)
    plain: bool = False  # whether the solver has multipliers of faces, and knows no sets

    def __post_init__(self) -> None:
        """Look at the solver once: protocols take their time."""
        if as_chain(self.solver) is None:
            self.plain = isinstance(self.solver, Solver) and not isinstance(self.solver, ContactSolver)

    @property
    def exact(self) -> bool:
        """Whether every section is the same: a plane's interval, or no friction at all."""
        return self.grasp.scene.plane is not None or not self.grasp.scene.rough

    @property
    def setting(self) -> str:
        """The exact section in words."""
        scene = self.grasp.scene
        return as_section("cone", planar=scene.plane is not None).name if scene.rough else "exact, no friction"

    def solve(self, faces: str | Pyramid, solver: AnySolver, start: GraspSolution | None = None) -> GraspSolution:
        """One more solve, from where it is told to or where the request begins."""
        self.solves += 1
        return self.grasp.solve(faces, solver, throw=False, start=start or self.start)

    def error(self, solution: GraspSolution) -> float:
        """Of an answer on the exact section."""
        if not solution.held:
            return math.nan
        section = as_section("cone", planar=self.grasp.scene.plane is not None)
        return force_error(assemble_contact(self.grasp.scene, section, self.grasp.effects), solution)


def _on_cone(run: _Run, asked: float) -> _Found:
    """The exact section; Newton's method once more where the answer isn't fine enough; pyramids to start from where
    there is none.
    """
    # Without friction, or in a plane, a pyramid stands for the exact section that a plain method has multipliers for
    solution = run.solve(Pyramid(_FEWEST) if run.plain else "cone", run.solver)
    if solution.status is Status.UNDECIDED and not run.exact:
        return _through_pyramids(run, _Found(solution, run.setting, math.nan))
    found = _Found(solution, run.setting, run.error(solution), cone=solution.forces)
    if solution.held and not found.error <= asked:
        finer = run.solve("cone", _FINEST, solution)
        if (error := run.error(finer)) < found.error:
            return _Found(finer, f"{run.setting}, more Newton steps", error, cone=finer.forces)
    return found


def _through_pyramids(run: _Run, found: _Found) -> _Found:
    """Newton's method on the cone from the answers of pyramids; where none leads there, the finest pyramid's answer."""
    solver = _for_pyramids(run.solver)
    for faces in (_FEWEST << k for k in range(_BLIND)):
        pyramid = Pyramid(faces)
        solution = run.solve(pyramid, solver)
        if not solution.held:
            continue
        cone = run.solve("cone", _NEWTON, solution)
        if cone.held:
            return _Found(cone, f"{run.setting}, from the {pyramid.name}", run.error(cone), cone=cone.forces)
        found = _Found(solution, pyramid.name, math.nan, faces)
    return found


def _for_pyramids(solver: AnySolver) -> Solver | Auto:
    """The solver, or a chain in place of one that knows cones alone; without a search, which the cone has had."""
    if isinstance(solver, Solver):
        return solver
    return replace(as_chain(solver) or Auto(), search_seconds=0.0)


def _on_pyramids(run: _Run, asked: float) -> _Found:
    """The fewest faces that a few solves find to keep the request; else the best there was."""
    most = min(_MOST, max(_FEWEST, _MOST_MULTIPLIERS // len(run.grasp.scene.rough)))
    faces, blind = _FEWEST, 0
    best: _Found | None = None
    while True:
        found = _against_cone(run, Pyramid(faces))
        if best is None or _better(found, best):
            best = found
        if found.error <= asked or (found.faces == 0 and found.solution.status is Status.NOT_HOLDABLE):
            return found
        if faces == most:
            return best
        if found.error >= 0.0:
            # Even a limit that shrinks as 1/m² would not do with the most faces
            if faces >= _SURE and faces * math.sqrt(found.error / asked) > most:
                return best
            wanted = faces * (found.error / asked) ** (1.0 / _FALL)
            faces = min(most, 4 * math.ceil(min(max(wanted, 1.2 * faces), _LEAP * faces) / 4.0))
        else:
            blind += 1
            if blind == _BLIND:
                return best
            faces = min(most, 2 * faces)


def _better(found: _Found, best: _Found) -> bool:
    """Whether its error is smaller, or known at all; an answer comes before none."""
    if found.error >= 0.0:
        return not best.error <= found.error
    return found.solution.held and not best.solution.held


def _against_cone(run: _Run, pyramid: Pyramid) -> _Found:
    """A pyramid's answer, measured by the cone's equilibrium next to it."""
    solution = run.solve(pyramid, run.solver)
    cone = run.solve("cone", _NEWTON, solution if solution.held else None)
    if cone.status is Status.NOT_HOLDABLE and not solution.held:
        return _Found(cone, Cone().name, math.nan)
    if not (solution.held and cone.held):
        return _Found(solution, pyramid.name, math.nan, int(pyramid.faces))
    unit = run.grasp.scene.units.force
    error = difference(solution.forces / unit, cone.forces / unit) + run.error(cone)
    return _Found(solution, pyramid.name, error, int(pyramid.faces), cone.forces)


def _bracket(grasp: Grasp, solver: AnySolver, found: _Found) -> Bracket | None:
    """See `Accuracy.bracket`."""
    if found.cone is None:
        return None
    faces, inner, method = found.faces or _BESIDE_CONE, found.solution, _for_pyramids(solver)
    if not found.faces:
        inner = grasp.solve(Pyramid(faces), method, throw=False, start=found.solution)
    outer = grasp.solve(Pyramid(faces, inscribed=False), method, throw=False, start=found.solution)
    return Bracket(faces, inner.forces, outer.forces, found.cone) if inner.held and outer.held else None


def _advice(reached: Accuracy, on_cone: bool) -> str:
    """What to try."""
    if on_cone:
        return f"double precision shows no more here: ask for {2.0 * reached.error:.0e}"
    if math.isnan(reached.error):
        return "no equilibrium on the cone was found near the pyramid's: solve(faces) gives the pyramid's alone"
    return f"pyramids of {_MOST} faces seldom get below 1e-3: take the default solver, which knows the cone"
