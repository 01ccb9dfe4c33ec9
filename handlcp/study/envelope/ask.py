"""The limits of one grasp along many directions, asked for in pieces so that one sees how far they have come."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.batch.solve_many import Progress, told
from handlcp.grasp.cause.judge import OBJECT, UNDECIDED, Cause
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.directions import limits_of
from handlcp.grasp.verify.bound import bound_of
from handlcp.lcp.compiler.when import at_once
from handlcp.study.envelope.load import Load

FIXED, FOLLOWED = "fixed", "followed"
_PIECE = {FIXED: 64, FOLLOWED: 4}  # directions that are asked for at once

Binds = tuple[Cause, ...]


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked along every direction. section : of friction. geometry, motion, turn, accuracy : as in
    `envelope`.
    """

    load: Load
    section: Section
    geometry: str
    motion: float | None
    turn: float | None
    accuracy: float | None = None

    def wrenches(self, directions: Array, given: Array | None) -> Array:
        """(m, 6) for a factor of 1. given : in place of those of the directions."""
        return self.load.wrenches(directions) if given is None else given

    def ask(
        self, directions: Array, given: Array | None, progress: Progress = None
    ) -> tuple[Array, tuple[Binds, ...], Array]:  # fmt: skip
        """(m,) factors, and for each what binds, () where nothing does, and its estimated error. progress : as in
        `envelope`.

        No load that friction and torque limits alone bound is held without end: where a path found no limit although
        there is such a bound, the factor is NaN.
        """
        wrenches, m = self.wrenches(directions, given), len(directions)
        factors, binds, off = np.empty(m), list[Binds]([()] * m), np.empty(m)
        with told(progress, m) as done, at_once(m):
            done(0)
            for spec, where in self.load.specs(directions):
                every = np.flatnonzero(where)
                for start in range(0, len(every), _PIECE[self.geometry]):
                    here = every[start : start + _PIECE[self.geometry]]
                    most = self.motion, self.turn
                    found = limits_of(spec, self.section, wrenches[here], self.geometry, *most, self.accuracy)
                    factors[here], off[here] = found.factors, found.accuracy
                    for k, some in zip(here.tolist(), found.binds, strict=True):
                        binds[k] = some
                    endless = here[np.isinf(found.factors)]
                    if len(endless):
                        known = bound_of(spec, self.section, wrenches[endless]).factors
                        for k in endless[np.isfinite(known)].tolist():
                            factors[k], binds[k] = np.nan, (Cause(UNDECIDED, OBJECT),)
                    done(len(here))
        return factors, tuple(binds), off

    def bound(self, directions: Array, given: Array | None) -> Array:
        """(m,) the largest factors that any forces within friction and torque limits balance."""
        wrenches, found = self.wrenches(directions, given), np.empty(len(directions))
        for spec, where in self.load.specs(directions):
            found[where] = bound_of(spec, self.section, wrenches[where]).factors
        return found
