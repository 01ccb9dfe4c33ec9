"""`GraspContactProblem`: a grasp as a contact problem that solvers take; and a solver's answer as mechanics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Cone, Interval, Pyramid, Section, limit_set
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.model.contact import shift_twist
from handlcp.grasp.model.equation_system import EquationSystem, Layout, Unknown, make_layout, unknown_labels
from handlcp.grasp.model.scene import GraspGeometry, Scene
from handlcp.lazy_property import lazy_property
from handlcp.lcp import ContactProblem, FrictionSets, Pattern, Units
from handlcp.lcp.contact_problem import NO_NORMALS, MultiplierLCP
from handlcp.lcp.kernels.dense import kernel


class SolverCandidate(NamedTuple):
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
def unknowns_in_si(
    x: Array, unknown: Ints, normals: int, at: tuple[int, int, int], prescribed: Array, p: GraspGeometry, dof: int
) -> tuple[Array, Array]:
    """Forces (c,) [N] and (dof,) motion [m, rad] from the unknowns x. unknown : which components, so many normal ones
    first; at : where normal forces, tangential forces and the motion begin among the unknowns.
    """
    f, u = prescribed.copy(), np.empty(dof)
    for k in range(len(unknown)):
        f[unknown[k]] = x[at[0] + k if k < normals else at[1] + k - normals] * p.force_unit
    lengths = 3 if dof == 6 else 2
    for k in range(dof):
        u[k] = x[at[2] + k] * p.motion_unit
        if k >= lengths:
            u[k] /= p.length_unit
    return f, u


def solution_candidate(scene: Scene, solution: Any) -> SolverCandidate:
    """The candidate that certifies to this `GraspSolution`."""
    forces = solution.forces.reshape(-1)
    if scene.soft:
        torsion = np.zeros(scene.n) if solution.torsion is None else solution.torsion
        forces = np.append(forces, torsion[list(scene.soft)])
    twist = shift_twist(solution.object_displacement, scene.units.centre - solution.reference)
    return SolverCandidate(scene.forces_to_law_axes(forces), twist, solution.extra, len(scene.soft))


# ----------------------------------------------------------------
# From a scene and its effects to one contact problem, friction as a set, and from its answer back.


def effects_called_for(scene: Scene, section: Section) -> tuple[Effect, ...]:
    """The effects that the scene's data call for, in the order in which they are stamped."""
    return tuple([e for kind in effect_kinds() if (e := kind.called_for(scene, section)) is not None])


def asked_effects_with_rows(asked: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those of the effects asked for that have rows or a law of their own: the others are part of the scene's data."""
    return tuple([e for e in asked if e.stamps])


class GraspContactProblem(ContactProblem):
    """The assembled problem with friction as a set: a `ContactProblem` that knows what its unknowns mean.

    scene, section : what was assembled. effects : what was stamped.
    requested_effects : those of them asked for by name. system : the unknowns, and M and q as they were stamped.
    """

    def __init__(self, scene: Scene, section: Section, asked: tuple[Effect, ...]) -> None:
        known = problem_design(scene, section, asked)
        system = EquationSystem(known.layout)
        for e in known.effects:
            e.stamp(scene, system)
        super().__init__(
            system.M,
            system.q,
            known.pattern,
            friction_sets(scene, section),
            lambda: Units(*system.sizes(scene)),
            lambda faces: friction_sets(scene, Interval() if scene.kind.planar else Pyramid(faces)),
        )
        self.scene, self.section, self.requested_effects, self.effects, self.system = (
            scene,
            section,
            asked,
            known.effects,
            system,
        )

    @property
    def groups(self) -> tuple[Unknown, ...]:
        """The unknowns of all effects."""
        return self.system.layout.groups

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown, such as "r_T[2]"."""
        return unknown_labels(self.groups)

    @property
    def limit_unknowns(self) -> Ints:
        """(m,) which unknowns are motions of limits that give way, those of effects asked for."""
        at, extra = self.system.at, self.system.layout.extra
        own = [np.arange(at[g.name].start, at[g.name].stop) for g in extra if not g.free]
        return np.concatenate([np.zeros(0, np.int64), *own])

    def candidate(self, x: Array) -> SolverCandidate:
        """Forces and motion from x (n,) in natural units."""
        scene, at = self.scene, self.system.at
        normal, count, tangential = self.system.layout.forces
        begin, given = (normal, tangential, at["u"].start), scene.arrays.prescribed
        forces, free = unknowns_in_si(x, scene.kind.index, count, begin, given, scene.geometry, scene.dof)
        extra = {g.name: x[at[g.name]] * g.sizes(scene)[0] for g in self.system.layout.extra}
        return SolverCandidate(forces, free @ scene.freedom, extra, len(scene.soft))

    def natural(self, candidate: SolverCandidate) -> Array:
        """(n,) x with these forces, motion and, as far as given, unknowns of further effects: the way back."""
        scene, x, at = self.scene, np.zeros(self.n), self.system.at
        normal, count, tangential = self.system.layout.forces
        forces = candidate.components[scene.kind.index] / scene.units.force_unit
        x[normal : normal + count] = forces[:count]
        x[tangential : tangential + len(forces) - count] = forces[count:]
        x[at["u"]] = scene.natural_twist(candidate.twist)
        for g in self.system.layout.extra:
            known = candidate.extra.get(g.name)
            if known is not None and len(known) == g.count:  # a scene without other effects may have fewer
                x[at[g.name]] = known / g.sizes(scene)[0]
        return x


@dataclass(frozen=True, slots=True)
class ProblemDesign:
    """What the kind of a scene decides, whatever its numbers: effects, layout, and the roles of the unknowns."""

    effects: tuple[Effect, ...]
    layout: Layout
    pattern: Pattern


# A hand in many postures, or a sweep, meets the same few kinds again and again
_DESIGNS: dict[tuple[object, ...], ProblemDesign] = {}
_MAX_DESIGNS = 1024


def problem_design(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> ProblemDesign:
    """The design of this scene, with friction as a set; asked : effects asked for that have rows of their own."""
    groups = tuple([u for e in asked for u in e.unknowns(scene)]) if asked else ()
    key = (section, scene.kind, scene.anisotropic > 0, groups)
    if (known := _DESIGNS.get(key)) is None:
        known = _make_design(scene, section, groups)
        if not any(g.levers for g in groups):  # levers differ from posture to posture
            if len(_DESIGNS) >= _MAX_DESIGNS:
                _DESIGNS.clear()
            _DESIGNS[key] = known
    return ProblemDesign((*known.effects, *asked), known.layout, known.pattern) if asked else known


def _make_design(scene: Scene, section: Section, groups: tuple[Unknown, ...]) -> ProblemDesign:
    """With further effects' groups, but only the effects that the scene's data call for."""
    effects = effects_called_for(scene, section)
    where, kind = make_layout((*(u for e in effects for u in e.unknowns(scene)), *groups)), scene.kind
    contacts = (*kind.rough, *kind.soft)
    blocks = np.full((len(contacts), 4), -1, dtype=np.int64)
    if contacts:
        blocks[:, 0] = where.forces[0] - 1 + np.cumsum(kind.force_unknown)[list(contacts)]
        at = where.forces[2]
        for block, i in zip(blocks, contacts, strict=True):
            t = kind.tangent_count[i]
            block[1 : 1 + t] = np.arange(at, at + t)
            at += t
    return ProblemDesign(effects, where, Pattern.from_blocks(np.arange(where.size) >= where.at["u"].start, blocks))


def friction_sets(scene: Scene, section: Section) -> FrictionSets:
    """Of the contacts with friction, in the order of the blocks."""
    limits = scene.friction_coefficients(section)[[*scene.rough, *scene.soft]]
    return FrictionSets(read_only(limits), section.faces, polyhedron_normals(scene, section))


def polyhedron_normals(scene: Scene, section: Section) -> Array:
    """(f, 3) outward normals of the polyhedra of soft contacts, as kernels read them; none where no set has faces."""
    if not scene.soft or not section.faces:
        return NO_NORMALS
    return read_only(np.ascontiguousarray(limit_set(section, 3).normals.T))


# ----------------------------------------------------------------
# The problem that a grasp assembles: friction as a set, or as an LCP with a multiplier a face.


MULTIPLIER_NAMES = {"r_T": "λ", "r_S": "λ_S"}  # by the tangential forces that they belong to


class GraspProblem(MultiplierLCP):
    """The assembled problem as an `LCP` that knows what its unknowns mean.

    eliminated : whether the free unknowns (tangential forces and object motion) were eliminated; M and q are then
        the Schur complement, a standard LCP (paper, equation (17)), otherwise the mixed problem itself.
    rcond : estimate of the reciprocal condition of the free block, which decided that.
    contact : the same scene and section with friction as a set: smaller, and what the default chain works on.
    effects : what was stamped. scene, section : what was assembled.
    """

    contact: GraspContactProblem

    def __init__(self, contact: GraspContactProblem) -> None:
        super().__init__(contact, behind=sum(contact.system.layout.forces[:2]))
        self.scene, self.section, self.effects = contact.scene, contact.section, contact.effects

    @lazy_property
    def groups(self) -> tuple[Unknown, ...]:
        """The unknowns of all effects, complementary groups first."""
        own, points = self.contact.groups, len(self.scene.rough)
        counts = {"r_T": sum(self.faces[:points]), "r_S": sum(self.faces[points:])}
        made = [Unknown(MULTIPLIER_NAMES[g.name], counts[g.name], False, "motion") for g in own if g.name in counts]
        behind = 1 if own[0].name == "r_N" else 0
        return (*own[:behind], *made, *own[behind:])

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown of this problem, such as "r_N[2]"."""
        return unknown_labels(tuple(g for g in self.groups if not (self.eliminated and g.free)))

    def candidate(self, z: Array) -> SolverCandidate:
        """Forces and motion from z (n,) in natural units."""
        return self.contact.candidate(self.back(z))

    def natural(self, candidate: SolverCandidate) -> Array:
        """(n,) z with these forces, motion and unknowns of further effects, the way back from `candidate`."""
        return self.lift(self.contact.natural(candidate))

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.M  # noqa: B018
        self.contact.complete()


AnyProblem = GraspProblem | GraspContactProblem


def assemble(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> AnyProblem:
    """The problem as `Grasp.problem` gives it: a multiplier a face, or friction as a set on the exact cone.

    asked : effects asked for that have rows of their own.
    """
    contact = GraspContactProblem(scene, section, asked)
    return contact if isinstance(section, Cone) else GraspProblem(contact)
