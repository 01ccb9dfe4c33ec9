"""What a path is made of: stages and controls, and the states and ends of a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, check_array, check_init_call, check_number, check_sequence, read_only
from handlcp.errors import InputError, shorten_repr
from handlcp.grasp.model.request import GraspSpec, check_load
from handlcp.grasp.model.status import ContactStatus, PathStatus
from handlcp.grasp.model.validate import WRENCH_EXPECTED
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.geometry import Iterate, Where
from handlcp.grasp.path.newton.numbers import Loads, Read
from handlcp.grasp.path.pull import Pull

# ----------------------------------------------------------------
# What is done to a grasp, stage by stage: the hand closes, then the load comes; or any other order.
#
# A stage leads every control from where the stage before left it to where it says, in equal steps: the load beside the
# weight, the weight, how far the joints are commanded beyond the posture, and how much of the preload is there.

LET_GO = "let go"  # the stage in which an object is let go that was kept in place while the hand closed
_KNOWN = ("squeeze", "load", "together")


@check_init_call()
@dataclass(frozen=True, slots=True)
class Stage:
    """One stage of loading, for `grasp.follow(order=[...])`; what is None stays as it is.

    name : what events call it. load : (6,) force [N] and torque [N·m] about the grasp's reference, besides the weight,
    at the end of the stage; of a planar grasp also (3,), as in `Grasp`. weight : share of the weights of object and
    load that is there, 0 to 1. squeeze : share of the squeeze, of preloads and of the commanded joint offset, ≥ 0.
    joint_offset : (nv,) [rad, m], how far beyond the grasp's posture the joints are commanded, in place of that share.
    """

    name: str
    load: Any = None
    weight: Any = None
    squeeze: Any = None
    joint_offset: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the grasp."""
        if not isinstance(self.name, str) or not self.name:
            raise InputError("Stage.name", "a name", shorten_repr(self.name))
        for name in ("weight", "squeeze"):
            if (value := getattr(self, name)) is not None:
                check_number(f"Stage.{name}", value, minimum=0.0)
        if self.load is not None:
            check_array("Stage.load", self.load, (6,), (3,), what=WRENCH_EXPECTED)
        if self.joint_offset is not None:
            check_array("Stage.joint_offset", self.joint_offset, (-1,))


class Controls(NamedTuple):
    """load (6,) besides the weight; weight, preload : shares; command (nv,) beyond the posture. kept : whether the
    object is kept in place, by something else than the hand.
    """

    load: Array
    weight: float
    preload: float
    command: Array
    kept: bool = False

    def toward(self, end: Controls, share: float) -> Controls:
        """On the straight way to `end`."""
        rest = 1.0 - share
        stands = np.array_equal(self.command, end.command)  # to the last bit: drives that stand still hold
        command = end.command if stands else rest * self.command + share * end.command
        return Controls(
            rest * self.load + share * end.load, rest * self.weight + share * end.weight,
            rest * self.preload + share * end.preload, command, end.kept,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Goal:
    """A stage as it is run: its name, and the controls at its end."""

    name: str
    end: Controls


def read_stages(
    spec: GraspSpec,
    order: Any,
    load: Array | None,
    wrench: Array,
    before: Array,
    command: Array,
    squeezes: bool,
    weighs: bool = False,
    kept: bool = False,
) -> tuple[Controls, list[Goal]]:
    """The controls before anything is done, and the stages.

    spec : of the grasp, about whose reference loads of stages are. order : names "squeeze", "load", "together", or
    `Stage`s; one alone, or in a sequence. load : as in `follow`. wrench (6,) : the grasp's own load besides the weight.
    before, command (nv,) : how far the joints are commanded beyond the posture before and after the squeeze.
    squeezes : whether there is anything to squeeze with; a stage "squeeze" without is left out. weighs : whether the
    object's weight is known apart from the load: "load" then brings the weight first, as a stage of its own where there
    is a load besides. kept : whether the object is kept in place while the hand squeezes.
    Raises InputError.
    """
    given = [order] if isinstance(order, (str, Stage)) else order
    given = check_sequence("order", given, f"stages: {', '.join(_KNOWN)}, or hl.Stage")
    path = np.atleast_2d(wrench if load is None else load)
    now = Controls(np.zeros(6), 0.0, 0.0, before)
    first, goals = now, list[Goal]()
    for k, stage in enumerate(given):
        if isinstance(stage, str) and stage == "load" and weighs and not now.weight and path[0].any():
            now = now._replace(weight=1.0)
            goals.append(Goal("weight", now))
        for goal in _goals(spec, f"order[{k}]", stage, path, now, (before, command)):
            if goal.name == "squeeze":
                if not squeezes:
                    continue
                goal = Goal(goal.name, goal.end._replace(kept=kept))
            goals.append(goal)
            now = goal.end
            if now.kept:
                now = now._replace(kept=False)
                goals.append(Goal(LET_GO, now))
    if not goals:
        expected = "a stage that loads the grasp" + ("" if squeezes else ", which has nothing to squeeze with")
        raise InputError("order", expected, repr(order)[:80])
    return first, goals


def _goals(
    spec: GraspSpec, argument: str, stage: Any, path: Array, now: Controls, commands: tuple[Array, Array]
) -> Iterable[Goal]:
    if isinstance(stage, Stage):
        yield _own(spec, argument, stage, now, commands)
    elif not isinstance(stage, str):
        raise InputError(argument, f"one of {', '.join(_KNOWN)}, or an hl.Stage", shorten_repr(stage))
    elif stage == "squeeze":
        yield Goal("squeeze", Controls(now.load, now.weight, 1.0, commands[1]))
    elif stage in ("load", "together"):
        preload, commanded = (1.0, commands[1]) if stage == "together" else (now.preload, now.command)
        for k, load in enumerate(path, 1):
            name = str(stage) if k == 1 else f"{stage} {k}"
            yield Goal(name, Controls(load, 1.0, preload, commanded))
    else:
        raise InputError(argument, f"one of {', '.join(_KNOWN)}, or an hl.Stage", repr(stage)[:80])


def _own(spec: GraspSpec, argument: str, stage: Stage, now: Controls, commands: tuple[Array, Array]) -> Goal:
    before, command = commands
    load = now.load if stage.load is None else check_load(spec, stage.load, f"{argument}.load")
    weight = now.weight if stage.weight is None else check_number(f"{argument}.weight", stage.weight, minimum=0.0)
    preload, commanded = now.preload, now.command
    if stage.squeeze is not None:
        preload = check_number(f"{argument}.squeeze", stage.squeeze, minimum=0.0)
        commanded = read_only(before + preload * (command - before))
    if stage.joint_offset is not None:
        if not len(command):
            raise InputError(f"{argument}.joint_offset", "None for a grasp without a hand", repr(stage.joint_offset))
        commanded = check_array(f"{argument}.joint_offset", stage.joint_offset, (len(command),))
    return Goal(stage.name, Controls(load, weight, preload, commanded))


# ----------------------------------------------------------------
# The grasp at the end of a step of loading, what is expected of the next one, why a step fails, and a run of them.

OPEN, STICKS, SLIDES = ContactStatus.SEPARATED, ContactStatus.STICKING, ContactStatus.SLIDING
STILL = read_only(np.zeros(6))


@dataclass(frozen=True, eq=False)
class State:
    """where : the configuration at the end of the step. iterate : the contacts as the step was solved with them.
    loads : of the step. slip_memory (n, 3) : slip between that iterate and the end, as `Geometry.slipped` has it.
    slid (n, 3) : slip of the step, of the object past the fingertip along x and y [m], and about z [rad].
    read : forces, slips and gaps, torques. kinds (n,) : OPEN, STICKS or SLIDES. yielded (nv,) : how far
    joints at their limit are driven back [rad]. controls : what was asked for. start : where the next solve begins.
    gives (k,) : motions of limits that give way. iterates : how many the step took. met (dof, dof) : the wrench that a
    small push meets, natural units, along it where it drives it further; empty where that was not measured. rubs
    (nv,) : dry friction at the joints, which takes so much of what their springs pull with [N·m]. pull : of tendons.
    """

    where: Where
    iterate: Iterate
    loads: Loads
    slip_memory: Array
    slid: Array
    read: Read
    kinds: tuple[ContactStatus, ...]
    yielded: Array
    controls: Controls
    start: Array
    gives: Array
    iterates: int
    met: Array
    rubs: Array
    pull: Pull

    def with_kinds(self, kinds: tuple[ContactStatus, ...]) -> State:
        """The same with other contact states."""
        return State(**{f.name: getattr(self, f.name) for f in fields(self)} | {"kinds": kinds})

    @property
    def efforts(self) -> Array:
        """(nv + t,) torques that the joints hold, and tensions of tendons [N·m, N]."""
        return np.concatenate([self.read.torque, self.pull.tension]) if len(self.pull.tension) else self.read.torque

    @property
    def pulled(self) -> Array:
        """(nv,) torques with which the drives pull, friction included [N·m]."""
        return self.read.torque + self.rubs

    @property
    def stretched(self) -> Array:
        """(nv,) the same without what holds springs beside the drives [N·m]: that of K alone."""
        return self.pulled - self.read.springs

    @property
    def slides(self) -> bool:
        """Whether a contact slides."""
        return SLIDES in self.kinds

    @property
    def loaded(self) -> bool:
        """Whether any contact carries anything."""
        return any(kind != OPEN for kind in self.kinds)

    @property
    def same(self) -> Guess:
        """What is expected of a step that changes nothing."""
        return Guess(self.where, self.start, self.gives)


class Guess(NamedTuple):
    """What is expected of a step's end. where : a configuration near it. start : forces in the laws' coordinates,
    twist and centre, as `State.start` has them. gives : as in `State`.
    """

    where: Where
    start: Array
    gives: Array


class Failure(NamedTuple):
    """Why a path goes no further. who : the tendon that crosses a body, in words; "" of everything else."""

    status: PathStatus
    who: str = ""


class Snap(NamedTuple):
    """The object moves at constant load from one static state to another, or leaves. stage, share : where it begins,
    and `until` where a chain of them ends. moved [m], turned [rad] : of the object in all. rests : whether it comes to
    rest. pushed (6,) : where it leaves a state in balance, as a column that buckles does: the motion of the small push
    that grows there, world axes, the same one of two that are alike; (): no state in balance is left.
    """

    stage: int
    share: float
    until: float
    moved: float
    turned: float
    rests: bool
    pushed: tuple[float, ...]


class Slides(NamedTuple):
    """Where a contact that presses has first slid as far as it may since the load began. stage, share : where. number :
    of the state there.
    """

    stage: int
    share: float
    number: int


class Jump(NamedTuple):
    """Where a loaded object first has no static state to go on to: it snaps, or is lost. stage, share : where. number :
    of the last state before.
    """

    stage: int
    share: float
    number: int


def first_of(slides: Slides | None, jump: Jump | None) -> Slides | Jump | None:
    """Which comes first; None: neither comes."""
    found = [one for one in (slides, jump) if one is not None]
    return min(found, key=lambda one: (one.stage, one.share), default=None)


@dataclass(slots=True)
class Run:
    """states, stages (number of the stage) and shares of all steps, the state before anything included; slipped (n,) of
    each : how far contacts have slid since the load began, the length of the way [m]; errors of each step : estimated,
    relative, of the forces; events; snaps; slides, jump : the first of each, None: nowhere; under_way : the number of
    the stage that was begun last; status : how it ends; who : the tendon that crosses a body there, in words.
    """

    states: list[State]
    stages: list[int]
    shares: list[float]
    slipped: list[Array] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    snaps: list[Snap] = field(default_factory=list)
    slides: Slides | None = None
    jump: Jump | None = None
    under_way: int = 0
    status: PathStatus = PathStatus.REACHED
    who: str = ""

    @classmethod
    def beginning_at(cls, state: State, slipped: Array | None = None) -> Run:
        """A run of no step yet. slipped (n,) : before it; None: not at all."""
        return cls([state], [0], [0.0], [np.zeros(len(state.kinds)) if slipped is None else slipped], [0.0])

    @property
    def gives_way(self) -> Slides | Jump | None:
        """Where the object begins to leave its place, the first of both; None: nowhere."""
        return first_of(self.slides, self.jump)

    def add(self, state: State, stage: int, share: float, slipped: Array, error: float) -> None:
        """One more step."""
        self.states.append(state)
        self.stages.append(stage)
        self.shares.append(share)
        self.slipped.append(slipped)
        self.errors.append(error)

    def ends(self, status: PathStatus, who: str = "") -> bool:
        """Note how the path ends before its program is finished. Returns False."""
        self.status, self.who = status, who
        return False
