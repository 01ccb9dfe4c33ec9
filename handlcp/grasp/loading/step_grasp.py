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

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.loading.geometry import Geometry, Look
from handlcp.grasp.loading.numbers import Loads
from handlcp.grasp.loading.stage import Controls
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.placement import Placement
from handlcp.grasp.model.spec import GraspSpec, wrench_about
from handlcp.grasp.model.vectors import cross_rows

__all__ = ["StepGrasp", "about_origin"]

# Of the contacts' distances from their centre: less is no preload; and fingertips no farther from the object than this,
# or no deeper in it, just touch
_NONE, _TOUCHES = 1e-7, 3e-5


@dataclass(frozen=True, eq=False)
class _Turned(Effect):
    """How far soft fingertips are turned at the look, for the rows of their moments. Without a title: in no list."""

    spin: Array

    by_name = False

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        return np.concatenate([np.zeros(3 * at.n), self.spin[list(soft)]])


class StepGrasp:
    """Makes the grasps of steps. spec : what was asked for. first : the contacts before anything is loaded.
    geometry : where contacts are. weight (3,) : of the object [N]. squeezes : whether preloads, offsets or overlaps
    squeeze the object.
    """

    def __init__(self, spec: GraspSpec, geometry: Geometry, first: Look, weight: Array) -> None:
        self.spec, self.geometry, self.weight, self.posture = spec, geometry, weight, geometry.posture
        self._weighs = next((e for e in spec.effects if isinstance(e, FingerWeight)), None)
        told = (JointOffset, FingerWeight, GeometricStiffness)  # what a step knows of anew
        self._effects = tuple([e for e in spec.effects if not isinstance(e, told)])
        self.general, self.sags = bool(self._effects), self._weighs is not None and self._weighs.sags
        self.soft = np.array([i for i, c in enumerate(spec.contacts) if c.friction.lever > 0.0], dtype=np.int64)
        self._levered = bool(first.weight_arm.any())
        size = float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
        # What closing leaves of touching comes with the squeeze: else one finger is first, and pushes the object away
        fingers = np.arange(spec.n) < spec.of_fingers
        self._touching = np.where(fingers & (abs(first.gap) <= _TOUCHES * size), first.gap, 0.0)
        self._overlap = np.maximum(self._touching - first.gap, 0.0)
        self._given = spec.offset - geometry.apart
        self.squeezes = max(float(abs(self._given).max()), float(self._overlap.max())) > _NONE * size
        self._wedges = self.squeezes or bool(self._touching.any())

    def loads(self, look: Look, slipped: Array, controls: Controls, before: Controls) -> Loads:
        """Of a step from controls `before`. slipped (n, 3) : since it began, as `Geometry.slipped` has it."""
        base = slipped.copy()
        base[:, 2] = look.gap
        if self._wedges:
            wedge = self.wedge(controls)
            base[:, :2] += (wedge - self.wedge(before))[:, :2]
            base[:, 2] += wedge[:, 2]
        force, moment = controls.load[:3], controls.load[3:]
        if controls.weight:
            weight = controls.weight * self.weight
            force = force + weight
            if self._levered:
                moment = moment + cross_rows(look.weight_arm, weight)
        if controls.weight or force.any():
            moment = moment + cross_rows(look.reference, force)
        told = self.posture + controls.command - look.at.q
        return Loads(base, slipped[:, 2] + look.at.turn, look.at.give, told, force, moment)

    def more(self, loads: Loads, look: Look, load: Array) -> Loads:
        """The same with another load (6,) besides, about the look's reference."""
        about = about_origin(load, look.reference)
        return loads._replace(force=loads.force + about[:3], moment=loads.moment + about[3:])

    def made(self, look: Look, loads: Loads) -> GraspSpec:
        """The grasp with the contacts of a look, under these loads."""
        spec, effects = self.spec, self._effects
        offset = loads.base + np.einsum("nji,nj->ni", look.frames, loads.give)
        if len(self.soft):
            effects = (*effects, _Turned(loads.spin))
        mechanism = self.geometry.mechanism(look)
        if mechanism is not None:
            effects = (*effects, JointOffset(loads.told))
            if self._weighs is not None:
                effects = (*effects, FingerWeight(look.elastic.gravity, self._weighs.sags))
        contacts = tuple([
            Contact.placed(p, R, c.friction, c.planar, c.name)
            for c, p, R in zip(spec.contacts, look.positions, look.frames, strict=True)
        ])  # fmt: skip
        return GraspSpec(
            contacts, look.positions, look.frames, spec.plane, spec.fingers, mechanism,
            wrench_about(look.reference, loads.force, loads.moment), read_only(look.reference),
            read_only(look.elastic.E), read_only(offset), effects,
        )  # fmt: skip

    def wedge(self, controls: Controls) -> Array:
        """(n, 3) what preloads and offsets put between object and fingertips."""
        given = controls.wedge * self._given
        given[:, 2] += (1.0 - min(controls.wedge, 1.0)) * (self._overlap - self._touching)
        return np.asarray(given)


def about_origin(load: Array, reference: Array) -> Array:
    """(6,) about the world's origin, of a load (6,) about a reference (3,)."""
    return np.concatenate([load[:3], load[3:] + cross_rows(reference, load[:3])])
