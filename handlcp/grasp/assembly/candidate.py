"""A solver's answer as mechanics, and the way back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.grasp_matrix import Posed
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Candidate", "decode", "encode", "in_si"]


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
        """(n, 3) N."""
        return self.components[: len(self.components) - self.soft].reshape(-1, 3)


def decode(scene: Scene, system: System, x: Array) -> Candidate:
    """Forces, motion and further unknowns from x (N,), all unknowns of the system in natural units."""
    normal, count, tangential = system.layout.forces
    at, given = (normal, tangential, system.at["u"].start), scene.given.prescribed
    forces, free = in_si(x, scene.kind.index, count, at, given, scene.geometry, scene.dof)
    extra = {g.name: x[system.at[g.name]] * g.sizes(scene)[0] for g in system.layout.extra}
    return Candidate(forces, free @ scene.freedom, extra, len(scene.soft))


def encode(scene: Scene, system: System, candidate: Candidate) -> Array:
    """(N,) natural units, from forces, motion and unknowns of further effects, as far as given; zero for the others."""
    x, at = np.zeros(len(system.q)), system.at
    normal, count, tangential = system.layout.forces
    forces = candidate.components[scene.kind.index] / scene.units.force
    x[normal : normal + count] = forces[:count]
    x[tangential : tangential + len(forces) - count] = forces[count:]
    x[at["u"]] = scene.natural_twist(candidate.twist)
    for g in system.layout.extra:
        known = candidate.extra.get(g.name)
        if known is not None and len(known) == g.count:  # a scene without other effects may have fewer
            x[at[g.name]] = known / g.sizes(scene)[0]
    return x


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
