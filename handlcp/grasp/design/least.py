"""The least squeeze or friction that holds, closed in from both sides and judged by `check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp.analysis.least import least
from handlcp.grasp.analysis.required import Required, required_friction, required_preload
from handlcp.grasp.answer.verdict import NOT_HELD, UNDECIDED, Verdict
from handlcp.grasp.assembly.build import build
from handlcp.grasp.design.pressed import pressed
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.friction import with_friction
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.check import STEPS, followed_to, judged
from handlcp.lcp import Auto
from handlcp.progress import told

# ----------------------------------------------------------------
# Whether a changed grasp holds when it is squeezed, then loaded: the least value of a change with which it does.

ORDER = ("squeeze", "load")
_HALVINGS = 8
_CHAIN = Auto(search_seconds=0.0)


@dataclass(eq=False)
class Changed:
    """A grasp whose one number is changed, and what became of it under loading. make : the grasp with that number.
    stays : whether an object that snaps to another place does not count as held. paths : by number, in the order tried.
    """

    make: Callable[[float], GraspSpec]
    section: Section
    stays: bool = False
    paths: dict[float, Loading] = field(default_factory=dict)

    def path(self, x: float) -> Loading:
        """The loading with this number, as `check` follows it. Raises Unsupported."""
        if x not in self.paths:
            self.paths[x] = follow(self.make(x), self.section, None, ORDER, None, STEPS, None)
        return self.paths[x]

    def holds(self, x: float) -> bool:
        """Whether the end is reached, in STEPS steps a stage."""
        return self._kept(self.path(x))

    def surely(self, x: float) -> bool:
        """The same with as many steps as `check` takes, where fewer end differently."""
        path, agree = followed_to(self.make(x), self.section, ORDER)
        return agree and self._kept(path)

    def _kept(self, path: Loading) -> bool:
        return path.held and not (self.stays and snaps(path))

    def too_much(self, x: float) -> bool:
        """Whether the object is lost before the load comes."""
        path = self.path(x)
        return not path.reached and path.lost_stage == ORDER[0]


@told("looking for the least value")
def least_value(
    changed: Changed, start: float, most: float, tolerance: float, unit: str, bears: Array | None = None
) -> Required:  # fmt: skip
    """The least number with which the grasp holds to the end of its loading, to a relative tolerance, and what `check`
    says of it. Where that is that it does not hold, since more steps end differently, `check` is asked from there on.
    start : near it, > 0. bears (n,) : how hard contacts may press on the way [N]; None: as hard as they do.
    """
    found = _held(changed, start, most, tolerance, unit)
    return found if bears is None or found.value is None else _borne(changed, found, bears)


def _held(changed: Changed, start: float, most: float, tolerance: float, unit: str) -> Required:
    one = least(changed.holds, start, most, tolerance, too_much=changed.too_much)
    found = Required(one.value, one.fails, False, unit, most, tolerance, one.tried)
    if one.value is None:
        return replace(found, hint="" if one.fails is None else changed.path(one.fails).why)
    found = replace(found, verdict=word(changed.make(one.value), changed.section))
    if found.verdict not in (NOT_HELD, UNDECIDED) or changed.surely(one.value):
        return found
    more = least(changed.surely, one.value, most, tolerance, too_much=changed.too_much)
    if more.value is None:
        return replace(found, checked=(*one.tried, *more.tried))
    verdict = word(changed.make(more.value), changed.section)
    return replace(found, value=more.value, fails=more.fails, checked=(*one.tried, *more.tried), verdict=verdict)


def _borne(changed: Changed, found: Required, bears: Array) -> Required:
    """The same where no contact presses too hard. More presses harder, so that else only numbers between the one that
    holds and the one that does not are looked at.
    """
    assert found.value is not None
    low, high, checked = found.fails or 0.0, found.value, list(found.checked)
    if not pressed(changed.path(high), bears):
        return found
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        held = changed.holds(middle)
        hard = held and bool(pressed(changed.path(middle), bears))
        checked.append((middle, held and not hard))
        if held and not hard:
            verdict = word(changed.make(middle), changed.section)
            return replace(found, value=middle, fails=low, checked=tuple(checked), verdict=verdict)
        low, high = (low, middle) if hard else (middle, high)
    hint = f"with {high:.4g} {found.unit} {pressed(changed.path(high), bears)}"
    if found.fails is not None:
        hint = f"with less than {high:.4g} {found.unit} the object is not held, and {hint}"
    return replace(found, value=None, fails=low, checked=tuple(checked), hint=hint, verdict="")


def snaps(path: Loading) -> bool:
    """Whether the object leaves its place on the way, and comes to rest elsewhere."""
    return any(e.kind == "snaps" for e in path.events)


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
    found, own = required_friction(spec, section, tolerance), {c.mu for c in spec.contacts if c.mu > 0.0}
    return _confirmed(found, lambda mu: with_friction(spec, mu), section, own.pop() if len(own) == 1 else None)


def confirmed_preload(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """See `Grasp.required_preload`."""
    found = required_preload(spec, section, tolerance)
    return _confirmed(found, spec.squeezed, section, None)


@told("looking for the least value")
def _confirmed(
    found: Required, make: Callable[[float], GraspSpec], section: Section, own: float | None
) -> Required:  # fmt: skip
    """The same with what `check` says of it. Where contacts move as the hand does, what `check` says counts: unless
    the grasp holds at the value, and not below, it is searched for anew from there, by following.

    own : the value that the grasp has. Where the one found is less, and the object is held after it has gone to another
    place, which it does not with its own, the least is searched for that keeps it where it is: from its own value.
    """
    if found.value is None:
        return found
    changed, start = Changed(make, section), found.value or _LITTLE * found.limit
    try:
        there = changed.path(found.value)
    except Unsupported:  # such as known forces
        return found
    now = changed.path(own) if own is not None and own > found.value else there
    if own is not None and snaps(there) and not (now.held and snaps(now)):
        changed.stays, start = True, max(own, found.value)
    agrees = changed.holds(found.value) and (found.fails is None or not changed.holds(found.fails))
    if agrees or not there.steps.geometry.follows:
        return replace(found, verdict=word(make(found.value), section), hint=_more_loses(own, there, now))
    again = least_value(changed, start, found.limit, found.tolerance, found.unit)
    again = replace(again, checked=(*found.checked, *again.checked))
    if not (changed.stays and there.held):
        return again if again.value is None else replace(again, hint=_more_loses(own, changed.path(again.value), now))
    elsewhere = f"with {found.value:.4g} it snaps to another place, and is held there"
    return replace(again, hint="; ".join([text for text in (again.hint, elsewhere) if text]))


def _more_loses(own: float | None, there: Loading, now: Loading) -> str:
    """Of a grasp that holds with less than its own value, and not with that; "" of others."""
    if now is there or now.held or not there.held:
        return ""
    return f"with its own {own:.4g} the grasp does not hold: more is not always better"
