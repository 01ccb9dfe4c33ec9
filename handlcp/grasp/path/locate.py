"""Where inside a step a contact changes its state: one root finder on margins."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.state import OPEN, SLIDES, Failure, State
from handlcp.grasp.path.step import Stepper

_NEAR = 1e-3  # of a step: a change this close is where it is looked for
_TRIES = 8


def margins(stepper: Stepper, state: State) -> Array:
    """(n, 2) of each contact: how far it is from sliding and from opening, in newtons; below 0, what it has slid and
    opened in the step, as the force that would take it back.
    """
    k = stepper.stiffness
    read, limits = state.read, stepper.friction
    forces, slid = read.forces, state.slid
    lever = stepper.lever
    tangential = np.sqrt((forces[:, 0] ** 2 + forces[:, 1] ** 2) + (read.torsion * lever) ** 2)
    normal, gap = forces[:, 2], np.maximum(read.motion[:, 2], 0.0)
    slip = np.sqrt(slid[:, 0] ** 2 + slid[:, 1] ** 2 + (slid[:, 2] * stepper.length) ** 2)
    slides = np.array([kind == SLIDES for kind in state.kinds])
    opened = np.array([kind == OPEN for kind in state.kinds])
    friction = np.where(slides, -k * slip, np.maximum(limits * normal - tangential, 0.0))
    return np.column_stack([np.where(opened, np.inf, friction), np.where(opened, -k * gap, normal)])


def first_change(
    stepper: Stepper, state: State, found: State, at: Callable[[float], State | Failure]
) -> tuple[float, State]:
    """The part of a step up to just behind the first change of a contact that held, and the state there; 1 and the
    step's end where none changes. at : the state at a part of the step.
    """
    low, high, best = 0.0, 1.0, found
    if state.kinds == found.kinds:
        return high, best
    a, b = margins(stepper, state), margins(stepper, found)
    rate: Array | None = None  # of margins, where the contact still holds
    for _ in range(_TRIES):
        changed = (a > 0.0) & (b < 0.0) & np.isfinite(a)
        if not changed.any() or high - low < _NEAR:
            break
        falls = (a[changed] - b[changed]) / (high - low) if rate is None else rate[changed]
        ahead = a[changed] / np.where(falls > 0.0, falls, np.inf)
        ahead = np.where(falls > 0.0, ahead, 0.5 * (high - low))
        part = min(low + float(ahead.min()), high) + 0.2 * _NEAR
        if high - part < _NEAR:
            break
        middle = at(part)
        if isinstance(middle, Failure):
            break
        m = margins(stepper, middle)
        if ((a > 0.0) & (m < 0.0) & np.isfinite(a)).any():
            high, best, b = part, middle, m
        else:
            with np.errstate(invalid="ignore"):
                rate = (a - m) / (part - low)
            low, a = part, m
    return high, best
