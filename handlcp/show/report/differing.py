"""The numbers of a hand that a report compares: those that `vary` knows by name, and how its joints stand and turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.hand import Hand
from handlcp.hand.vary.hand_shape import AXIS, LENGTH, POSITION
from handlcp.hand.vary.vary import hand_numbers, number_unit

_NONE = "–"
_DIGITS = 9  # to which numbers are the same
Fact = tuple[Any, str]  # what is compared, and how it is shown


def differing(hands: Mapping[str, Hand]) -> list[tuple[str, ...]]:
    """A row for each number in which hands differ, with its value in each; names with the same values share a row."""
    facts = [dict(_facts(hand)) for hand in hands.values()]
    rows = dict[tuple[str, ...], list[str]]()
    for name in dict.fromkeys(name for found in facts for name in found):
        values = [found.get(name) for found in facts]
        if len({None if value is None else value[0] for value in values}) > 1:
            of, _, what = name.rpartition(".")
            cells = tuple([_NONE if value is None else value[1] for value in values])
            rows.setdefault((what, *cells), []).append(of)
    return [(f"{what.replace('_', ' ')} of {words.listed(of)}", *cells) for (what, *cells), of in rows.items()]


def _facts(hand: Hand) -> Iterator[tuple[str, Fact]]:
    """By name, such as "finger_1_distal.length"."""
    numbers, model = hand_numbers(hand), hand.model
    for name, value in numbers.items():
        yield name, (float(f"{value:.{_DIGITS}g}"), f"{value:.4g} {number_unit(name)}")
    data, q = pin.Data(model), pin.neutral(model)
    for joint in hand.kinematics.movable:
        k = model.getJointId(joint)
        place, parent = model.jointPlacements[k], model.names[model.parents[k]]
        size = float(np.linalg.norm(place.translation))
        led = f"{parent}.{LENGTH}" in numbers and size > 0.0  # its distance is the length of the joint before
        at = place.translation / size if led else place.translation
        yield f"{joint}.{POSITION}", (_rounded(at), f"{_vector(1e3 * place.translation)} mm")
        turn = np.degrees(pin.rpy.matrixToRpy(place.rotation))
        yield f"{joint}.roll, pitch, yaw", (_rounded(place.rotation.reshape(-1)), f"{_vector(turn)}°")
        axis = pin.computeJointJacobian(model, data, q, k)[:, model.joints[k].idx_v]
        yield f"{joint}.{AXIS}", (_rounded(axis), _vector(axis[3:] if axis[3:].any() else axis[:3]))
    for joint, low, high in zip(hand.joint_names, hand.lower.tolist(), hand.upper.tolist(), strict=True):
        yield f"{joint}.range", (_rounded(np.array([low, high])), f"{low:.4g} to {high:.4g}")


def _rounded(values: Any) -> tuple[float, ...]:
    return tuple((np.round(values, _DIGITS) + 0.0).tolist())


def _vector(values: Any) -> str:
    return f"({', '.join(f'{x:.4g}' for x in (np.round(values, 6) + 0.0).tolist())})"
