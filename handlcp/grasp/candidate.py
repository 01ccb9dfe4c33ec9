"""A solver's answer as mechanics."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array, Ints, nothing
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import Scene, shifted
from handlcp.grasp.system import System
from handlcp.lcp.kernels.compile import kernel

if TYPE_CHECKING:
    from handlcp.grasp.solution import GraspSolution

__all__ = ["Candidate", "decode", "encode", "of_solution"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A solver's answer as mechanics, SI, in the coordinates of the scene's friction laws: forces (n, 3), twist (6,)
    about the contacts' centre, the unknowns of further effects by group name, and torsion (k,), the moments of soft
    contacts over their levers [N].
    """

    forces: Array
    twist: Array
    extra: dict[str, Array]
    torsion: Array = field(default_factory=nothing)

    @property
    def components(self) -> Array:
        """(c,) all force components, as the scene's flexibility and grasp matrix count them."""
        return np.concatenate([self.forces.ravel(), self.torsion]) if len(self.torsion) else self.forces.ravel()


def decode(scene: Scene, system: System, effects: tuple[Effect, ...], x: Array) -> Candidate:
    """Forces, motion and further unknowns from x (N,), all unknowns of the system in natural units."""
    at = system.at
    normal, tangential = at.get("r_N", _NONE), system.tangential
    units, u, n, k = scene.units, at["u"].start, scene.n, len(scene.soft)
    forces, twist = in_si(
        x, scene.normal_index, normal.start, scene.tangent_index, tangential, n + k, u, scene.dof,
        units.force, units.motion, units.length,
    )  # fmt: skip
    torsion = nothing()
    if k:
        forces, torsion = forces[:n], forces[n:].ravel()[:k]
    if scene.freedom is not None:
        twist = twist @ scene.freedom
    extra = {g.name: x[at[g.name]] * g.sizes(scene)[0] for g in system.layout.extra}
    for e in effects:
        if isinstance(e, PrescribedForce):
            forces[e.contact] = scene.lawful_at(e.contact, e.force)
    return Candidate(forces, twist, extra, torsion)


def of_solution(scene: Scene, solution: GraspSolution) -> Candidate:
    """What a solver would have to propose, for the certifier to make this solution of it."""
    assert solution.reference is not None  # an answer has one
    twist = shifted(solution.object_displacement, scene.units.centre - solution.reference)
    torsion = np.zeros(len(scene.soft))
    if solution.torsion is not None:
        torsion = solution.torsion[list(scene.soft)] / scene.levers
    return Candidate(scene.lawful(solution.forces), twist, solution.extra, torsion)


def encode(scene: Scene, system: System, candidate: Candidate) -> Array:
    """(N,) natural units, from forces, motion and unknowns of further effects, as far as given; zero for the others."""
    x, at = np.zeros(len(system.q)), system.at
    forces = candidate.components / scene.units.force
    if len(forces) < scene.components:  # a start knows no moments
        forces = np.append(forces, np.zeros(scene.components - len(forces)))
    twist = candidate.twist if scene.freedom is None else scene.freedom @ candidate.twist
    if "r_N" in at:
        x[at["r_N"]] = forces[scene.normal_index]
    tangential = forces[scene.tangent_index]
    x[system.tangential : system.tangential + len(tangential)] = tangential
    x[at["u"]] = twist / scene.twist_units
    for g in system.layout.extra:
        if g.name in candidate.extra:
            x[at[g.name]] = candidate.extra[g.name] / g.sizes(scene)[0]
    return x


_NONE = slice(0, 0)


@kernel
def in_si(
    x: Array, normal: Ints, at_normal: int, tangent: Ints, at_tangent: int, n: int, at_motion: int, dof: int,
    force: float, motion: float, length: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Forces (n, 3) [N] in contact axes and (dof,) motion [m, rad] from the unknowns x; normal, tangent: which entries
    of the 3n force components they are.
    """
    f, u = np.zeros((n, 3)), np.empty(dof)
    for k in range(len(normal)):
        f[normal[k] // 3, normal[k] % 3] = x[at_normal + k] * force
    for k in range(len(tangent)):
        f[tangent[k] // 3, tangent[k] % 3] = x[at_tangent + k] * force
    lengths = 3 if dof == 6 else 2
    for k in range(dof):
        u[k] = x[at_motion + k] * motion
        if k >= lengths:
            u[k] /= length
    return f, u
