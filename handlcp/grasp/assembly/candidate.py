"""A solver's answer as mechanics."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.grasp_matrix import Posed
from handlcp.grasp.model.kind import shifted
from handlcp.grasp.model.scene import Scene
from handlcp.lcp.kernels.dense import kernel


class Candidate(NamedTuple):
    """SI, in the coordinates of the scene's friction laws: components (c,) [N], of all forces; twist (6,) about the
    contacts' centre; the unknowns of further effects by group name; soft : how many contacts bear a moment.
    """

    components: Array
    twist: Array
    extra: dict[str, Array]
    soft: int = 0

    @property
    def forces(self) -> Array:
        """(n, 3) N, in the coordinates of the friction laws."""
        return self.components[: len(self.components) - self.soft].reshape(-1, 3)


@kernel
def in_si(
    x: Array, unknown: Ints, normals: int, at: tuple[int, int, int], prescribed: Array, p: Posed, dof: int
) -> tuple[Array, Array]:
    """Forces (c,) [N] and (dof,) motion [m, rad] from the unknowns x. unknown : which components, so many normal ones
    first; at : where normal forces, tangential forces and the motion begin among the unknowns.
    """
    f, u = prescribed.copy(), np.empty(dof)
    for k in range(len(unknown)):
        f[unknown[k]] = x[at[0] + k if k < normals else at[1] + k - normals] * p.force
    lengths = 3 if dof == 6 else 2
    for k in range(dof):
        u[k] = x[at[2] + k] * p.motion
        if k >= lengths:
            u[k] /= p.length
    return f, u


def candidate_of(scene: Scene, solution: Any) -> Candidate:
    """The candidate that certifies to this `GraspSolution`."""
    forces = solution.forces.reshape(-1)
    if scene.soft:
        torsion = np.zeros(scene.n) if solution.torsion is None else solution.torsion
        forces = np.append(forces, torsion[list(scene.soft)])
    twist = shifted(solution.object_displacement, scene.units.centre - solution.reference)
    return Candidate(scene.lawful(forces), twist, solution.extra, len(scene.soft))
