"""A solver's answer as mechanics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Candidate", "decode", "encode"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A solver's answer as mechanics, SI: forces (n, 3) in contact axes, twist (6,) about the contacts' centre, and
    the unknowns of further effects by group name.
    """

    forces: Array
    twist: Array
    extra: dict[str, Array]


def decode(scene: Scene, system: System, effects: tuple[Effect, ...], x: Array) -> Candidate:
    """Forces, motion and further unknowns from x (N,), all unknowns of the system in natural units."""
    at = system.at
    normal, tangential = at.get("r_N", _NONE), at.get("r_T", _NONE)
    units, u = scene.units, at["u"].start
    forces, twist = in_si(
        x, scene.normal_index, normal.start, scene.tangent_index, tangential.start, scene.n, u, scene.dof,
        units.force, units.motion, units.length,
    )  # fmt: skip
    if scene.freedom is not None:
        twist = twist @ scene.freedom
    extra = {g.name: x[at[g.name]] * g.sizes(scene)[0] for g in system.layout.extra}
    for e in effects:
        if isinstance(e, PrescribedForce):
            forces[e.contact] = e.force
    return Candidate(forces, twist, extra)


def encode(scene: Scene, system: System, candidate: Candidate) -> Array:
    """(N,) natural units, from forces, motion and unknowns of further effects, as far as given; zero for the others."""
    x, at = np.zeros(len(system.q)), system.at
    forces = candidate.forces.ravel() / scene.units.force
    twist = candidate.twist if scene.freedom is None else scene.freedom @ candidate.twist
    parts = {"r_N": forces[scene.normal_index], "r_T": forces[scene.tangent_index], "u": twist / scene.twist_units}
    for name, part in parts.items():
        if name in at:
            x[at[name]] = part
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
