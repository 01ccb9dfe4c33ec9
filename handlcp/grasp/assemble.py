"""From a scene and its effects to one complementarity problem, and from its answer back to forces and motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.assembled import Assembled, picked
from handlcp.grasp.candidate import Candidate, decode, encode
from handlcp.grasp.catalogue import asked_for, called_for
from handlcp.grasp.effects import CoulombPyramid, Effect
from handlcp.grasp.pyramid import Cone, Interval, Pyramid, Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import Layout, System, Unknown, layout
from handlcp.lazy import lazy
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.contact import roles
from handlcp.lcp.kernels.schur import schur
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units
from handlcp.tolerances import ELIMINATE_RCOND

__all__ = ["Design", "GraspContact", "GraspProblem", "assemble", "assemble_contact", "design"]


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
        return decode(self._scene, self._system, self.effects, self.every(z))

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.M  # noqa: B018
        if self.contact is not None:
            self.contact.complete()

    @lazy
    def contact(self) -> GraspContact | None:
        """The same scene and the same section with friction as a set: smaller, and what the default chain works on.
        None where contacts are soft: polyhedra in three tangents are no sets that solvers project on.
        """
        if self._scene.soft:
            return None
        section: Section = Interval() if self._scene.plane is not None else Cone()
        friction = [e for e in self.effects if isinstance(e, CoulombPyramid)]
        asked = asked_for(self.effects)
        return assemble_contact(self._scene, friction[0].pyramid if friction else section, asked)

    def natural(self, candidate: Candidate) -> Array:
        """(n,) z with these forces, motion and unknowns of further effects, the way back from `candidate`."""
        if self.contact is None:
            return encode(self._scene, self._system, candidate)[: self.n]
        return self.lift(self.contact.natural(candidate))

    def lift(self, x: Array) -> Array:
        """(n,) z of this problem from x of `contact`, natural units: the multipliers follow from the slip.

        -ε_T = Σ λ_j n_j has a solution with at most two λ_j > 0, those of the faces whose normals enclose -ε_T.
        """
        contact, at = self.contact, self._system.at
        assert contact is not None  # who has an x has it from there
        here = contact._system.at
        full = np.zeros(len(self._system.q))
        for name, there in here.items():
            full[at[name]] = x[there]
        if "λ" in at:
            tangential = here["r_T"]
            raise_multipliers(
                contact.M, contact.q, x, tangential.start, tangential.stop, self._scene.tangents, contact.faces,
                full[at["λ"]],
            )  # fmt: skip
        return full[: self.n]


def assemble(scene: Scene, effects: tuple[Effect, ...]) -> GraspProblem:
    """Stamp the effects, then eliminate the free unknowns where their block is well conditioned."""
    system = System(layout(u for e in effects for u in e.unknowns(scene)))
    for e in effects:
        e.stamp(scene, system)
    c, n = system.layout.free_from, len(system.q)
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
    p.groups, p.effects, p.eliminated, p.rcond = system.layout.groups, effects, back is not None, rcond
    p._system, p._scene, p._back = system, scene, back
    return p


class GraspContact(Assembled, ContactProblem):
    """The assembled problem with friction as a set: a `ContactProblem` that knows what its unknowns mean."""

    @property
    def limited(self) -> Ints:
        """(m,) which unknowns are motions of limits that give way, those of effects asked for."""
        at, extra = self._system.at, self._system.layout.extra
        return np.concatenate([_NO_INTS, *(np.arange(at[g.name].start, at[g.name].stop) for g in extra if not g.free)])


_NO_INTS = np.zeros(0, np.int64)


@dataclass(frozen=True, slots=True)
class Design:
    """What the pattern of a scene decides, whatever its numbers: effects, layout, and what `ContactProblem` says of
    roles.
    """

    effects: tuple[Effect, ...]
    layout: Layout
    free: Bools
    role: Ints
    blocks: Ints
    rough: Ints


# A hand in many postures, or a sweep, meets the same few patterns again and again
_DESIGNS: dict[tuple[object, ...], Design] = {}
_MOST_DESIGNS = 1024


def design(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> Design:
    """The design of this scene, with friction as a set."""
    groups = tuple([u for e in asked for u in e.unknowns(scene)]) if asked else ()
    key = (section, scene.governed, scene.rough, scene.plane is None, scene.flexible, scene.anisotropic > 0, groups)
    if (known := _DESIGNS.get(key)) is None:
        known = _design(scene, section, groups)
        if not any(g.levers for g in groups):  # levers differ from posture to posture
            if len(_DESIGNS) >= _MOST_DESIGNS:
                _DESIGNS.clear()
            _DESIGNS[key] = known
    if not asked:
        return known
    return Design((*known.effects, *asked), known.layout, known.free, known.role, known.blocks, known.rough)


def _design(scene: Scene, section: Section, groups: tuple[Unknown, ...]) -> Design:
    """With further effects' groups, but only the effects that the scene's data call for."""
    effects = called_for(scene, section, (), multipliers=False)
    where = layout((*(u for e in effects for u in e.unknowns(scene)), *groups))
    at, axes, k = where.at, scene.tangents, len(scene.rough)
    blocks = np.full((k, 3), -1, dtype=np.int64)
    if k:
        blocks[:, 0] = at["r_N"].start + scene.rough_rows
        blocks[:, 1] = at["r_T"].start + axes * np.arange(k)
        if axes == 2:
            blocks[:, 2] = blocks[:, 1] + 1
    free = np.arange(where.size) >= at["u"].start
    return Design(effects, where, free, roles(free, blocks), blocks, np.array(scene.rough, dtype=np.int64))


def assemble_contact(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspContact:
    """Stamp the effects with friction as a set; nothing is eliminated, nothing grows with the faces."""
    known = design(scene, section, asked)
    system = System(known.layout)
    for e in known.effects:
        e.stamp(scene, system)
    p = GraspContact(
        system.M, system.q, known.free, known.blocks, section.limit(scene.mu)[known.rough], section.faces,
        lambda: Units(*system.sizes(scene)), lambda m: _pyramid(scene, asked, system, m), known.role,
    )  # fmt: skip
    return p.of(scene, system, known.effects)


def _pyramid(
    scene: Scene, asked: tuple[Effect, ...], contact: System, faces: int
) -> tuple[LCP, Callable[[Array], Array]]:
    """The same scene as a plain LCP with `faces` faces (planar: exact), and how its z becomes an x of `contact`."""
    section = Pyramid(faces) if scene.plane is None else Interval()
    p = assemble(scene, called_for(scene, section, asked, multipliers=True))
    return p, picked(p.every, p._system, contact)


@kernel
def raise_multipliers(
    M: Array, q: Array, x: Array, start: int, stop: int, axes: int, faces: int, multipliers: Array
) -> None:
    """Write λ ≥ 0 (k faces,) with Σ λ_j n_j = -ε_T, the slip in rows start to stop of M x + q, on the two faces whose
    normals enclose it.
    """
    step = 2.0 * np.pi / faces
    for k in range((stop - start) // axes):
        i = start + axes * k
        a, b = -q[i], 0.0
        for j in range(len(x)):
            a -= M[i, j] * x[j]
        if faces == 2:
            multipliers[2 * k], multipliers[2 * k + 1] = max(a, 0.0), max(-a, 0.0)
            continue
        b = -q[i + 1]
        for j in range(len(x)):
            b -= M[i + 1, j] * x[j]
        angle = np.arctan2(b, a) % (2.0 * np.pi)
        first = int(angle / step)
        rest = angle - first * step
        size = np.hypot(a, b) / np.sin(step)
        multipliers[faces * k + first % faces] = size * max(np.sin(step - rest), 0.0)
        multipliers[faces * k + (first + 1) % faces] += size * max(np.sin(rest), 0.0)
