"""From a scene and its effects to one complementarity problem, and from its answer back to forces and motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.lcp.kernels.schur import schur
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units
from handlcp.tolerances import ELIMINATE_RCOND

__all__ = ["Candidate", "GraspProblem", "assemble"]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A solver's answer as mechanics, SI: forces (n, 3) in contact axes, twist (6,) about the contacts' centre, and
    the unknowns of further effects by group name.
    """

    forces: Array
    twist: Array
    extra: dict[str, Array]


class GraspProblem(LCP):
    """The assembled problem: an `LCP` that knows what its unknowns mean.

    groups : the unknowns of all effects, complementary groups first.
    eliminated : whether the free unknowns (tangential forces and object motion) were eliminated; M and q are then
        the Schur complement, a standard LCP (paper, equation (17)), otherwise the mixed problem itself.
    rcond : estimate of the reciprocal condition of the free block, which decided that.
    effects : what was stamped.
    """

    groups: tuple[Unknown, ...]
    eliminated: bool
    rcond: float
    effects: tuple[Effect, ...]
    _system: System
    _scene: Scene
    _back: tuple[Array, Array] | None

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown of this problem, such as "r_N[2]"."""
        shown = [g for g in self.groups if not (self.eliminated and g.free)]
        return tuple(f"{g.name}[{k}]" for g in shown for k in range(g.count))

    def candidate(self, z: Array) -> Candidate:
        """Forces and motion from z (n,) in natural units."""
        x = z
        if self._back is not None:
            X, x0 = self._back
            x = np.concatenate([z, x0 - X @ z])
        return _decode(self._scene, self._system, self.effects, x)


def assemble(scene: Scene, effects: tuple[Effect, ...]) -> GraspProblem:
    """Stamp the effects, then eliminate the free unknowns where their block is well conditioned."""
    system = System(u for e in effects for u in e.unknowns(scene))
    for e in effects:
        e.stamp(scene, system)
    c, n = system.free_from, len(system.q)
    x_units, w_units = system.sizes(scene)
    M, q, X, x0, rcond = schur(system.M, system.q, c)
    if rcond > ELIMINATE_RCOND:
        return _problem(
            M, q, np.zeros(c, bool), Units(x_units[:c], w_units[:c]), scene, system, effects, (X, x0), rcond
        )
    mixed = np.arange(n) >= c
    return _problem(system.M, system.q, mixed, Units(x_units, w_units), scene, system, effects, None, rcond)


def _problem(
    M: Array,
    q: Array,
    free: Bools,
    units: Units,
    scene: Scene,
    system: System,
    effects: tuple[Effect, ...],
    back: tuple[Array, Array] | None,
    rcond: float,
) -> GraspProblem:
    p = GraspProblem.from_scaled(read_only(M), read_only(q), free, units)
    assert isinstance(p, GraspProblem)
    p.groups, p.effects, p.eliminated, p.rcond = system.groups, effects, back is not None, rcond
    p._system, p._scene, p._back = system, scene, back
    return p


def _decode(scene: Scene, system: System, effects: tuple[Effect, ...], x: Array) -> Candidate:
    f = np.zeros(3 * scene.n)
    at, force = system.at, scene.units.force
    if "r_N" in at:
        f[scene.normal_index] = x[at["r_N"]] * force
    if "r_T" in at:
        f[scene.tangent_index] = x[at["r_T"]] * force
    extra = {
        g.name: x[at[g.name]] * scene.size(g.measure) for g in system.groups if g.name not in ("r_N", "r_T", "λ", "u")
    }
    for e in effects:
        if isinstance(e, PrescribedForce):
            f[3 * e.contact : 3 * e.contact + 3] = e.force
    return Candidate(f.reshape(-1, 3), scene.twist(x[at["u"]]), extra)
