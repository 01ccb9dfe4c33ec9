"""The grasp's certifier: every law of the scene recomputed from its physics. Imports no solver; NaN never passes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import outward
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Section
from handlcp.grasp.model.limit import Limit
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.contact_laws import Friction, Misses, examine
from handlcp.tolerances import ACTIVE, CERTIFY, GROWTH

# ----------------------------------------------------------------
# The limits of a scene's effects, together, and which of them give way at an answer.

_MOST_RESTING = 4  # limits just reached whose 2^k choices are all looked at; beyond that all or none give way


def every_limit(scene: Scene, effects: tuple[Effect, ...]) -> tuple[Limit, ...]:
    """What the effects limit, empty groups left out, in the effects' order."""
    return tuple([limit for e in effects for limit in e.present(scene)])


def stacked(scene: Scene, every: tuple[Limit, ...]) -> tuple[Array, Array]:
    """(m, c) rows A and (m,) room b of all limits A r ≤ b, natural units."""
    rows = [np.zeros((0, scene.components)), *(limit.natural_rows for limit in every)]
    return np.concatenate(rows), np.concatenate([np.zeros(0), *(limit.natural_room(scene) for limit in every)])


@dataclass(frozen=True, slots=True, eq=False)
class LimitsAtAnswer:
    """The m limits of a scene at an answer, natural units.

    rows (m, c), motion (m,) s and slack (m,) b - A r. resting (m,): just reached, and not giving way yet.
    every : what they are made of. extra : the answer's unknowns of effects, SI.
    """

    rows: Array
    motion: Array
    slack: Array
    resting: Bools
    every: tuple[Limit, ...]
    extra: dict[str, Array]

    def choices(self) -> list[Bools]:
        """Which limits give way: those that do, with those at rest in every way."""
        if not len(self.rows):
            return [self.resting]
        at = np.flatnonzero(self.resting)
        few = len(at) <= _MOST_RESTING
        ways = list(itertools.product((False, True), repeat=len(at))) if few else [(False,), (True,)]
        out = np.tile(self.motion > ACTIVE, (len(ways), 1))
        out[:, at] = ways
        return list(out)

    def conditions(self, basis: Array, active: Bools, multipliers: Array) -> tuple[Array, Array]:
        """(D, now), limits' order: now + D c ≥ 0 keeps every limit, and every motion ≥ 0, along a branch's basis."""
        D = -self.rows @ basis[: self.rows.shape[1]]
        D[active] = multipliers
        return D, np.where(active, self.motion, self.slack)

    def moved(self, scene: Scene, active: Bools, change: Array) -> dict[str, Array]:
        """The answer's `extra` after a change (active.sum(),) of what gives way, natural units."""
        s = self.motion.copy()
        s[active] = np.maximum(s[active] + change, 0.0)
        moved, at = dict(self.extra), 0
        for limit in self.every:
            moved[limit.name] = s[at : at + len(limit.room)] * limit.unknown.sizes(scene)[0]
            at += len(limit.room)
        return moved


def limits_at_answer(scene: Scene, effects: tuple[Effect, ...], candidate: Candidate) -> LimitsAtAnswer:
    """The limits where this candidate stands."""
    if not (every := every_limit(scene, effects)):  # nearly all scenes: a tenth of what follows where motions are free
        return LimitsAtAnswer(np.zeros((0, scene.components)), _NONE, _NONE, _NONE > 0.0, (), candidate.extra)
    rows, room = stacked(scene, every)
    motion = np.concatenate([np.zeros(0), *(limit.natural_motion(scene, candidate.extra) for limit in every)])
    slack = room - rows @ (candidate.components / scene.units.force)
    resting = (motion <= ACTIVE) & (slack <= ACTIVE * np.maximum(abs(room), 1.0))
    return LimitsAtAnswer(rows, motion, slack, resting, every, candidate.extra)


_NONE = np.zeros(0)


# ----------------------------------------------------------------


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
