"""The grasp's certifier: every law of the scene recomputed from its physics. Imports no solver; NaN never passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.kernels import examine
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.tolerances import CERTIFY, GROWTH

__all__ = ["Residuals", "Verdict", "judge"]


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


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was recomputed: `motion` (n, 3) object minus fingertip in contact axes [m], and the residuals."""

    motion: Array
    residuals: Residuals


def judge(scene: Scene, effects: tuple[Effect, ...], section: Section, candidate: Candidate) -> Verdict:
    """Recompute balance, contact, friction and elastic compatibility of a candidate."""
    f, u = candidate.forces, candidate.twist
    offset = scene.offset
    for e in effects:
        if (opening := e.opening(scene, candidate.extra)) is not None:
            offset = offset + opening
    units = scene.units
    limits = section.limit(scene.mu)
    v, values = examine(
        scene.arms, scene.frames, scene.flexibility, offset, f, u, scene.wrench, limits, scene.governed_mask,
        section.faces, units.length, units.force, 1e-12 * units.motion, GROWTH,
    )  # fmt: skip
    lost_force, lost_moment, balance, normal, cone, slip, F, motion = values
    others = F  # NaN where a force or the twist is not finite: no law is worth asking then
    if F == F:
        own = [e.residual(scene, f, candidate.extra, F, motion) for e in effects]
        others = max(own, default=0.0) if sum(own) == sum(own) else np.inf  # max passes over NaN, a sum does not
    return Verdict(v, Residuals(balance, normal, cone, slip, others, lost_force, lost_moment, F, motion))
