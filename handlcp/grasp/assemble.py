"""From a scene and its effects to one complementarity problem, and from its answer back to forces and motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.catalogue import called_for
from handlcp.grasp.effects import CoulombPyramid, Effect, PrescribedForce, TotalForceBound
from handlcp.grasp.pyramid import Cone, Interval, Pyramid, Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.schur import schur
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units
from handlcp.tolerances import ELIMINATE_RCOND

__all__ = ["Candidate", "GraspContact", "GraspProblem", "assemble", "assemble_contact"]


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
    def scene(self) -> Scene:
        """What was assembled."""
        return self._scene

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown of this problem, such as "r_N[2]"."""
        shown = [g for g in self.groups if not (self.eliminated and g.free)]
        return tuple(f"{g.name}[{k}]" for g in shown for k in range(g.count))

    def every(self, z: Array) -> Array:
        """(N,) all unknowns, the eliminated ones included, from z (n,), natural units."""
        if self._back is None:
            return z
        X, x0 = self._back
        return np.concatenate([z, x0 - X @ z])

    def candidate(self, z: Array) -> Candidate:
        """Forces and motion from z (n,) in natural units."""
        return _decode(self._scene, self._system, self.effects, self.every(z))

    @cached_property
    def contact(self) -> GraspContact:
        """The same scene and the same section with friction as a set: smaller, and what the default chain works on."""
        section: Section = Interval() if self._scene.plane is not None else Cone()
        friction = [e for e in self.effects if isinstance(e, CoulombPyramid)]
        asked = tuple(e for e in self.effects if isinstance(e, (TotalForceBound, PrescribedForce)))
        return assemble_contact(self._scene, friction[0].pyramid if friction else section, asked)

    def lift(self, x: Array) -> Array:
        """(n,) z of this problem from x of `contact`, natural units: the multipliers follow from the slip.

        -ε_T = Σ λ_j n_j has a solution with at most two λ_j > 0, those of the faces whose normals enclose -ε_T.
        """
        contact, at, here = self.contact, self._system.at, self.contact._system.at
        full = np.zeros(len(self._system.q))
        for name, there in here.items():
            full[at[name]] = x[there]
        if "λ" in at:
            slip = (contact.M[here["r_T"]] @ x + contact.q[here["r_T"]]).reshape(-1, self._scene.tangents)
            full[at["λ"]] = _multipliers(-slip, contact.faces).ravel()
        return full[: self.n]


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


class GraspContact(ContactProblem):
    """The assembled problem with friction as a set: a `ContactProblem` that knows what its unknowns mean.

    groups : the unknowns of all effects. effects : what was stamped.
    """

    groups: tuple[Unknown, ...]
    effects: tuple[Effect, ...]
    _system: System
    _scene: Scene

    @property
    def scene(self) -> Scene:
        """What was assembled."""
        return self._scene

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown, such as "r_T[2]"."""
        return tuple(f"{g.name}[{k}]" for g in self.groups for k in range(g.count))

    def candidate(self, x: Array) -> Candidate:
        """Forces and motion from x (n,) in natural units."""
        return _decode(self._scene, self._system, self.effects, x)


def assemble_contact(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspContact:
    """Stamp the effects with friction as a set; nothing is eliminated, nothing grows with the faces."""
    effects = called_for(scene, section, asked, multipliers=False)
    system = System(u for e in effects for u in e.unknowns(scene))
    for e in effects:
        e.stamp(scene, system)
    n, at, axes = len(system.q), system.at, scene.tangents
    k = len(scene.rough)
    blocks = np.full((k, 3), -1, dtype=np.int64)
    if k:
        blocks[:, 0] = at["r_N"].start + scene.rough_rows
        blocks[:, 1] = at["r_T"].start + axes * np.arange(k)
        if axes == 2:
            blocks[:, 2] = blocks[:, 1] + 1
    limits = section.limit(scene.mu)[list(scene.rough)]
    p = GraspContact(
        system.M, system.q, np.arange(n) >= at["u"].start, blocks, limits, section.faces,
        lambda: Units(*system.sizes(scene)), lambda m: _pyramid(scene, asked, system, m),
    )  # fmt: skip
    p.groups, p.effects, p._system, p._scene = system.groups, effects, system, scene
    return p


def _pyramid(
    scene: Scene, asked: tuple[Effect, ...], contact: System, faces: int
) -> tuple[LCP, Callable[[Array], Array]]:
    """The same scene as a plain LCP with `faces` faces (planar: exact), and how its z becomes an x of `contact`."""
    section = Pyramid(faces) if scene.plane is None else Interval()
    p = assemble(scene, called_for(scene, section, asked, multipliers=True))

    def back(z: Array) -> Array:
        full, x = p.every(z), np.empty(len(contact.q))
        for name, here in contact.at.items():
            x[here] = full[p._system.at[name]]
        return x

    return p, back


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


@kernel
def _multipliers(pull: Array, faces: int) -> Array:
    """(k, m) λ ≥ 0 with Σ λ_j n_j = pull (k, 2), or (k, 1) in a plane, on the two faces whose normals enclose it."""
    out = np.zeros((len(pull), faces))
    step = 2.0 * np.pi / faces
    for k in range(len(pull)):
        if faces == 2:
            out[k, 0], out[k, 1] = max(pull[k, 0], 0.0), max(-pull[k, 0], 0.0)
            continue
        angle = np.arctan2(pull[k, 1], pull[k, 0]) % (2.0 * np.pi)
        first = int(angle / step)
        rest = angle - first * step
        size = np.hypot(pull[k, 0], pull[k, 1]) / np.sin(step)
        out[k, first % faces] = size * max(np.sin(step - rest), 0.0)
        out[k, (first + 1) % faces] += size * max(np.sin(rest), 0.0)
    return out
