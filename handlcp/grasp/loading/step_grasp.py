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
from handlcp.grasp.loading.geometry import Look
from handlcp.grasp.loading.stage import Controls
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.placement import Placement
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import cross_rows

__all__ = ["StepGrasp"]

_NONE = 1e-9  # of the contacts' distances from their centre: less is no preload


@dataclass(frozen=True, eq=False)
class _Turned(Effect):
    """How far soft fingertips are turned at the look, for the rows of their moments. Without a title: in no list."""

    spin: Array

    by_name = False

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        return np.concatenate([np.zeros(3 * at.n), self.spin[list(soft)]])


class StepGrasp:
    """Makes the grasps of steps. spec : what was asked for. first : the contacts before anything is loaded.
    weight (3,) : of the object [N].
    """

    def __init__(self, spec: GraspSpec, first: Look, weight: Array) -> None:
        self.spec, self.weight, self.posture = spec, weight, first.at.q
        self._weighs = next((e for e in spec.effects if isinstance(e, FingerWeight)), None)
        told = (JointOffset, FingerWeight, GeometricStiffness)  # what a step knows of anew
        self._effects = tuple([e for e in spec.effects if not isinstance(e, told)])
        self.soft = tuple([i for i, c in enumerate(spec.contacts) if c.friction.lever > 0.0])
        self._overlap = np.maximum(-first.gap, 0.0)
        self._given = spec.offset.copy()
        self._given[:, 2] -= first.gap

    @property
    def squeezes(self) -> bool:
        """Whether preloads, offsets or overlaps squeeze the object."""
        size = float(abs(self.spec.positions - self.spec.positions.mean(axis=0)).max(initial=0.0))
        return max(float(abs(self._given).max()), float(self._overlap.max())) > _NONE * size

    def base(self, look: Look, slipped: Array, controls: Controls, before: Controls) -> Array:
        """(n, 3) offsets but for what pads and joints do. slipped (n, 3) : since the step began."""
        wedge = self._wedge(controls)
        base = wedge - self._wedge(before)
        base[:, :2] += slipped[:, :2]
        base[:, 2] = look.gap + wedge[:, 2]
        return base

    def made(self, look: Look, slipped: Array, base: Array, controls: Controls) -> GraspSpec:
        """The grasp with the contacts of a look, under these controls."""
        spec, effects = self.spec, self._effects
        offset = base + np.einsum("nji,nj->ni", look.frames, look.at.give)
        if self.soft:
            effects = (*effects, _Turned(slipped[:, 2] + look.at.turn))
        if look.mechanism is not None:
            effects = (*effects, JointOffset(self.posture + controls.command - look.at.q))
            if self._weighs is not None and look.gravity_torque is not None:
                effects = (*effects, FingerWeight(look.gravity_torque, self._weighs.sags))
        contacts = tuple([
            Contact.placed(p, R, c.friction, c.planar, c.name)
            for c, p, R in zip(spec.contacts, look.positions, look.frames, strict=True)
        ])  # fmt: skip
        return GraspSpec(
            contacts, look.positions, look.frames, spec.plane, spec.fingers, look.mechanism,
            self._load(look, controls), look.reference, look.flexibility, read_only(offset), effects,
        )  # fmt: skip

    def _wedge(self, controls: Controls) -> Array:
        """(n, 3) what preloads and offsets put between object and fingertips."""
        given = controls.wedge * self._given
        given[:, 2] += (1.0 - min(controls.wedge, 1.0)) * self._overlap
        return np.asarray(given)

    def _load(self, look: Look, controls: Controls) -> Array:
        """(6,) load and weight about the object's reference."""
        load = controls.load.copy()
        if controls.weight:
            weight = controls.weight * self.weight
            load[:3] += weight
            load[3:] += cross_rows(look.weight_arm, weight)
        return read_only(load)
