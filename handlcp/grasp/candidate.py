"""A solver's answer as mechanics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Candidate", "decode"]


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
    forces = place_forces(
        x, scene.normal_index, normal.start, scene.tangent_index, tangential.start, scene.n, scene.units.force
    )
    extra = {g.name: x[at[g.name]] * scene.size(g.measure) for g in system.layout.extra}
    for e in effects:
        if isinstance(e, PrescribedForce):
            forces[e.contact] = e.force
    return Candidate(forces, scene.twist(x[at["u"]]), extra)


_NONE = slice(0, 0)


@kernel
def place_forces(x: Array, normal: Ints, at_normal: int, tangent: Ints, at_tangent: int, n: int, unit: float) -> Array:
    """(n, 3) SI forces in contact axes from the unknowns; `normal`, `tangent`: their entries among the 3n."""
    f = np.zeros((n, 3))
    for k in range(len(normal)):
        f[normal[k] // 3, normal[k] % 3] = x[at_normal + k] * unit
    for k in range(len(tangent)):
        f[tangent[k] // 3, tangent[k] % 3] = x[at_tangent + k] * unit
    return f
