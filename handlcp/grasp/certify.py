"""The grasp's certifier: every law of the scene recomputed from its physics. Imports no solver; NaN never passes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from handlcp.check import Array, nothing
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.kernels import examine
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_laws import soft_laws
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
    """What was recomputed, in the laws' coordinates: `motion` (n, 3) object minus fingertip [m], the residuals, and
    turn (k,), how far the object turns on the soft fingertips, times their levers [m].
    """

    motion: Array
    residuals: Residuals
    turn: Array = field(default_factory=nothing)


def judge(scene: Scene, effects: tuple[Effect, ...], section: Section, candidate: Candidate) -> Verdict:
    """Recompute balance, contact, friction and elastic compatibility of a candidate."""
    if scene.soft:
        return _judge_soft(scene, effects, section, candidate)
    f, u = candidate.forces, candidate.twist
    offset = scene.offset
    for e in effects:
        if (opening := e.opening(scene, candidate.extra)) is not None:
            offset = offset + opening.reshape(-1, 3)
    units = scene.units
    limits = section.limit(scene.mu)
    v, values = examine(
        scene.arms, scene.frames, scene.flexibility, offset, f, u, scene.wrench, limits, scene.governed_mask,
        section.faces, units.length, units.force, 1e-12 * units.motion, GROWTH,
    )  # fmt: skip
    lost_force, lost_moment, balance, normal, cone, slip, F, motion = values
    others = F  # NaN where a force or the twist is not finite: no law is worth asking then
    if F == F:
        others = _own_laws(scene, effects, candidate, F, motion)
    return Verdict(v, Residuals(balance, normal, cone, slip, others, lost_force, lost_moment, F, motion))


def _own_laws(scene: Scene, effects: tuple[Effect, ...], candidate: Candidate, F: float, motion: float) -> float:
    """Worst residual of the effects' own laws."""
    own = [e.residual(scene, candidate.components, candidate.extra, F, motion) for e in effects]
    return max(own, default=0.0) if sum(own) == sum(own) else np.inf  # max passes over NaN, a sum does not


def _judge_soft(scene: Scene, effects: tuple[Effect, ...], section: Section, candidate: Candidate) -> Verdict:
    """The same where contacts are soft: their moments load the object and turn the fingertips, and join the friction
    law.
    """
    n, governed, c = scene.n, scene.governed_mask.copy(), candidate.components
    governed[list(scene.soft)] = False  # their laws are examined below
    E, u = scene.flexibility, candidate.twist
    opened = np.zeros(scene.components)
    for e in effects:
        if (opening := e.opening(scene, candidate.extra)) is not None:
            opened = opened + opening
    offset = (scene.offset.ravel() + opened[: 3 * n] + E[: 3 * n, 3 * n :] @ candidate.torsion).reshape(-1, 3)
    units, limits = scene.units, section.limit(scene.mu)
    v, values = examine(
        scene.arms, scene.frames, np.ascontiguousarray(E[: 3 * n, : 3 * n]), offset, candidate.forces, u, scene.wrench,
        limits, governed, section.faces, units.length, units.force, 1e-12 * units.motion, GROWTH,
    )  # fmt: skip
    _, _, _, normal, cone, slip, F, motion = values
    lost = scene.wrench + scene.grasp_matrix @ c
    lost_force, lost_moment = float(np.linalg.norm(lost[:3])), float(np.linalg.norm(lost[3:]))
    balance = float(np.hypot(lost_force, lost_moment / units.length)) / F
    turn = scene.spin_axes.T @ u[3:] + E[3 * n :] @ c + opened[3 * n :] + scene.every_offset[3 * n :]
    others = F
    if F == F and np.isfinite(turn).all():
        worst = soft_laws(scene, section, candidate, v, turn, F, opened)
        normal, cone, slip = (max(a, b) for a, b in zip((normal, cone, slip), worst, strict=True))
        others = _own_laws(scene, effects, candidate, F, motion)
    else:
        others = np.nan
    return Verdict(v, Residuals(balance, normal, cone, slip, others, lost_force, lost_moment, F, motion), turn)
