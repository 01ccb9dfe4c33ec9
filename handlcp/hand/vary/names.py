"""The names by which a hand's numbers are changed: arguments of `Hand.replace`, and "<joint>.length" and the like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from handlcp.errors import InputError, UnknownName, Unsupported
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.source.description import COLLISION

WHOLE = ("joint_stiffness", "pad_flexibility", "torque_limits", "tip_radius", "motors", "joint_friction")
LENGTH, AXIS, POSITION = "length", "axis", "position"
STIFFNESS, LIMIT, MOTOR, RADIUS, PAD = "stiffness", "torque_limit", "motor", "radius", "pad"


class Changes(NamedTuple):
    """whole : arguments of `Hand.replace`. named : what is changed → of which joint, fingertip, … → to what."""

    whole: dict[str, Any]
    named: dict[str, dict[str, Any]]

    def of(self, what: str) -> dict[str, Any]:
        """By name; {} where nothing is changed."""
        return self.named.get(what, {})


def argument(of: str, what: str) -> str:
    """What messages call a change."""
    return f"changes[{f'{of}.{what}'!r}]"


def read_changes(hand: HandModel, changes: Any) -> Changes:
    """Raises UnknownName, InputError; Unsupported for a hand whose fingertips are contacts on its links."""
    if not isinstance(changes, Mapping):
        raise InputError("changes", 'a mapping by name, such as {"joint_stiffness": 4.0}', repr(changes)[:80])
    if changes and hand.links_of_sites is not None:
        raise Unsupported("the hand of a grasp on links has its contacts as fingertips: vary the hand that made it")
    known, found = _known(hand), Changes({}, {})
    for name, value in changes.items():
        of, dot, what = name.rpartition(".") if isinstance(name, str) else ("", "", "")
        if isinstance(name, str) and name in WHOLE:
            found.whole[name] = value
        elif what in known and of in known[what]:
            found.named.setdefault(what, {})[of] = value
        else:
            raise _unknown(name, of, what if dot else "", known)
    both = [joint for joint in found.of(LIMIT) if found.of(MOTOR).get(joint) is not None]
    if both:
        raise InputError(argument(both[0], LIMIT), "no limit of a joint with a motor, which gives it", "both")
    return found


def _known(hand: HandModel) -> dict[str, Sequence[str]]:
    """What can be changed, of which."""
    joints, movable = hand.joint_names, hand.kinematics.movable
    tendons = hand.stiffness.names if isinstance(hand.stiffness, TendonStiffness) else ()
    links = tuple(dict.fromkeys((*hand.fingertips, *hand.description.has(COLLISION))))
    return {
        LENGTH: movable, AXIS: movable, POSITION: movable, STIFFNESS: joints, LIMIT: joints,
        MOTOR: tuple(dict.fromkeys((*joints, *tendons))), RADIUS: hand.fingertips, PAD: links,
    }  # fmt: skip


def _unknown(name: Any, of: str, what: str, known: Mapping[str, Sequence[str]]) -> UnknownName:
    """With the names that are near: of what exists with such a number, or the numbers that it has."""
    if what in known:
        return UnknownName("changes", f"a name with a {what}", [str(name)], [f"{one}.{what}" for one in known[what]])
    if numbers := [f"{of}.{number}" for number, names in known.items() if of in names]:
        return UnknownName("changes", f"a number of {of}", [str(name)], numbers)
    every = (*WHOLE, *[f"<name>.{number}" for number in known])
    return UnknownName(
        "changes", "an argument of Hand.replace, or a number of a joint or fingertip", [str(name)], every
    )
