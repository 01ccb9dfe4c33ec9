"""Derivatives of what a design holds by its parameters, in the unit cube, and where there are none.

A factor ends a path: it is defined by the event there, so what is differentiated is the whole path of the load that
gives out, with the same grasp brought along. By central differences at two steps,

    a = [y(u + h) - y(u - h)] / 2h,    b = [y(u + h/2) - y(u - h/2)] / h,    y' = (4 b - a) / 3    h = 0.01

of which the error is of fourth order; at an end of a range by one-sided ones of second order likewise. Where a and b
differ by more than 1e-4, or the differences on the two sides do not approach each other, there is no derivative that is
sure: loads or causes change places, or contacts slide, which makes a path as rough as its steps are long. Then a is
used, and said to be rough.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.design.brief import WEIGHT_NAME, Brief
from handlcp.design.evaluate import evaluate_same_grasps
from handlcp.design.evaluation import Evaluation
from handlcp.design.judged import unloaded
from handlcp.design.sweep.work import FAILURES, Values, unpacked
from handlcp.errors import HandLCPError
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.continued import continued
from handlcp.studies.payload.largest_mass import unit_mass_loads

STEP = 0.01  # h, of the cube's side
SURE = 1e-4  # relative: how well the two steps agree where there is a derivative
_SIDES = 0.75  # of the gap between the sides at twice the step: half as much where there is a derivative
_GAP = 1e-3  # of the largest rate: sides that are nearer to each other than this are one
PAYLOAD, FACTOR = "payload", "factor"

# ----------------------------------------------------------------
# What a design holds, load by load: the numbers that the least is one of.


class Wanted(NamedTuple):
    """aim : "payload", of each weight [kg], or "factor", of each load; "" for neither. until : the largest that is told
    apart. loads : those that are asked for; None: all. numbers : names of an evaluation's numbers besides.
    """

    aim: str
    until: float
    loads: tuple[str, ...] | None
    numbers: tuple[str, ...]


def sample(maker: bytes, values: Values, near: bytes | None, wanted: Wanted) -> dict[str, float | None]:
    """In any process: what a design holds, with grasps brought along; None for what is not known, such as where a grasp
    is lost on the way.
    """
    made, start = unpacked(maker), None if near is None else unpacked(near)
    try:
        hand, brief = made.hand(values), made.asked(values)
        found = dict(_held(hand, brief, start, wanted)) if wanted.aim and wanted.loads != () else {}
        if wanted.numbers:
            whole = None if start is None else evaluate_same_grasps(hand, brief, start)
            lost = whole is None or len(whole.cases) < len(brief.objects)
            found |= {name: np.nan if lost else getattr(whole, name) for name in wanted.numbers}
    except FAILURES:
        return {}
    return {key: float(value) if np.isfinite(value) else None for key, value in found.items()}


def _held(hand: Any, brief: Brief, near: Evaluation | None, wanted: Wanted) -> Iterator[tuple[str, float]]:
    """Key and value of each load, up to `until`."""
    asked = {"friction": brief.friction, "gravity": (0.0, 0.0, -9.81), **brief.closing}
    for name, obj in brief.objects.items():
        there = None if near is None or name not in near.cases else near.cases[name].candidate
        one = None if there is None else continued(hand, obj, there, asked, brief.seed)
        if one is None:
            raise HandLCPError(f"the grasp of {name} is lost")
        yield from _of_loads(brief, name, obj.mass if wanted.aim == FACTOR else 1.0, one, wanted)


def _of_loads(
    brief: Brief, name: str, mass: float, one: Candidate, wanted: Wanted
) -> Iterator[tuple[str, float]]:  # fmt: skip
    pulls = unit_mass_loads(one.grasp, brief.acceleration) if mass else []
    loads = {f"{name}: {WEIGHT_NAME} {k + 1}": (spec, pull, mass) for k, (spec, pull) in enumerate(pulls)}
    if wanted.aim == FACTOR:
        loads |= {f"{name}: {load}": (one.grasp.spec, wrench, 1.0) for load, wrench in brief.loads.items()}
    befores = dict[int, Any]()
    for key, (spec, wrench, unit) in loads.items():
        if wanted.loads is not None and key not in wanted.loads:
            continue
        if id(spec) not in befores:
            befores[id(spec)] = unloaded(brief, spec)
        until = wanted.until * unit
        yield key, min(befores[id(spec)].limit(wrench, until).factor, until) / unit


# ----------------------------------------------------------------
# Differences.


class Slope(NamedTuple):
    """rate : by a coordinate of the cube. apart : by how much the two steps differ, relative. sides : differences ahead
    and behind; NaN beyond an end of the range. sure : whether there is a derivative.
    """

    rate: float
    apart: float
    sides: tuple[float, float]
    sure: bool


def places(u: float) -> list[float]:
    """Where along a coordinate samples are wanted, beside u itself."""
    if STEP <= u <= 1.0 - STEP:
        return [u + STEP, u - STEP, u + STEP / 2, u - STEP / 2]
    s = STEP if u < 0.5 else -STEP
    return [u + s, u + s / 2, u + s / 4]


def slope(u: float, here: float, there: Sequence[float]) -> Slope:
    """From y here and at `places`."""
    if len(there) == 3:
        h = STEP if u < 0.5 else -STEP
        far, middle, close = there
        a, b = (-3.0 * here + 4.0 * middle - far) / h, (-3.0 * here + 4.0 * close - middle) / (h / 2)
        ahead = (middle - here) / (h / 2)
        sides, bent = (ahead, np.nan) if h > 0 else (np.nan, ahead), False
    else:
        right, left, inner, other = there
        a, b = (right - left) / (2 * STEP), (inner - other) / STEP
        sides = (inner - here) / (STEP / 2), (here - other) / (STEP / 2)
        wide = (right - 2.0 * here + left) / STEP
        gap = abs(sides[0] - sides[1])
        bent = gap > max(_SIDES * abs(wide), _GAP * max(abs(sides[0]), abs(sides[1])))
    apart = abs(a - b) / max(abs(a), abs(b), 1e-300)
    sure = bool(apart <= SURE and not bent)
    return Slope((4.0 * b - a) / 3.0 if sure else a, float(apart), sides, sure)


class Gradient(NamedTuple):
    """values : key → y, NaN where it is not known. slopes : key → parameter → slope."""

    values: dict[str, float]
    slopes: dict[str, dict[str, Slope]]

    def rates(self, key: str, names: Sequence[str]) -> Array:
        """(d,) by these parameters; 0 where nothing is known."""
        own = self.slopes.get(key, {})
        return np.asarray(np.nan_to_num([own[name].rate if name in own else 0.0 for name in names]))


def gradient(
    names: Mapping[str, int], u: Array, samples: Mapping[tuple[int, float], Mapping[str, float | None]],
    here: Mapping[str, float | None], keys: Sequence[str],
) -> Gradient:  # fmt: skip
    """From samples by coordinate and place. names : parameter → coordinate. here : of the point itself."""

    def at(one: Mapping[str, float | None], key: str) -> float:
        value = one.get(key)
        return np.nan if value is None else float(value)

    slopes = {
        key: {
            name: slope(u[i], at(here, key), [at(samples[i, place], key) for place in places(u[i])])
            for name, i in names.items()
        }
        for key in keys
    }
    return Gradient({key: at(here, key) for key in keys}, slopes)
