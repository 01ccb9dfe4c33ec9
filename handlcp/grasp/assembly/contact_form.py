"""From a scene and its effects to one contact problem, friction as a set, and from its answer back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.assembly.candidate import Candidate, in_si
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.friction import Interval, Pyramid, Section, limit_set
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import Layout, System, Unknown, labels, layout
from handlcp.lcp import ContactProblem, FrictionSets, Pattern, Units
from handlcp.lcp.contact import NO_NORMALS


def called_for(scene: Scene, section: Section) -> tuple[Effect, ...]:
    """The effects that the scene's data call for, in the order in which they are stamped."""
    return tuple([e for kind in effect_kinds() if (e := kind.called_for(scene, section)) is not None])


def stamped(asked: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those of the effects asked for that have rows or a law of their own: the others are part of the scene's data."""
    return tuple([e for e in asked if e.stamps])


class GraspContactProblem(ContactProblem):
    """The assembled problem with friction as a set: a `ContactProblem` that knows what its unknowns mean.

    scene, section : what was assembled. effects : what was stamped; asked : those of them asked for by name.
    system : the unknowns, and M and q as they were stamped.
    """

    def __init__(self, scene: Scene, section: Section, asked: tuple[Effect, ...]) -> None:
        known = design(scene, section, asked)
        system = System(known.layout)
        for e in known.effects:
            e.stamp(scene, system)
        super().__init__(
            system.M, system.q, known.pattern, friction_sets(scene, section), lambda: Units(*system.sizes(scene)),
            lambda faces: friction_sets(scene, Interval() if scene.kind.planar else Pyramid(faces)),
        )  # fmt: skip
        self.scene, self.section, self.asked, self.effects, self.system = scene, section, asked, known.effects, system

    @property
    def groups(self) -> tuple[Unknown, ...]:
        """The unknowns of all effects."""
        return self.system.layout.groups

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown, such as "r_T[2]"."""
        return labels(self.groups)

    @property
    def limited(self) -> Ints:
        """(m,) which unknowns are motions of limits that give way, those of effects asked for."""
        at, extra = self.system.at, self.system.layout.extra
        own = [np.arange(at[g.name].start, at[g.name].stop) for g in extra if not g.free]
        return np.concatenate([np.zeros(0, np.int64), *own])

    def candidate(self, x: Array) -> Candidate:
        """Forces and motion from x (n,) in natural units."""
        scene, at = self.scene, self.system.at
        normal, count, tangential = self.system.layout.forces
        begin, given = (normal, tangential, at["u"].start), scene.given.prescribed
        forces, free = in_si(x, scene.kind.index, count, begin, given, scene.geometry, scene.dof)
        extra = {g.name: x[at[g.name]] * g.sizes(scene)[0] for g in self.system.layout.extra}
        return Candidate(forces, free @ scene.freedom, extra, len(scene.soft))

    def natural(self, candidate: Candidate) -> Array:
        """(n,) x with these forces, motion and, as far as given, unknowns of further effects: the way back."""
        scene, x, at = self.scene, np.zeros(self.n), self.system.at
        normal, count, tangential = self.system.layout.forces
        forces = candidate.components[scene.kind.index] / scene.units.force
        x[normal : normal + count] = forces[:count]
        x[tangential : tangential + len(forces) - count] = forces[count:]
        x[at["u"]] = scene.natural_twist(candidate.twist)
        for g in self.system.layout.extra:
            known = candidate.extra.get(g.name)
            if known is not None and len(known) == g.count:  # a scene without other effects may have fewer
                x[at[g.name]] = known / g.sizes(scene)[0]
        return x


@dataclass(frozen=True, slots=True)
class Design:
    """What the kind of a scene decides, whatever its numbers: effects, layout, and the roles of the unknowns."""

    effects: tuple[Effect, ...]
    layout: Layout
    pattern: Pattern


# A hand in many postures, or a sweep, meets the same few kinds again and again
_DESIGNS: dict[tuple[object, ...], Design] = {}
_MOST_DESIGNS = 1024


def design(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> Design:
    """The design of this scene, with friction as a set; asked : effects asked for that have rows of their own."""
    groups = tuple([u for e in asked for u in e.unknowns(scene)]) if asked else ()
    key = (section, scene.kind, scene.anisotropic > 0, groups)
    if (known := _DESIGNS.get(key)) is None:
        known = _design(scene, section, groups)
        if not any(g.levers for g in groups):  # levers differ from posture to posture
            if len(_DESIGNS) >= _MOST_DESIGNS:
                _DESIGNS.clear()
            _DESIGNS[key] = known
    return Design((*known.effects, *asked), known.layout, known.pattern) if asked else known


def _design(scene: Scene, section: Section, groups: tuple[Unknown, ...]) -> Design:
    """With further effects' groups, but only the effects that the scene's data call for."""
    effects = called_for(scene, section)
    where, kind = layout((*(u for e in effects for u in e.unknowns(scene)), *groups)), scene.kind
    contacts = (*kind.rough, *kind.soft)
    blocks = np.full((len(contacts), 4), -1, dtype=np.int64)
    if contacts:
        blocks[:, 0] = where.forces[0] - 1 + np.cumsum(kind.governed)[list(contacts)]
        at = where.forces[2]
        for block, i in zip(blocks, contacts, strict=True):
            t = kind.tangents[i]
            block[1 : 1 + t] = np.arange(at, at + t)
            at += t
    return Design(effects, where, Pattern.of(np.arange(where.size) >= where.at["u"].start, blocks))


def friction_sets(scene: Scene, section: Section) -> FrictionSets:
    """Of the contacts with friction, in the order of the blocks."""
    limits = scene.limits(section)[[*scene.rough, *scene.soft]]
    return FrictionSets(read_only(limits), section.faces, outward(scene, section))


def outward(scene: Scene, section: Section) -> Array:
    """(f, 3) outward normals of the polyhedra of soft contacts, as kernels read them; none where no set has faces."""
    if not scene.soft or not section.faces:
        return NO_NORMALS
    return read_only(np.ascontiguousarray(limit_set(section, 3).normals.T))
