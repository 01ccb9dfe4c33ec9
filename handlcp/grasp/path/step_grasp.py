"""The grasp of one step of loading, as a specification like any other.

Its offsets are, contact by contact,

    d̂ = (slip since the step began, gap) + ŝ + preload

along the tangents and the normal, at the configuration where the contacts were looked at. ŝ is how far the pads give
way there: the answer's own E r takes it from ŝ to -P r. Likewise the joint offset q_c - q̂ takes the joints from where
they stand to where they are commanded, and E r back by what they give way. Overlaps of fingertips and object fade in
with the squeeze: before it, nothing is loaded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.errors import Unsupported
from handlcp.grasp.assembly.problem import asked_effects_with_rows, polyhedron_normals, problem_design
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight, TorqueSaturation
from handlcp.grasp.model.contact import Contact, Placement, block_diagonal
from handlcp.grasp.model.request import GraspSpec, wrench_about
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.path.geometry import Geometry, Iterate
from handlcp.grasp.path.newton.answer import Answer
from handlcp.grasp.path.newton.linear_solve import Giving
from handlcp.grasp.path.newton.numbers import Laws, Loads, flexibility_of
from handlcp.grasp.path.solve_step import Preloads, preload_offsets
from handlcp.grasp.path.state import Controls
from handlcp.grasp.solve.compiled_solve import ScenePattern

# ----------------------------------------------------------------
# The laws that all steps of a grasp share, as compiled code reads them, and what its effects add to a step.


class StepLaws:
    """Of one grasp and section. laws, friction_coefficients (n,), pattern : as `one_iteration` reads them. given : how
    many limits give way. yields (nv, given) : how far they drive joints back [rad/m], at the first iterate. answer :
    the layout of an answer's row; joints : as in `Answer`. by_contact : whether contacts are eliminated one by one.
    """

    def __init__(
        self, grasp: StepGrasp, section: Section, first: Iterate, joints: tuple[int, int] | None
    ) -> None:  # fmt: skip
        self.grasp, spec = grasp, grasp.spec
        scene = build_scene(spec)
        asked = asked_effects_with_rows(spec.effects)
        if foreign := [e for e in asked if not e.only_limits]:
            names = ", ".join(type(e).__name__ for e in foreign)
            raise Unsupported(f"a path knows no unknowns but forces and limits that give way ({names})")
        soft, contacts, kind = scene.soft, spec.contacts, scene.kind
        scale = np.ones(scene.components) if scene.scale is None else scene.scale.copy()
        self.laws = Laws(
            np.array(soft, dtype=np.int64), scale,
            np.array([contacts[i].friction.pad_torsion for i in soft], dtype=float), scene.freedom.copy(),
            spec.mechanism is not None and bool(spec.flexibility.any()), 1.0 if grasp.sags else 0.0,
        )  # fmt: skip
        self.friction_coefficients = scene.friction_coefficients(section).copy()
        known = problem_design(scene, section, asked)
        where, roles = known.layout, known.pattern
        self._extra = where.extra
        self.given = sum([g.count for g in where.extra])
        self._at = where.at[where.extra[0].name].start if where.extra else 0
        self.pattern = ScenePattern(
            kind.contact_components.copy(), kind.index.copy(), roles.role.copy(), roles.order.copy(),
            roles.blocks.copy(), section.faces, np.array(polyhedron_normals(scene, section)), True, kind.dof,
            (*where.forces, where.at["u"].start, where.size), len(soft),
        )  # fmt: skip
        none = Giving(np.zeros((0, scene.components)), np.zeros(0), 0, np.zeros(0))
        self.nothing_added = np.zeros((0, 0)), none
        nv = len(first.at.q)
        self.yields = np.zeros((nv, 0))
        self.answer = Answer(spec.n, nv, scene.components, self.given, kind.dof, joints)
        self.by_contact = (
            kind.has_many_contacts
            and not grasp.general
            and bool((scale == 1.0).all())
            and _pads_alone(first.elastic.P, spec.n)
        )

    def added(self, iterate: Iterate, loads: Loads, gives: Array) -> tuple[Array, Giving, Loads]:
        """What effects add to an iterate: flexibility (c, c) in contact axes, empty for none; limits that give way;
        loads with their offsets. gives (given,) : from where those begin.
        """
        grasp = self.grasp
        if not grasp.general:
            return *self.nothing_added, loads
        scene = build_scene(grasp.made(iterate, loads))
        scale = self.laws.scale
        E = scene.flexibility / np.outer(scale, scale)
        plain = build_scene(grasp.plain(iterate, loads))
        extra = E - plain.flexibility / np.outer(scale, scale)
        moved = (scene.offset - plain.offset) / scale
        n = len(iterate.positions)
        base, spin = loads.base + moved[: 3 * n].reshape(n, 3), loads.spin.copy()
        spin[self.laws.soft] += moved[3 * n :]
        return extra, self._giving(scene, gives), loads._replace(base=base, spin=spin)

    def _giving(self, scene: Scene, gives: Array) -> Giving:
        rows, room, yields = list[Array](), list[Array](), list[Array]()
        for e in asked_effects_with_rows(self.grasp.effects):
            for limit in e.present(scene):
                rows.append(limit.natural_rows)
                room.append(limit.room if limit.levers is None else limit.room / limit.levers)
                back = np.zeros((self.yields.shape[0], len(limit.room)))
                if isinstance(e, TorqueSaturation) and limit.levers is not None:
                    sign = 1.0 if limit.name == "s⁺" else -1.0
                    for c, j in enumerate(e.limited(scene)[2]):
                        back[j, c] = sign / limit.levers[c]
                yields.append(back)
        if not rows:
            return self.nothing_added[1]
        self.yields = np.ascontiguousarray(np.hstack(yields))
        return Giving(np.ascontiguousarray(np.concatenate(rows)), np.concatenate(room), self._at, gives.copy())


def _pads_alone(P: Array, n: int) -> bool:
    """Whether each contact gives way by itself, and to its own force alone. P (3n, 3n)."""
    rows = np.arange(n)
    blocks = P.reshape(n, 3, n, 3)[rows, :, rows]
    if (block_diagonal(blocks, n) != P).any():
        return False
    return bool((np.linalg.eigvalsh(blocks)[:, 0] > _RIGID * blocks.max()).all())


# ----------------------------------------------------------------

# Of the softest pad: what gives way by less is not eliminated by itself
_RIGID = 1e-7
# Of the contacts' distances from their centre: less is no preload; and fingertips no farther from the object than this,
# or no deeper in it, just touch
_NONE, _TOUCHES = 1e-7, 3e-5


@dataclass(frozen=True, eq=False)
class _Turned(Effect):
    """How far soft fingertips are turned at the iterate, for the rows of their moments. It has no title, so that no
    list of effects shows it.
    """

    spin: Array

    by_name = False

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        return np.concatenate([np.zeros(3 * at.n), self.spin[list(soft)]])


class Under(NamedTuple):
    """Of a step: preload (n, 3) that preloads add between object and fingertips, along the tangents since the step
    began; None: nothing. commanded (nv,) : where joints are commanded to. load (6,), weight (3,).
    """

    preload: Array | None
    commanded: Array
    load: Array
    weight: Array


class StepGrasp:
    """Makes the grasps of steps. spec : what was asked for. first : the contacts before anything is loaded.
    geometry : where contacts are. weight (3,) : of the object [N]. preloads : what these put between object and
    fingertips. squeezes : whether preloads, offsets or overlaps squeeze the object. touches : gap or overlap of
    contacts that just touch [m].
    """

    def __init__(self, spec: GraspSpec, geometry: Geometry, first: Iterate, weight: Array) -> None:
        self.spec, self.geometry, self.weight, self.posture = spec, geometry, weight, geometry.posture
        self._weighs = next((e for e in spec.effects if isinstance(e, FingerWeight)), None)
        command = (JointOffset, FingerWeight, GeometricStiffness)  # what each step works out anew
        self._effects = tuple([e for e in spec.effects if not isinstance(e, command)])
        self.general, self.sags = bool(self._effects), self._weighs is not None and self._weighs.sags
        self.soft = np.array([i for i, c in enumerate(spec.contacts) if c.friction.lever > 0.0], dtype=np.int64)
        size = float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
        # Gaps and overlaps that closing left fade in with the squeeze: else the first finger pushes the object away
        fingers = np.arange(spec.n) < spec.of_hand
        self.touches = _TOUCHES * size
        touching = np.where(fingers & (abs(first.gap) <= self.touches), first.gap, 0.0)
        overlap, given = np.maximum(touching - first.gap, 0.0), spec.offset - geometry.apart
        self.squeezes = max(float(abs(given).max()), float(overlap.max())) > _NONE * size
        acts = self.squeezes or bool(touching.any())
        self.preloads = Preloads(given, overlap - touching, acts, self.touches)

    def under(self, controls: Controls, before: Controls) -> Under:
        """What all iterates of a step have in common, from controls `before`."""
        preload = None
        if self.preloads.acts:
            preload = preload_offsets(self.preloads, controls.preload, before.preload)
        return Under(preload, self.posture + controls.command, controls.load, controls.weight * self.weight)

    def loads(self, iterate: Iterate, slipped: Array, under: Under) -> Loads:
        """Of an iterate at a step. slipped (n, 3) : since the step began, as `Geometry.slipped` has it."""
        base = slipped.copy()
        base[:, 2] = iterate.gap
        if under.preload is not None:
            base += under.preload
        return Loads(
            base, slipped[:, 2].copy(), iterate.at.give, iterate.at.turn, under.commanded - iterate.at.q, under.load,
            iterate.reference, under.weight, iterate.reference + iterate.weight_arm,
        )  # fmt: skip

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects that a step does not work out itself."""
        return self._effects

    def made(self, iterate: Iterate, loads: Loads, tension: Array | None = None) -> GraspSpec:
        """The grasp with the contacts of an iterate, under these loads. tension (t,) : of tendons; None: not known."""
        return self._made(iterate, loads, self._effects, tension)

    def plain(self, iterate: Iterate, loads: Loads) -> GraspSpec:
        """The same without the effects that a step does not work out itself."""
        return self._made(iterate, loads, ())

    def _made(
        self, iterate: Iterate, loads: Loads, effects: tuple[Effect, ...], tension: Array | None = None
    ) -> GraspSpec:
        spec = self.spec
        offset = loads.base + np.einsum("nji,nj->ni", iterate.frames, loads.give)
        if spec.mechanism is None and len(loads.command):
            offset -= (iterate.elastic.J @ loads.command).reshape(-1, 3)
        if len(self.soft):
            effects = (*effects, _Turned(loads.spin + loads.turn))
        mechanism = self.geometry.mechanism(iterate)
        if mechanism is not None:
            effects = (*effects, JointOffset(loads.command, tension=tension))
            if self._weighs is not None:
                effects = (*effects, FingerWeight(iterate.elastic.gravity, self._weighs.sags))
        contacts = tuple([
            Contact.from_arrays(read_only(p.copy()), read_only(R.copy()), c.friction, c.planar, c.name)
            for c, p, R in zip(spec.contacts, iterate.positions, iterate.frames, strict=True)
        ])  # fmt: skip
        return GraspSpec(
            contacts, read_only(iterate.positions.copy()), read_only(iterate.frames.copy()), spec.plane, spec.fingers,
            mechanism, wrench_about(iterate.reference, loads.force, loads.moment), read_only(iterate.reference),
            read_only(flexibility_of(iterate.elastic)), read_only(offset), effects,
        )  # fmt: skip

    def preload(self, controls: Controls) -> Array:
        """(n, 3) what preloads and offsets put between object and fingertips."""
        return preload_offsets(self.preloads, controls.preload, 0.0)
