"""What is done to a grasp, stage by stage: the hand closes, then the load comes; or any other order.

A stage leads every control from where the stage before left it to where it says, in equal steps: the load beside the
weight, the weight, how far the joints are commanded beyond the posture, and how much of the preload is there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError

_KNOWN = ("squeeze", "load", "together")


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage of loading, for `grasp.follow(order=[...])`; what is None stays as it is.

    name : what events call it. load : (6,) force [N] and torque [N·m] about the grasp's reference, besides the weight,
    at the end of the stage. weight : share of the weights of object and load that is there, 0 to 1.
    squeeze : share of the squeeze, of preloads and of the commanded joint offset, ≥ 0. joint_offset : (nv,) [rad, m],
    how far beyond the grasp's posture the joints are commanded, in place of that share.
    """

    name: str
    load: Any = None
    weight: Any = None
    squeeze: Any = None
    joint_offset: Any = None


class Controls(NamedTuple):
    """load (6,) besides the weight; weight, wedge : shares; command (nv,) beyond the posture."""

    load: Array
    weight: float
    wedge: float
    command: Array

    def toward(self, end: Controls, share: float) -> Controls:
        """On the straight way to `end`."""
        rest = 1.0 - share
        return Controls(
            rest * self.load + share * end.load, rest * self.weight + share * end.weight,
            rest * self.wedge + share * end.wedge, rest * self.command + share * end.command,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Goal:
    """A stage as it is run: its name, and the controls at its end."""

    name: str
    end: Controls


def read_stages(
    order: Any, load: Any, wrench: Array, before: Array, command: Array, squeezes: bool, weighs: bool = False
) -> tuple[Controls, list[Goal]]:
    """The controls before anything is done, and the stages.

    order : names "squeeze", "load", "together", or `Stage`s; one alone, or in a sequence. load : as in
    `Grasp.follow`. wrench (6,) : the grasp's own load besides the weight. before, command (nv,) : how far the joints
    are commanded beyond the posture before and after the squeeze. squeezes : whether there is anything to squeeze with;
    a stage "squeeze" without is left out. weighs : whether the object's weight is known apart from the load: "load"
    then brings the weight first, as a stage of its own where there is a load besides.
    Raises InputError.
    """
    given = [order] if isinstance(order, (str, Stage)) else order
    if not isinstance(given, Iterable):
        raise InputError("order", f"stages: {', '.join(_KNOWN)}, or hl.Stage", repr(order)[:80])
    path = _path(load, wrench)
    now = Controls(np.zeros(6), 0.0, 0.0, before)
    first, goals = now, list[Goal]()
    for k, stage in enumerate(given):
        if stage == "load" and weighs and not now.weight and path[0].any():
            now = now._replace(weight=1.0)
            goals.append(Goal("weight", now))
        for goal in _goals(f"order[{k}]", stage, path, now, (before, command)):
            if goal.name == "squeeze" and not squeezes:
                continue
            goals.append(goal)
            now = goal.end
    if not goals:
        expected = "a stage that loads the grasp" + ("" if squeezes else ", which has nothing to squeeze with")
        raise InputError("order", expected, repr(order)[:80])
    return first, goals


def _path(load: Any, wrench: Array) -> Array:
    """(m, 6) loads, one after the other."""
    if load is None:
        return wrench[None]
    given = array("load", load, (6,), (-1, 6))
    if not len(given):
        raise InputError("load", "at least one load", "none")
    return given[None] if given.ndim == 1 else given


def _goals(argument: str, stage: Any, path: Array, now: Controls, commands: tuple[Array, Array]) -> Iterable[Goal]:
    if isinstance(stage, Stage):
        yield _own(argument, stage, now, commands)
    elif stage == "squeeze":
        yield Goal("squeeze", Controls(now.load, now.weight, 1.0, commands[1]))
    elif stage in ("load", "together"):
        wedge, told = (1.0, commands[1]) if stage == "together" else (now.wedge, now.command)
        for k, load in enumerate(path, 1):
            name = str(stage) if k == 1 else f"{stage} {k}"
            yield Goal(name, Controls(load, 1.0, wedge, told))
    else:
        raise InputError(argument, f"one of {', '.join(_KNOWN)}, or an hl.Stage", repr(stage)[:80])


def _own(argument: str, stage: Stage, now: Controls, commands: tuple[Array, Array]) -> Goal:
    before, command = commands
    if not isinstance(stage.name, str) or not stage.name:
        raise InputError(f"{argument}.name", "a name", repr(stage.name))
    load = now.load if stage.load is None else array(f"{argument}.load", stage.load, (6,))
    weight = now.weight if stage.weight is None else number(f"{argument}.weight", stage.weight, minimum=0.0)
    wedge, told = now.wedge, now.command
    if stage.squeeze is not None:
        wedge = number(f"{argument}.squeeze", stage.squeeze, minimum=0.0)
        told = read_only(before + wedge * (command - before))
    if stage.joint_offset is not None:
        if not len(command):
            raise InputError(f"{argument}.joint_offset", "None for a grasp without a hand", repr(stage.joint_offset))
        told = array(f"{argument}.joint_offset", stage.joint_offset, (len(command),))
    return Goal(stage.name, Controls(load, weight, wedge, told))
