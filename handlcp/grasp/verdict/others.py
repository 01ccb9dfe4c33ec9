"""Other equilibria of a grasp with few contacts, as far as a handful of solves finds them.

Newton's method goes to the equilibrium near where it starts. It starts from the end of the loading, and from answers of
the same grasp under other loads and squeezes, where one equilibrium may be the only one.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import read_only
from handlcp.grasp.answer.small_motions import motions
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.compiled_answer import start_from
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.lcp import Auto

_CONTACTS = 4  # with more, equilibria are too many to look for
_LOADS, _SQUEEZES = (0.0, 0.5, 2.0), (0.5, 2.0)  # shares of the grasp's own
_APART = 0.01  # of the largest force

_CHAIN = Auto(search_seconds=0.0)


def other_equilibria(
    spec: GraspSpec, scene: Scene, section: Section, solution: GraspSolution, end: GraspSolution
) -> Iterator[Reason]:
    """A note where another one than `solution` is found. end : of the loading."""
    if spec.n > _CONTACTS or not scene.frictional or (solution.uniqueness and solution.uniqueness.others):
        return
    size = float(np.linalg.norm(solution.forces, axis=1).max(initial=0.0))
    starts = [end] if end.held else []
    starts += [s for s in (solve_spec(other, section, _CHAIN, proof=False) for other in _nearby(spec)) if s.held]
    near = far = 0.0  # by how much forces differ, where motions are small, and anywhere
    for start in starts:
        found = solve_spec(spec, section, _CHAIN, start_from(start, scene), scene, proof=False)
        if found.held and (found.uniqueness is None or found.uniqueness.forces_determined):
            differ = float(np.linalg.norm(found.forces - solution.forces, axis=1).max()) / (size or 1.0)
            near, far = near if motions(found).too_large else max(near, differ), max(far, differ)
    lists = "(grasp.equilibria() lists them)"
    if near > _APART:
        by = words.percent(near)
        text = f"friction can hold the object in other ways, too, with forces that differ by {by} {lists}"
        yield Reason("others", "note", text, {"forces_differ": near})
    elif far > _APART:
        text = f"the equations have other answers, too, with motions too large for them {lists}"
        yield Reason("others", "note", text, {"forces_differ": far})


def _nearby(spec: GraspSpec) -> Iterator[GraspSpec]:
    for share in _LOADS:
        yield spec.replace(wrench=read_only(share * spec.wrench))
    for share in _SQUEEZES:
        yield spec.replace(offset=read_only(share * spec.offset))
