"""Example 4: held by friction, yet no elastic equilibrium; a little preload gives one.

Three statements, and what shows each:

- A force in the friction pyramids balances the weight. The certified answer with preload is such a force: preload
  changes elastic displacements, not which forces can hold.
- There is no elastic equilibrium without preload, with normal forces and friction reserves up to 1000 N, slips and gaps
  up to 1 mm. A search over all active sets (`search`) finds none.
- The search does find equilibria that exist: on the preloaded scene it finds the certified forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution
from handlcp.lcp.search import SearchResult, search
from handlcp.study.paper.examples import PRELOAD, example

FORCE_BOUND, MOTION_BOUND = 1000.0, 1e-3  # N, m
WORK = 1e10  # multiply-adds for each search, a minute at most
FACES = (4, 6, 8)
PRELOAD_FACES = 8


@dataclass(frozen=True, slots=True)
class NoEquilibrium:
    """What is known of Example 4.

    unloaded : our answer without preload (6 faces, as Table 9). preloaded : with 5 µm on fingers 1 and 2, 8 faces.
    searches : ((faces, E_T [m/N], result), …) without preload. control : the search on the preloaded scene.
    control_normal : (n,) N normal forces that it found.
    """

    unloaded: GraspSolution
    preloaded: GraspSolution
    searches: tuple[tuple[int, float, SearchResult], ...]
    control: SearchResult
    control_normal: Array

    @property
    def proved(self) -> bool:
        """Whether all searches came out empty and the control did not."""
        return all(r.none_exists for *_, r in self.searches) and self.control.z is not None


def search_grasp(grasp: Grasp, faces: int) -> SearchResult:
    """All active sets, forces within `FORCE_BOUND`, slips and gaps within `MOTION_BOUND`; z in natural units."""
    problem = grasp.problem(faces)
    force = np.array([label.startswith("r_N") for label in problem.labels])
    z, w = np.where(force, FORCE_BOUND, MOTION_BOUND), np.where(force, MOTION_BOUND, FORCE_BOUND)
    return search(problem, z / problem.scaled.units.z, w / problem.scaled.units.w, WORK)


def no_equilibrium() -> NoEquilibrium:
    """Solve and search Example 4, with E_T of the text (Example 2) and with E_T = E_N, which its printed slips fit."""
    bare, preloaded = example(4).grasp, example(4, preload=PRELOAD).grasp
    E_T, _, E_N = bare.scene.flexibility.diagonal()[:3].tolist()
    searches = tuple(
        (faces, value, search_grasp(example(4, tangential=value).grasp, faces))
        for value in (E_T, E_N)
        for faces in FACES
    )
    control = search_grasp(preloaded, PRELOAD_FACES)
    normal = np.full(3, np.nan)
    if control.z is not None:
        normal = preloaded.problem(PRELOAD_FACES).candidate(control.z).forces[:, 2]
    return NoEquilibrium(bare.solve(6, throw=False), preloaded.solve(PRELOAD_FACES), searches, control, normal)
