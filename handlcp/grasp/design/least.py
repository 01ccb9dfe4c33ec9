"""The least squeeze or friction that holds, closed in from both sides and judged by `check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from handlcp.errors import Unsupported
from handlcp.grasp.analysis.least import least
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
    one = least(changed.holds, start, most, tolerance, too_much=changed.too_much)
    checked = tuple([(x, path.held) for x, path in changed.paths.items()])
    found = Required(one.value, one.fails, False, unit, most, tolerance, checked)
    if one.value is None:
        return replace(found, hint="" if one.fails is None else changed.path(one.fails).why)
    return replace(found, verdict=word(changed.make(one.value), changed.section))


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
