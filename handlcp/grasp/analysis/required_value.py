"""`find_least`: the least number with which something holds, closed in on from both sides.

Whether a grasp holds need not be monotone in a number: a stronger grip can push the object away, more friction can let
an equilibrium vanish. So the search goes from where it starts, down while it holds or up while it does not, in steps
that double, and then halves what is left. What comes back holds, and a tolerance less does not; both were asked.
Another window farther away may have been stepped over.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from handlcp.check import check_method_calls, check_number
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.parameter.contact import with_friction
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.verdict import HELD
from handlcp.grasp.solve.solve_spec import BRIEF_SEARCH_WORK, solve_spec
from handlcp.grasp.verify.load_capacity import find_escape_twist, prove_overload
from handlcp.lcp import Auto
from handlcp.record import Record, make_data_frame
from handlcp.words import wrap_text

HoldsTest = Callable[[float], bool]

_MAX_LOOKS = 8  # for a value that is not too much, and between one that is and one that is too little
_ZERO_SHARE = 1e-9  # of the start: less is nothing


@check_method_calls
@dataclass(frozen=True, slots=True)
class Required(Record):
    """The smallest common value that holds.

    value : it holds (certified); 0 when nothing more is needed; None when nothing up to `limit` was found to hold.
    fails : the largest value tried below `value` that does not hold, value - fails ≤ tolerance · value or, for a
        tolerance finer than that, one rounding step; None when value is 0.
    proven : whether below `value` nothing can hold, because no force in the friction cones balances the load there
        (or, where value is None, at any value). Otherwise `fails` only means that no equilibrium was found.
    unit : "m" of squeeze, "N" of grip or "" for a friction coefficient. limit : largest value that would be tried.
    tolerance : relative.
    checked : ((value, whether it holds), …) in the order tried.
    hint : what to change instead where value is None; what less or more does where more does not always hold better;
    "" if nothing is known.
    verdict : the word of `check()` at `value`, where the loading is followed; "" where it was not asked. What prints
        begins with it unless it is HELD.
    """

    value: float | None
    fails: float | None
    proven: bool
    unit: str
    limit: float
    tolerance: float
    checked: tuple[tuple[float, bool], ...] = field(repr=False)
    hint: str = ""
    verdict: str = ""

    def to_frame(self) -> Any:
        """A pandas table of the values tried, in their order: "value", "holds". Raises Unsupported without pandas."""
        return make_data_frame({name: [pair[k] for pair in self.checked] for k, name in enumerate(("value", "holds"))})

    def __str__(self) -> str:
        if self.value is None:
            if self.proven:
                return "no value found that holds: no force within friction and limits balances the load"
            none = f"no value up to {self._format_value(self.limit)} found that holds"
            return wrap_text(f"{none}: {self.hint}" if self.hint else none, "  ")
        bare = "nothing added" if self.unit else "no friction"
        value = self._format_value(self.value) if self.value > 0.0 else bare
        if self.verdict == HELD:
            text = f"{value} holds" if self.value > 0.0 else f"holds with {bare}"
        elif self.verdict:
            text = f"{self.verdict}: check() says so of the grasp with {value}, the least found"
        else:
            text = f"NOT FOLLOWED: one solve holds with {value}, and check() was not asked"
        if self.fails is not None and self.value > 0.0:
            text += f"{', ' if self.verdict == HELD else '; '}{self._format_value(self.fails)} does not"
            text += "" if self.verdict == HELD else " hold"
        return wrap_text("; ".join([part for part in (text, self.hint) if part]), "  ")

    def _format_value(self, value: float) -> str:
        """A coefficient, newtons, or a squeeze in millimetres, with digits enough to tell the two values apart."""
        if self.unit != "m":
            return f"{value:.4g} {self.unit}".rstrip()
        size, unit = (1e6, "µm") if 0.0 < value < 1e-4 else (1e3, "mm")
        return f"{size * value:.4g} {unit}"


class _LeastSearch:
    """Asks, and remembers what it has asked. too_much : whether a value fails because it is too large."""

    def __init__(self, holds: HoldsTest, too_much: HoldsTest, tolerance: float) -> None:
        self.holds, self.too_much, self.tolerance = holds, too_much, tolerance
        self.tried: list[tuple[float, bool]] = []

    def __call__(self, x: float) -> bool:
        self.tried.append((x, bool(self.holds(x))))
        return self.tried[-1][1]

    def step_down(self, start: float, floor: float, step: float) -> tuple[float | None, float]:
        """(a value that does not hold, one above it that does); (None, floor) where the floor holds."""
        high = start
        while high > floor:
            low, step = max(start - step, floor), 2.0 * step
            if not self(low):
                return low, high
            high = low
        return None, floor

    def step_up(self, start: float, most: float, step: float) -> tuple[float, float | None]:
        """Double the step until a value holds: (a value that does not hold, one above it that does); None: nothing
        up to `most` does.
        """
        low = start
        while low < most:
            high, step = min(start + step, most), 2.0 * step
            if self(high):
                return low, high
            if self.too_much(high):
                for _ in range(_MAX_LOOKS):  # what holds lies between too little and too much
                    middle = 0.5 * (low + high)
                    if self(middle):
                        return low, middle
                    low, high = (low, middle) if self.too_much(middle) else (middle, high)
                return low, None
            low = high
        return low, None

    def bisect(self, low: float, high: float, nothing: float = 0.0) -> tuple[float, float]:
        """The same as close as the tolerance, or to neighbouring floats."""
        while high - low > max(self.tolerance * high, nothing):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            low, high = (low, middle) if self(middle) else (middle, high)
        return low, high


def find_least(
    holds: HoldsTest,
    start: float,
    most: float,
    tolerance: float,
    *,
    step: float | None = None,
    floor: float = 0.0,
    too_much: HoldsTest = lambda x: False,
    sure: HoldsTest | None = None,
) -> Required:
    """The least value that holds, to a relative tolerance: value - fails ≤ tolerance · value, or one rounding step; its
    unit is the caller's to say.

    start : where the search begins, near the answer if that is known. floor, most : the least and the largest tried.
    step : of the first step; None: the tolerance times the start. too_much : asked of values that do not hold.
    sure : asked once more where the answer hangs on a "no" of `holds`, such as a slower test; where it says yes, the
    search goes on down with it. Where none holds, `fails` is the last that was not too much.
    """
    search = _LeastSearch(holds, too_much, tolerance)
    first = tolerance * start if step is None else step
    for _ in range(_MAX_LOOKS):
        if search(start) or not too_much(start):
            break
        start *= 0.5
    low: float | None
    low, high = search.step_down(start, floor, first) if search.tried[-1][1] else search.step_up(start, most, first)
    if low is not None and high is not None:
        low, high = search.bisect(low, high, _ZERO_SHARE * start)
    if sure is not None and low is not None:
        search.holds = sure
        if search(low):
            low, high = search.step_down(low, floor, tolerance * low)
            if low is not None:
                low, high = search.bisect(low, high)
    return Required(floor if low is None else high, low, False, "", most, tolerance, tuple(search.tried))


# ----------------------------------------------------------------
# How much squeeze, or how much friction, it takes: the smallest common value that holds, found by certified solves.
#
# The search (`least`) goes upwards from the least value that could hold. What comes back holds; the value a tolerance
# below it does not, as `Grasp.solve` says.


HoldsGrasp = Callable[[GraspSpec, Section], bool]

BRIEF_CHAIN = Auto(search_work=BRIEF_SEARCH_WORK)
_FIRST_STEP = 2.0**-10  # of the natural size: the first step upwards
_MAX_COEFFICIENT = 10.0  # the largest coefficient that is tried


def is_held(spec: GraspSpec, section: Section) -> bool:
    """Whether the solver chain, with a brief search, finds an equilibrium that the certifier passes."""
    return solve_spec(spec, section, BRIEF_CHAIN).held


def is_surely_held(spec: GraspSpec, section: Section) -> bool:
    """The same with all the time that `Grasp.solve` takes."""
    return solve_spec(spec, section).held


def required_preload(
    spec: GraspSpec,
    section: Section,
    tolerance: float = 1e-3,
    limit: float | None = None,
    test: HoldsGrasp = is_held,
    sure: HoldsGrasp = is_surely_held,
) -> Required:
    """The smallest squeeze [m] that, added to every finger whose force is not prescribed, makes the grasp hold.

    limit : largest squeeze tried [m]; None: 10⁴ natural motions, the fingers' mean deflection under the load (rigid
        fingers: the size of the grasp). test : whether a grasp holds; sure : asked where the answer hangs on a "no".

    Squeeze changes no friction cone: where no force in them balances the load, none is enough, and that is proven.
    """
    tolerance, size = check_tolerance(tolerance), build_scene(spec).units.motion_unit
    most = 1e4 * size if limit is None else check_number("limit", limit, above=0.0)
    if _is_proven_to_escape(spec, section):
        return Required(None, None, True, "m", most, tolerance, ())
    tests = [lambda x, t=t: t(spec.with_squeeze(x), section) for t in (test, sure)]
    found = find_least(tests[0], 0.0, most, tolerance, step=_FIRST_STEP * size, sure=tests[1])
    return replace(found, unit="m")


def required_friction(
    spec: GraspSpec,
    section: Section,
    tolerance: float = 1e-3,
    limit: float | None = None,
    test: HoldsGrasp = is_held,
    sure: HoldsGrasp = is_surely_held,
) -> Required:
    """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds.

    limit : largest coefficient tried, 10 when None. test, sure : as in `required_preload`.

    Friction cones grow with μ, so whether some force balances the load is monotone: bisection on that gives a lower
    bound that is proven, and the search for an equilibrium starts there.
    """
    tolerance = check_tolerance(tolerance)
    most = _MAX_COEFFICIENT if limit is None else check_number("limit", limit, above=0.0)
    if _is_proven_to_escape(with_friction(spec, most), section):
        return Required(None, None, True, "", most, tolerance, ())
    low, high = 0.0, most if _is_proven_to_escape(with_friction(spec, 0.0), section) else 0.0
    while high - low > 0.25 * tolerance * high:
        middle = math.sqrt(low * high) if low > 0.0 else (high / 16 if high > 1e-9 else 0.0)
        if not low < middle < high:  # a tolerance finer than floats can be halved
            break
        low, high = (middle, high) if _is_proven_to_escape(with_friction(spec, middle), section) else (low, middle)
    step = max(0.25 * tolerance * high, 1e-6)
    tests = [lambda x, t=t: t(with_friction(spec, x), section) for t in (test, sure)]
    found = find_least(tests[0], high, most, tolerance, step=step, floor=high, sure=tests[1])
    if found.value is not None and found.value == high > 0.0:  # the first value tried holds, and below nothing can
        return replace(found, fails=low, proven=True)
    if found.value is None and (build_scene(spec).offset[2 : 3 * spec.n : 3][spec.free_fingers] >= 0.0).all():
        return replace(found, hint="no finger squeezes the object; required_preload() says how much would do")
    return found


def _is_proven_to_escape(spec: GraspSpec, section: Section) -> bool:
    """Whether it is proven that no force within friction, and within what effects limit, balances the load."""
    scene = build_scene(spec)
    return find_escape_twist(scene, section) is not None or prove_overload(scene, section, spec.effects) is not None


def check_tolerance(value: Any) -> float:
    """A relative tolerance, above 0 and below 1. Raises InputError."""
    tolerance = check_number("tolerance", value, above=0.0)
    if tolerance >= 1.0:
        raise InputError("tolerance", "a relative tolerance below 1", value)
    return tolerance
