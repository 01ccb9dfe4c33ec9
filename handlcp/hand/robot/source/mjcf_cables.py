"""Tendons along a path in space that servos of an MJCF model draw in, and springs of tendons, which are left out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

import numpy as np

from handlcp import words
from handlcp.hand.robot.joints import Doubt
from handlcp.hand.robot.source.file_cables import Cable, write_cable
from handlcp.hand.robot.source.mjcf_parts import MOVES_TENDON
from handlcp.hand.robot.source.mjcf_routes import routes

ROUTE = "route"  # what a doubt is about that a hand with tendons is free of
LEFT_OUT = "servo"  # what one is about that says why a servo is not read
_ADVICE = "joint_stiffness=Tendons(hl.tendon_routes(...), ...)"
_SIGN = "; a pull shortens: forcerange below 0 for a gear above 0, above 0 for a gear below 0"


def write_cables(root: ET.Element, model: Any, servos: dict[int, float]) -> Iterator[Doubt]:
    """Write each tendon with its servos' kp and the force that they pull with; a doubt for each reason why some
    cannot be had, or for those that are had, where the hand has other springs.

    servos : number of the actuator → kp [N/m, N·m/rad], of all position actuators.
    """
    drawn = dict[int, list[int]]()
    read, refused = routes(model)
    of_tendons = [a for a in servos if int(model.actuator_trntype[a]) == MOVES_TENDON]
    for a in of_tendons:
        drawn.setdefault(int(model.actuator_trnid[a, 0]), []).append(a)
    names = {t: model.tendon(t).name or f"tendon {t}" for t in range(model.ntendon)}
    spatial = {t: actuators for t, actuators in drawn.items() if names[t] in read or names[t] in refused}
    alone = sum(len(actuators) for actuators in spatial.values()) == len(servos)
    found = dict[tuple[str, str, str], list[str]]()
    for t, actuators in spatial.items():
        who, limit, about = [model.actuator(a).name or f"actuator {a}" for a in actuators], _pull(model, actuators), ""
        if not alone:
            why = ", beside servos of joints: their kp is not read"
        elif names[t] in refused:
            why = f", which is not read: {refused[names[t]]}"
        elif limit <= 0.0:
            why = " and only push, which no cable does: they are left out"
        else:
            why, about = "; here each joint has a spring of its own", ROUTE
            write_cable(root, Cable(names[t], sum(servos[a] for a in actuators), limit, read[names[t]]))
        found.setdefault((why, about or LEFT_OUT, _ADVICE + (_SIGN if limit <= 0.0 else "")), []).extend(who)
    for (why, about, advice), who in found.items():
        what = f"servos ({words.listed(who)}) act on tendons along a path in space{why}"
        yield Doubt("hand", what, advice, "minor", about)
    yield from _own(model, names)


def _own(model: Any, names: dict[int, str]) -> Iterator[Doubt]:
    """Of what tendons have of their own, which is left out: springs, dry friction, ranges of their length."""
    rubbing = [names[t] for t in names if float(model.tendon_frictionloss[t]) > 0.0]
    ranged = [names[t] for t in names if model.tendon_limited[t]]
    for those, what, advice, about in (
        (rubbing, "dry friction of their own (frictionloss)", "Tendons(friction=...), or joint_friction", "friction"),
        (ranged, "a range of their own, at whose ends they would stop", "ranges of joints that keep it", "range"),
    ):
        if those:
            said = f"of tendons ({words.listed(those)}) {what} is left out"
            yield Doubt("hand", said, advice, "minor", about)
    for t in names:
        if (k := float(np.ravel(model.tendon_stiffness[t])[0])) > 0.0:
            what = f"the tendon {names[t]!r} has a spring of its own of {k:g}, which is left out"
            yield Doubt("hand", what, "joint_stiffness with what that spring adds", "minor", "stiffness")


def _pull(model: Any, actuators: list[int]) -> float:
    """[N] With which actuators draw a tendon in: their forces along it that shorten it."""
    pull = 0.0
    for a in actuators:
        ends = float(model.actuator_gear[a, 0]) * model.actuator_forcerange[a]
        pull += -float(min(ends)) if model.actuator_forcelimited[a] else np.inf
    return pull
