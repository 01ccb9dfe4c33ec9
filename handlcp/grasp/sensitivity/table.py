"""What matters most, in a table: what changes that a designer could make do to an answer, to first order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp.parameter import Shown, by_effort
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, Rates
from handlcp.text_table import TextTable, wrapped
from handlcp.words import first_largest

# ----------------------------------------------------------------
# Everything of an answer that can be differentiated, from the rates of its forces, motion and slips.


@dataclass(frozen=True, slots=True)
class Quantity:
    """unit : of the quantity. rate : (…, p) its rates. joints : whether only a hand has it."""

    unit: str
    rate: Callable[[Answer, Rates, Change], Array]
    joints: bool = False


def _points(answer: Answer, by_component: Array) -> Array:
    """(n, 3, p) of the contact points."""
    n = answer.scene.n
    return by_component[: 3 * n].reshape(n, 3, -1)


def _moments(answer: Answer, by_component: Array) -> Array:
    """(n, p) about the normals, 0 of contacts that bear no moment."""
    out = np.zeros((answer.scene.n, by_component.shape[1]))
    out[list(answer.scene.soft)] = by_component[3 * answer.scene.n :]
    return out


def _relative(answer: Answer, rates: Rates) -> Array:
    """(n, 3, p) motions of the object past the fingertips; 0 where a prescribed force makes the finger follow."""
    points = _points(answer, rates.slip)
    return points if all(answer.scene.governed) else np.where(answer.governed[:, None, None], points, 0.0)


def _torques(answer: Answer, rates: Rates, change: Change) -> Array:
    """τ = Jᵀ r + …"""
    return np.asarray(answer.torque_rows.T @ rates.forces + change.torque)


def _torque_margin(answer: Answer, rates: Rates, change: Change) -> Array:
    """Limit less |τ|; NaN of a joint without a limit."""
    mechanism = answer.spec.mechanism
    limits = np.zeros(0) if mechanism is None else mechanism.limits
    margin = change.torque_limits - np.sign(answer.joints.torque)[:, None] * _torques(answer, rates, change)
    return np.where(np.isfinite(limits)[:, None], margin, np.nan)


def _friction_margin(answer: Answer, rates: Rates, change: Change) -> Array:
    """μ r_N - |r̂_T|, of the exact law; NaN without friction. Without a tangential force any change takes from it."""
    scene, n = answer.scene, answer.scene.n
    lawful, out = rates.forces / answer.scale[:, None], np.full((n, rates.forces.shape[1]), np.nan)
    limits = answer.friction.limits
    for i in range(n):
        if scene.mu[i] <= 0.0:
            continue
        own = [3 * i, 3 * i + 1, *([3 * n + scene.soft.index(i)] if i in scene.soft else [])]
        r, z = answer.lawful[own], 3 * i + 2
        size = float(np.sqrt(r @ r))
        used = r @ lawful[own] / size if size > answer.weak else np.sqrt((lawful[own] ** 2).sum(axis=0))
        grows = change.friction[i] * (scene.mu[i] / limits[i] if limits[i] > 0.0 else 0.0)
        out[i] = scene.mu[i] * lawful[z] + grows * answer.lawful[z] - used
    return out


QUANTITIES = {
    "forces": Quantity("N", lambda a, r, c: _points(a, r.forces)),
    "torsion": Quantity("N·m", lambda a, r, c: _moments(a, r.forces)),
    "torques": Quantity("N·m", _torques, joints=True),
    "slip": Quantity("m", lambda a, r, c: _relative(a, r)[:, :2]),
    "gap": Quantity("m", lambda a, r, c: _relative(a, r)[:, 2]),
    "displacement": Quantity("m, rad", lambda a, r, c: r.motion),
    "friction_margin": Quantity("N", _friction_margin),
    "torque_margin": Quantity("N·m", _torque_margin, joints=True),
}


# ----------------------------------------------------------------

_NOTHING = 1e-3  # of the largest force
_ROUNDING = 1e-6  # of the largest number in a column


def what_matters(s: Any, answer: Answer) -> str:
    """Of a `Sensitivity`, and where its derivatives have two sides or none."""
    changes, least = _changes(s, answer), _least(answer)
    effects = [
        np.array([_effect(s.along(parameter, way).ahead, answer, least) for _, way in row.ways])
        for parameter, row in changes
    ]
    largest = np.nan_to_num(abs(np.concatenate(effects))).max(axis=0)
    scale, cells = np.where(largest > 0.0, largest, 1.0), []
    for (_, row), each in zip(changes, effects, strict=True):
        most = first_largest((np.nan_to_num(abs(each)) / scale).sum(axis=1))  # all columns count alike
        rounded = np.where(abs(each[most]) < _ROUNDING * scale, 0.0, each[most])
        cells.append((row.text, row.ways[most][0], *_written(rounded.tolist())))
    torque = ("torque\nN·m",) if "torques" in s.quantities else ()
    heads = ("change", "where", "force\nN", "to spare\nN", *torque, "motion\nmm")
    lines = [str(TextTable(heads, tuple(cells), "<<" + ">" * (len(heads) - 2)))]
    lines.append(wrapped(_legend(answer, least, bool(torque))))
    if kinks := [str(k) for k in s.kinks if not k.by]:  # of these rows
        lines.append(wrapped(f"Two sides, of which this is one: {'; '.join(kinks)}.", "  "))
    if s.free:
        count = f"{s.free} direction{'s' if s.free > 1 else ''}"
        lines.append(wrapped(f"Left free in {count}: – is what they change, or a change without an answer.", "  "))
    return "\n".join(lines)


def _legend(answer: Answer, least: int | None, torque: bool) -> str:
    """What the columns are."""
    spare = "no contact sticks with friction to spare"
    if least is not None:
        spare = f"the friction to spare at {answer.spec.names[least]}, of all that stick the nearest to sliding"
    more = ", the largest torque" if torque else ""
    single = "The last two rows are one contact each, where the change does most."
    return f"Changes of the largest force, {spare}{more}, and how far the object moves. {single}"


def _changes(s: Any, answer: Answer) -> list[tuple[str, Shown]]:
    """(parameter, what of it is shown), those first that take the least effort to change; single contacts last."""
    known = [(p.name, row) for p in by_effort() if (row := p.shown(answer)) is not None]
    some = [(name, row) for name, row in known if not (row.slight and _is_nothing(s, answer, name, row))]
    return sorted(some, key=lambda one: len(one[1].ways) > 1)


def _is_nothing(s: Any, answer: Answer, parameter: str, row: Shown) -> bool:
    """Whether a change matters to no force."""
    rates = [s.along(parameter, way).ahead["forces"] for _, way in row.ways]
    return bool(np.nanmax(np.abs(rates), initial=0.0) <= _NOTHING * abs(answer.forces).max())


def _effect(rate: dict[str, Array], answer: Answer, least: int | None) -> list[float]:
    """Of a change on the largest force, the margin of the contact with the least of it, the largest torque and the
    motion, in mm.
    """
    sizes = np.sqrt((answer.forces**2).sum(axis=1))
    i = first_largest(sizes)
    found = [float(answer.forces[i] @ rate["forces"][i] / sizes[i]) if sizes[i] > 0.0 else 0.0]
    found.append(np.nan if least is None else float(rate["friction_margin"][least]))
    if "torques" in rate:
        torque = answer.joints.torque
        j = first_largest(abs(torque))
        found.append(float(np.sign(torque[j]) * rate["torques"][j]))
    moved = rate["displacement"][:3]
    return [*found, 1e3 * float(np.sqrt(moved @ moved))]


def _least(answer: Answer) -> int | None:
    """The contact that presses and sticks with the least margin; None where none does."""
    scene, lawful = answer.scene, answer.lawful
    margins = np.full(scene.n, np.inf)
    for i in range(scene.n):
        push = lawful[3 * i + 2]
        own = [int(j) for j in scene.kind.contact_components[i, 1:] if j >= 0]
        spare = scene.mu[i] * push - float(np.sqrt(lawful[own] @ lawful[own]))
        if own and push > answer.weak and spare > answer.weak:
            margins[i] = spare
    return first_largest(-margins) if np.isfinite(margins).any() else None


def _written(effect: list[float]) -> list[str]:
    """Three digits, all but the motion with a sign; – for what is no number."""
    *signed, moved = effect
    return [*(_number(x, "+.3g") for x in signed), _number(moved, ".3g")]


def _number(x: float, form: str) -> str:
    return "–" if not np.isfinite(x) else "0" if x == 0.0 else f"{x:{form}}"
