"""The grasp at the end of a step of loading, what is expected of the next step, and why a step fails."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.path.geometry import Look, Where
from handlcp.grasp.path.look.numbers import Loads, Read
from handlcp.grasp.path.program import Controls

__all__ = ["OPEN", "SLIDES", "STICKS", "Failure", "Guess", "State"]

OPEN, STICKS, SLIDES = "separated", "sticking", "sliding"
STILL = read_only(np.zeros(6))


class State(NamedTuple):
    """where : the configuration at the end of the step. look : the contacts as the step was solved with them.
    loads : of the step. carry (n, 3) : slip between that look and the end, as `Geometry.slipped` has it.
    slid (n, 3) : slip of the step, of the object past the fingertip along x and y [m], and about z [rad].
    read : forces, slips and gaps, torques. kinds (n,) : "separated", "sticking", "sliding". yielded (nv,) : how far
    joints at their limit are driven back [rad]. controls : what was asked for. start : where the next solve begins.
    gives (k,) : motions of limits that give way. looks : how many the step took. met (dof, dof) : the wrench that a
    small push meets, natural units, along it where it drives it further; empty where that was not measured.
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
    gives: Array
    looks: int
    met: Array

    @property
    def loaded(self) -> bool:
        """Whether any contact carries anything."""
        return any(kind != OPEN for kind in self.kinds)

    @property
    def same(self) -> Guess:
        """That the next step changes nothing."""
        return Guess(self.where, self.start, self.gives)


class Guess(NamedTuple):
    """What is expected of a step's end. where : a configuration near it. start : forces in the laws' coordinates,
    twist and centre, as `State.start` has them. gives : as in `State`.
    """

    where: Where
    start: Array
    gives: Array


class Failure(NamedTuple):
    """Why a step has no end. kind : "no answer" (these fingers create no forces that balance the load), "runs away"
    (the end moves on however often it is looked at), "too far" (the object moves farther than a step may).
    """

    kind: str
