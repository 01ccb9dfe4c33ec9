"""The grasp's certifier: every law of the scene recomputed from its physics. Imports no solver; NaN never passes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import outward
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_laws import Friction, Misses, examine
from handlcp.tolerances import CERTIFY, GROWTH


@dataclass(frozen=True, slots=True)
class Residuals:
    """How far an answer misses each law. Relative ones are fractions of `force_scale` or of each contact's own motion.

    balance : |Σ forces + wrench|, moments over the grasp's size. balance_force [N], balance_moment [N·m]: the same, SI.
    normal : worst |min(r_N, gap)|. cone : worst excess over the friction limit. slip : worst miss of "sticks, or slides
    against a force on the limit". effects : worst of the further effects' own laws.
    force_scale [N], motion_scale [m] : what 1 means (each contact's motion is measured by its own, at most this).
    """

    balance: float
    normal: float
    cone: float
    slip: float
    effects: float
    balance_force: float
    balance_moment: float
    force_scale: float
    motion_scale: float

    @staticmethod
    def of(m: Misses, effects: float) -> Residuals:
        """From what `examine` found, and the worst of the effects' own laws."""
        return Residuals(
            m.balance, m.normal, m.cone, m.slip, effects, m.lost_force, m.lost_moment, m.force_size, m.motion_size
        )

    @property
    def worst(self) -> float:
        """The largest relative residual; infinite where anything is not a number."""
        values = (self.balance, self.normal, self.cone, self.slip, self.effects)
        return max(values) if sum(values) == sum(values) else np.inf  # a sum is NaN wherever a term is

    @property
    def si(self) -> dict[str, float]:
        """The same in SI, unit by name; what is relative to a contact's own motion is bounded by the largest."""
        return {
            "balance_force_N": self.balance_force,
            "balance_moment_Nm": self.balance_moment,
            "normal_m": self.normal * self.motion_scale,
            "cone_N": self.cone * self.force_scale,
            "slip_m": self.slip * self.motion_scale,
        }

    @property
    def passes(self) -> bool:
        """Whether the certifier calls this an answer."""
        return self.worst <= CERTIFY


class Verdict(NamedTuple):
    """What was recomputed, in the laws' coordinates: motion (c,) object minus fingertip [m], and the residuals."""

    motion: Array
    residuals: Residuals


def judge(scene: Scene, effects: tuple[Effect, ...], section: Section, candidate: Candidate) -> Verdict:
    """Recompute balance, contact, friction and elastic compatibility of a candidate."""
    offset = scene.offset
    for e in effects:
        if (opening := e.opening(scene, candidate.extra)) is not None:
            offset = offset + opening
    v, misses = examine(
        scene.given, scene.geometry, scene.kind.contact_components, friction_of(scene, section), offset,
        candidate.components, candidate.twist, GROWTH,
    )  # fmt: skip
    F = misses.force_size
    others = F  # NaN where a force or the twist is not finite: no law is worth asking then
    if F == F:
        own = [e.residual(scene, candidate.components, candidate.extra, F, misses.motion_size) for e in effects]
        others = max(own, default=0.0) if sum(own) == sum(own) else np.inf  # max passes over NaN, a sum does not
    return Verdict(v, Residuals.of(misses, others))


def friction_of(scene: Scene, section: Section) -> Friction:
    """The friction sets of all contacts."""
    return Friction(scene.limits(section), section.faces, outward(scene, section))
