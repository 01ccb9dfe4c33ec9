"""The grasp at the end of a step of loading, what is expected of the next one, why a step fails, and a run of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.geometry import Look, Where
from handlcp.grasp.path.look.numbers import Loads, Read
from handlcp.grasp.path.program import Controls

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


class Outcome(Enum):
    """How a path ends: at the END of its program; at a LIMIT that was set, such as a joint's torque; LOST, no static
    state follows and the object leaves; UNBOUNDED, nothing ends it however large the load; GAVE_UP, more steps than any
    path of use takes: never a limit.
    """

    END = "end"
    LIMIT = "limit"
    LOST = "lost"
    UNBOUNDED = "unbounded"
    GAVE_UP = "gave up"


class Snap(NamedTuple):
    """The object moves at constant load from one static state to another, or leaves. stage, share : where it begins,
    and `until` where a chain of them ends. moved [m], turned [rad] : of the object in all. rests : whether it comes to
    rest. pushed (6,) : it leaves a state that is static, too, as a column that buckles does: the motion of the small
    push that grows there, world axes, of two that are alike always the same; (): no static state is left.
    """

    stage: int
    share: float
    until: float
    moved: float
    turned: float
    rests: bool
    pushed: tuple[float, ...]


class Slides(NamedTuple):
    """Where nothing that presses sticks any more, and the object has gone too far (`path/watch`), or it snaps.
    stage, share : where. number : of the last state before.
    """

    stage: int
    share: float
    number: int


@dataclass(slots=True)
class Run:
    """states, stages (number of the stage) and shares of all steps, the state before anything included; events; snaps;
    slides : where the object begins to slide through, None: nowhere; how it ends: outcome, and failure : why there is
    no next state.
    """

    states: list[State]
    stages: list[int]
    shares: list[float]
    events: list[Event] = field(default_factory=list)
    snaps: list[Snap] = field(default_factory=list)
    slides: Slides | None = None
    outcome: Outcome = Outcome.END
    failure: Failure | None = None

    def add(self, state: State, stage: int, share: float) -> None:
        """One more step."""
        self.states.append(state)
        self.stages.append(stage)
        self.shares.append(share)

    def ends(self, outcome: Outcome, failure: Failure | None = None) -> bool:
        """That the program is not finished: False."""
        self.outcome, self.failure = outcome, failure
        return False
