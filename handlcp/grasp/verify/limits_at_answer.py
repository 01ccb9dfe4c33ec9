"""The limits of a scene's effects, together, and which of them give way at an answer."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.limit import Limit
from handlcp.grasp.model.scene import Scene
from handlcp.tolerances import ACTIVE

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
