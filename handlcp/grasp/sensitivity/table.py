"""What matters most, in a table: what changes that a designer could make do to an answer, to first order."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.text_table import TextTable, wrapped

__all__ = ["what_matters"]

_SHARE = 0.1
_SHIFT, _TURN = 1e-3, np.radians(1.0)


def what_matters(s: Any, answer: Answer) -> str:
    """Of a `Sensitivity`, and where its derivatives have two sides or none."""
    cells = []
    for name, parameter, ways in _changes(s, answer):
        effects = [_effect(s.along(parameter, way).ahead, answer) for _, way in ways]
        most = max(range(len(ways)), key=lambda k: _weight(effects[k]))
        cells.append((name, ways[most][0], *_written(effects[most])))
    torque = ("torque\nN·m",) if "torques" in s.quantities else ()
    heads = ("change", "where most", "force\nN", "margin\nN", *torque, "motion\nmm")
    lines = [str(TextTable(heads, tuple(cells), "<<" + ">" * (len(heads) - 2))), _LEGEND]
    if s.kinks:
        lines.append(wrapped(f"Two sides, of which this is one: {'; '.join(map(str, s.kinks))}.", "  "))
    if s.free:
        count = f"{s.free} direction{'s' if s.free > 1 else ''}"
        lines.append(wrapped(f"Left free in {count}: – is what they change, or a change without an answer.", "  "))
    return "\n".join(lines)


_LEGEND = "Changes of the largest force, the least friction margin, the largest torque and\nthe object's place."


def _changes(s: Any, answer: Answer) -> list[tuple[str, str, list[tuple[str, Array]]]]:
    """(words, parameter, directions by where they are) of each row."""
    spec, n, hand = answer.spec, answer.scene.n, "torques" in s.quantities
    out = [("load +10 %", "wrench", [("", _SHARE * spec.wrench)])]
    squeeze = np.where(spec.offset[:, 2] < 0.0, -_SHARE * spec.offset[:, 2], 0.0)
    if squeeze.any():
        out.append(("squeeze +10 %", "squeeze", [("all", squeeze)]))
    if hand and answer.command.any():
        out.append(("command +10 %", "joint_offset", [("all", _SHARE * answer.command)]))
    if hand and answer.elastic_joints:
        C = np.diagonal(answer.compliance)
        out.append(("stiffness +10 %", "stiffness", [("all", _SHARE / np.where(C > 0.0, C, np.inf))]))
    mu, one = np.array([c.mu for c in spec.contacts]), np.eye(n)
    rough = np.flatnonzero((mu > 0.0) & (np.array(answer.scene.kind.tangents) > 0)).tolist()
    if rough:
        out.append(("friction -10 %", "friction", [(spec.names[i], -_SHARE * mu[i] * one[i]) for i in rough]))
    fingers = range(spec.of_fingers)
    aside = [(spec.names[i], _SHIFT * np.outer(one[i], spec.frames[i, :, a])) for i in fingers for a in (0, 1)]
    tilts = [(spec.names[i], _TURN * np.outer(one[i], np.eye(3)[a])) for i in fingers for a in (0, 1)]
    return [*out, ("1 mm aside", "positions", aside), ("normal by 1°", "normals", tilts)]


def _weight(effect: list[float]) -> float:
    """How much an effect counts: the larger of its force and its margin."""
    return float(np.nanmax([0.0, *(abs(x) for x in effect[:2])]))


def _effect(rate: dict[str, Array], answer: Answer) -> list[float]:
    """Of a change on the largest force, the least margin of friction, the largest torque and the motion, in mm."""
    sizes = np.sqrt((answer.forces**2).sum(axis=1))
    i = int(sizes.argmax())
    found = [float(answer.forces[i] @ rate["forces"][i] / sizes[i]) if sizes[i] > 0.0 else 0.0]
    found.append(_least_margin(rate["friction_margin"], answer))
    if "torques" in rate:
        torque = answer.joints.torque
        j = int(abs(torque).argmax())
        found.append(float(np.sign(torque[j]) * rate["torques"][j]))
    moved = rate["displacement"][:3]
    return [*found, 1e3 * float(np.sqrt(moved @ moved))]


def _least_margin(rate: Array, answer: Answer) -> float:
    """Of the contact that presses and sticks with the least of it; NaN where none does."""
    scene, lawful = answer.scene, answer.lawful
    margins = np.full(scene.n, np.inf)
    for i in range(scene.n):
        push = lawful[3 * i + 2]
        own = [int(j) for j in scene.kind.contact_components[i, 1:] if j >= 0]
        spare = scene.mu[i] * push - float(np.sqrt(lawful[own] @ lawful[own]))
        if own and push > answer.weak and spare > answer.weak:
            margins[i] = spare
    least = int(margins.argmin())
    return float(rate[least]) if np.isfinite(margins[least]) else np.nan


def _written(effect: list[float]) -> list[str]:
    """Three digits, all but the motion with a sign; 0 for rounding, – for what is no number."""
    *signed, moved = effect
    return [*(_number(x, "+.3g") for x in signed), _number(moved, ".3g")]


def _number(x: float, form: str) -> str:
    return "–" if not np.isfinite(x) else "0" if abs(x) < 1e-9 else f"{x:{form}}"
