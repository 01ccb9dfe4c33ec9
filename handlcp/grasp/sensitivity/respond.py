"""How an answer responds to changes: one elimination for all of them, and one side after the other at a kink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.sensitivity.kinks import Kink, kinks_at, one_sided
from handlcp.grasp.sensitivity.stand import Stand
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, Rates
from handlcp.grasp.tangent.solutions import smallest
from handlcp.lazy import lazy
from handlcp.tolerances import RANK

_FREE = 1e-7  # what the free directions of a singular system move by less is determined


@dataclass(frozen=True, eq=False)
class Response:
    """Of an answer, at which it stands."""

    at: Stand

    @classmethod
    def of(cls, answer: Answer) -> Response:
        """Where it stands, and what unit changes do to it."""
        return cls(Stand.of(answer))

    @lazy
    def kinks(self) -> tuple[Kink, ...]:
        """Contacts and limits whose next state depends on the direction of the change."""
        return kinks_at(self.at)

    @lazy
    def free(self) -> Array:
        """(k, j) what spans the changes that no law resists, natural units; j = 0: there are none."""
        if self.at.found.regular:
            return np.zeros((len(self.at.found.inverse), 0))
        A, _ = self.at.equations(self.at.states, self._gives)
        return smallest(A, np.zeros((len(A), 0)), RANK)[1]

    @property
    def _gives(self) -> Bools:
        """(m,) the limits that give way."""
        reached = self.at.answer.yielding
        return np.arange(len(reached.at)) < reached.active

    def to(self, change: Change) -> Rates:
        """The rates; at a kink those of a growing parameter, column by column."""
        at, b = self.at, self.at.right_hand_sides(change)
        if self.kinks:
            found = [one_sided(at, self.kinks, column) for column in b.T]
            none = np.zeros((len(at.found.inverse), 0))
            rates = self._rates(np.column_stack([none, *[x for x, _ in found]]), change)
            for k, (_, free) in enumerate(found):
                self._leave_open(rates, slice(k, k + 1), free)
            return rates
        if at.found.regular:
            return self._rates(at.found.inverse @ b, change)
        A, B = at.equations(at.states, self._gives)
        rates = self._rates(smallest(A, B @ b, RANK)[0], change)
        self._leave_open(rates, slice(None), self.free)
        return rates

    def _rates(self, x: Array, change: Change) -> Rates:
        """In SI and contact axes."""
        at, c = self.at, self.at.answer.scene.components
        scale = at.answer.scale[:, None]
        forces, motion = x[:c] * at.answer.sizes[0] * scale, at.motion(x)
        return Rates(forces, motion, (at.moved(x) + change.motion) / scale)

    def _leave_open(self, rates: Rates, columns: slice, N: Array) -> None:
        """Write NaN into columns of rates, for what N (k, j) leaves free."""
        if not N.shape[1]:
            return
        at, units, c = self.at, self.at.answer.sizes, self.at.answer.scene.components
        rates.forces[abs(N[:c]).max(axis=1) > _FREE, columns] = np.nan
        moved = at.motion(N) / (units[1] / np.array((1.0,) * 3 + (units[2],) * 3))[:, None]
        rates.motion[abs(moved).max(axis=1) > _FREE, columns] = np.nan
        rates.slip[abs(at.moved(N)).max(axis=1) > _FREE * units[1], columns] = np.nan
