"""The least squeeze or friction that holds, closed in from both sides and judged by `check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from handlcp.errors import Unsupported
from handlcp.grasp.analysis.required import Required, required_friction, required_preload
from handlcp.grasp.answer.verdict import Verdict
from handlcp.grasp.assembly.build import build
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.friction import with_friction
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.check import STEPS, judged
from handlcp.lcp import Auto
from handlcp.progress import told

# ----------------------------------------------------------------
# The least value that holds, closed in on from a value that should be near it.
#
# Whether a grasp holds need not be monotone: a stronger grip can push the object away. So the search goes from where it
# starts, down while it holds or up while it does not, in steps that double, and then halves what is left. What comes
# back holds, and a tolerance less does not. Another window further away may have been missed.

Test = Callable[[float], bool]

_LOOKS = 8  # for a value that is not too much, and between one that is and one that is too little
_NONE = 1e-9  # of the start: less is nothing


def closed_in(
    holds: Test, start: float, most: float, tolerance: float, too_much: Test = lambda x: False, least: float = 0.0
) -> tuple[float | None, float]:
    """(value, fails): the least value that holds and the largest tried below it that does not; twice `least` where even
    that holds; (None, x) where no value was found, x being the last that was not too much.

    start : > 0. least, most : the smallest and the largest that are tried. tolerance : of the value. too_much : whether
    a value fails because it is too large, asked of those that do not hold.
    """
    for _ in range(_LOOKS):
        if holds(start) or not too_much(start):
            break
        start *= 0.5
    low, high = _down(holds, start, least, tolerance) if holds(start) else _up(holds, start, most, tolerance, too_much)
    if high is None or high == least:
        return high, low
    while high - low > max(tolerance * high, _NONE * start):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high, low


def _down(holds: Test, start: float, least: float, step: float) -> tuple[float, float]:
    """A value that does not hold below one that does."""
    low, high = start, start
    while True:
        low, high, step = max(start * (1.0 - step), least), low, 2.0 * step
        if not holds(low):
            return low, high
        if low == least:
            return least, least


def _up(holds: Test, start: float, most: float, step: float, too_much: Test) -> tuple[float, float | None]:
    low = start
    while low < most:
        high, step = min(start * (1.0 + step), most), 2.0 * step
        if holds(high):
            return low, high
        if too_much(high):
            return _between(holds, low, high, too_much)
        low = high
    return low, None


def _between(holds: Test, low: float, high: float, too_much: Test) -> tuple[float, float | None]:
    """Between a value that is too little and one that is too much."""
    for _ in range(_LOOKS):
        middle = 0.5 * (low + high)
        if holds(middle):
            return low, middle
        low, high = (low, middle) if too_much(middle) else (middle, high)
    return low, None


# ----------------------------------------------------------------
# Whether a changed grasp holds when it is squeezed, then loaded: the least value of a change with which it does.

ORDER = ("squeeze", "load")
_CHAIN = Auto(search_seconds=0.0)


@dataclass(eq=False)
class Changed:
    """A grasp whose one number is changed, and what became of it under loading. make : the grasp with that number.
    paths : by number, in the order tried.
    """

    make: Callable[[float], GraspSpec]
    section: Section
    paths: dict[float, Loading] = field(default_factory=dict)

    def path(self, x: float) -> Loading:
        """The loading with this number, as `check` follows it. Raises Unsupported."""
        if x not in self.paths:
            self.paths[x] = follow(self.make(x), self.section, None, ORDER, None, STEPS, None)
        return self.paths[x]

    def holds(self, x: float) -> bool:
        """Whether the end is reached."""
        return self.path(x).held

    def too_much(self, x: float) -> bool:
        """Whether the object is lost before the load comes."""
        path = self.path(x)
        return not path.reached and path.lost_stage == ORDER[0]


@told("looking for the least value")
def least_value(changed: Changed, start: float, most: float, tolerance: float, unit: str) -> Required:
    """The least number with which the grasp holds to the end of its loading, to a relative tolerance, and what `check`
    says of it. start : near it, > 0.
    """
    value, fails = closed_in(changed.holds, start, most, tolerance, changed.too_much)
    checked = tuple([(x, path.held) for x, path in changed.paths.items()])
    below = None if value == 0.0 else fails
    found = Required(value, below, False, unit, most, tolerance, checked)
    if value is None:
        return replace(found, hint=changed.path(fails).why)
    return replace(found, verdict=word(changed.make(value), changed.section))


def verdict_on(spec: GraspSpec, section: Section) -> Verdict:
    """What `check` says of a grasp, without advice."""
    return judged(spec, build(spec), section, ORDER, solve_spec(spec, section, _CHAIN, proof=False))


def word(spec: GraspSpec, section: Section) -> str:
    """Its word."""
    return verdict_on(spec, section).word


# ----------------------------------------------------------------
# Least friction and least preload: found by single solves, then judged as `check` does, by following the loading.

_LITTLE = 1e-3  # of the largest value tried: where the search starts that single solves say needs nothing


def confirmed_friction(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """See `Grasp.required_friction`."""
    found = required_friction(spec, section, tolerance)
    return _confirmed(found, lambda mu: with_friction(spec, mu), section)


def confirmed_preload(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """See `Grasp.required_preload`."""
    found = required_preload(spec, section, tolerance)
    return _confirmed(found, spec.squeezed, section)


@told("looking for the least value")
def _confirmed(found: Required, make: Callable[[float], GraspSpec], section: Section) -> Required:
    """The same with what `check` says of it. Where contacts move as the hand does, what `check` says counts: unless
    the grasp holds at the value, and not below, it is searched for anew from there, by following.
    """
    if found.value is None:
        return found
    changed = Changed(make, section)
    try:
        there = changed.path(found.value)
    except Unsupported:  # such as known forces
        return found
    agrees = there.held and (found.fails is None or not changed.holds(found.fails))
    if agrees or not there.steps.geometry.follows:
        return replace(found, verdict=word(make(found.value), section))
    start = found.value or _LITTLE * found.limit
    again = least_value(changed, start, found.limit, found.tolerance, found.unit)
    return replace(again, checked=(*found.checked, *again.checked))
