"""From a scene and its effects to one complementarity problem, and from its answer back to forces and motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.lcp.problem import LCP, Mask
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
    rcond : LAPACK's estimate of the reciprocal condition of the free block, which decided that.
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
    c, N = system.free_from, len(system.q)
    sizes_x, sizes_w = system.sizes()
    factors, rcond = _factorise(system.M[c:, c:])
    back = None
    if factors is not None:
        # x_F = x0 - X z with X = F⁻¹ M_FC, x0 = -F⁻¹ q_F; Schur complement M_CC - M_CF X
        solved, _ = lapack.dgetrs(*factors, np.hstack([system.M[c:, :c], system.q[c:, None]]))
        X, x0 = solved[:, :-1], -solved[:, -1]
        M = system.M[:c, :c] - system.M[:c, c:] @ X
        q = system.q[:c] + system.M[:c, c:] @ x0
        back, free = (X, x0), np.zeros(c, bool)
        sizes_x, sizes_w = sizes_x[:c], sizes_w[:c]
    else:
        M, q, free = system.M, system.q, np.arange(N) >= c
    return _problem(M, q, free, Units(sizes_x, sizes_w), scene, system, effects, back, rcond)


def _problem(
    M: Array,
    q: Array,
    free: Mask,
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


def _factorise(F: Array) -> tuple[tuple[Array, Array] | None, float]:
    """((LU, pivots), reciprocal condition) of the free block; no factors where it is too ill-conditioned."""
    if not len(F):
        return None, 1.0
    norm = float(abs(F).sum(axis=0).max())
    lu, pivots, info = lapack.dgetrf(F)
    if info != 0 or norm == 0.0:
        return None, 0.0
    rcond, _ = lapack.dgecon(lu, norm)
    return ((lu, pivots) if rcond > ELIMINATE_RCOND else None), float(rcond)


def _decode(scene: Scene, system: System, effects: tuple[Effect, ...], x: Array) -> Candidate:
    f = np.zeros(3 * scene.n)
    at, force = system.at, scene.units.force
    if "r_N" in at:
        f[scene.normal_index] = x[at["r_N"]] * force
    if "r_T" in at:
        f[scene.tangent_index] = x[at["r_T"]] * force
    extra = {g.name: x[at[g.name]] * g.size for g in system.groups if g.name not in ("r_N", "r_T", "λ", "u")}
    for e in effects:
        if isinstance(e, PrescribedForce):
            f[3 * e.contact : 3 * e.contact + 3] = e.force
    return Candidate(f.reshape(-1, 3), scene.twist(x[at["u"]]), extra)
