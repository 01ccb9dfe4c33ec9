"""The grasp at the end of a step of loading, what is expected of the next step, and why a step fails."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.loading.geometry import Look, Where
from handlcp.grasp.loading.numbers import Loads, Read
from handlcp.grasp.loading.stage import Controls

__all__ = ["OPEN", "SLIDES", "STICKS", "STILL", "Failure", "Guess", "State"]

OPEN, STICKS, SLIDES = "separated", "sticking", "sliding"
STILL = read_only(np.zeros(6))


class State(NamedTuple):
    """where : the configuration at the end of the step. look : the contacts as the step was solved with them.
    loads : of the step. carry (n, 3) : slip between that look and the end, as `Geometry.slipped` has it.
    slid (n, 3) : slip of the step, of the object past the fingertip along x and y [m], and about z [rad].
    read : forces, slips and gaps, torques. kinds (n,) : "separated", "sticking", "sliding". yielded (nv,) : how far
    joints at their limit are driven back [rad]. controls : what was asked for. start : where the next solve begins.
    looks : how many the step took. marks : of the joints, as `Watch.marks` has them.
    """

    where: Where
    look: Look
    loads: Loads
    carry: Array
    slid: Array
    read: Read
    kinds: tuple[str, ...]
    yielded: Array
    controls: Controls
    start: Array
    looks: int
    marks: tuple[bytes, bytes, bytes]

    @property
    def loaded(self) -> bool:
        """Whether any contact carries anything."""
        return any(kind != OPEN for kind in self.kinds)

    @property
    def same(self) -> Guess:
        """That the next step changes nothing."""
        return Guess(self.where, self.start, STILL)


class Guess(NamedTuple):
    """What is expected of a step's end. where : a configuration near it. start : forces, as `State.start` has them.
    motion (6,) : of the object from there to the end, about its reference.
    """

    where: Where
    start: Array
    motion: Array


class Failure(NamedTuple):
    """Why a step has no end. kind : "no balance" (nothing within friction balances the load), "no answer" (these
    fingers do not create such forces), "runs away" (the end moves on however often it is looked at), "unstable" (a
    small push does not return), "loose" (nothing holds the object any more),
    "pushed out" (fingers that close push it away and never hold it).
    motion (6,) : of the object about its reference, when it runs away; None: not known.
    """

    kind: str
    motion: Array | None = None
