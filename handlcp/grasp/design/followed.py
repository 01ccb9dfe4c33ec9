"""Whether a changed grasp holds when it is squeezed, then loaded: the least value of a change with which it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from handlcp.grasp.analysis.required import Required
from handlcp.grasp.answer.verdict import Verdict
from handlcp.grasp.assembly.build import build
from handlcp.grasp.design.closing_in import closed_in
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.check import STEPS, judged
from handlcp.lcp import Auto

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
