"""How much load a grasp holds in one direction, what gives out there, and what happened on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from handlcp import words
from handlcp.check import Array, check_method_calls, read_only
from handlcp.grasp.derivatives.path_sensitivity import PathSensitivity
from handlcp.grasp.failure.failure_mode import Bind
from handlcp.grasp.failure.failure_text import describe_event
from handlcp.grasp.path.events import jump
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.lazy_property import lazy_property
from handlcp.record import Record
from handlcp.words import wrap_text

_CALLED = {
    "first_slip": "first slip at", "slides": "slid as far as it may at", "lost": "lost at", "limit": "limit reached at",
    "undecided": "undecided beyond",
}  # fmt: skip
_SAME = 1e-6  # factors that differ by less are the same


@dataclass(frozen=True, slots=True)
class LimitEvent(Record):
    """What happens while the load grows. kind : "slips", "sticks", "opens", "touches" (a contact), "yields", "holds"
    (what is limited, such as a joint with `TorqueSaturation`), "slides" (a contact that has slid as far as it may),
    "snaps" (the object, which ends the path). who : its name.
    factor : on the load, when it happens. moved [m], turned [rad] : how far the object snaps. pushed (6,) : as in
    `Event`.
    """

    entries = ("kind", "who", "factor")

    kind: str
    who: str
    factor: float
    moved: float = 0.0
    turned: float = 0.0
    pushed: tuple[float, ...] = ()

    def __str__(self) -> str:
        far = jump(self.moved, self.turned, self.pushed)
        return f"{self.factor:.4g} times the load: {describe_event(self.kind, (self.who,))}{far}"


@dataclass(frozen=True, slots=True)
class Reached(Record):
    """A load on a path that matters. factor : on the load. moved [m], turned [rad] : of the object there, since the
    load began.
    """

    entries = ("factor", "moved_m", "turned_rad")

    factor: float
    moved: float
    turned: float


@dataclass(frozen=True, slots=True)
class Rest:
    """What is known of the whole path: the factor at which the object is lost, how far it has moved where it matters,
    what happens, and why no more is known; "" where the path was followed to its end. doubt : about the state at the
    limit or about what is commanded, in words; "" for none.
    """

    lost: float | None
    marks: dict[str, Reached]
    events: tuple[LimitEvent, ...]
    undecided: str = ""
    doubt: str = ""


@dataclass(frozen=True, slots=True)
class LimitPath:
    """The path, m states of it, the first before there is any load and the last at its end.

    factors (m,) on the load. forces (m, n, 3) on the object, contact axes [N]. torques (m, nv) of the joints [N·m].
    displacement (m, 6) of the object since the squeeze began: of the reference point [m], and rotation vector [rad].
    """

    factors: Array
    forces: Array
    torques: Array
    displacement: Array


@check_method_calls
@dataclass(frozen=True, eq=False)
class LoadLimit(Record):
    """The largest factor on a load that a grasp holds when the load grows slowly; made by `Grasp.load_limit`.

    factor : times `wrench`; the load at which a contact has slid `max_slip` or the object is lost, or a joint is at a
    limit, whichever comes first; inf where nothing binds however large the load, 0 where squeeze or weight alone are
    not held.
    wrench (6,) : the load [N, N·m] that grows, about the grasp's reference: beside the weight, and of contacts without
    a hand beside their own wrench, unless that is what grows. binds : what gives out, one or several; "undecided" where
    the path could not be followed on, or a link that is no contact comes into the object: the factor is held, and may
    not be the largest.
    geometry : "fixed" or "followed".
    first_slip, slides, lost : factors, None where that never comes. first_slip : a contact begins to slide. slides : a
    contact that presses has slid `max_slip` since the load began, the length of its way: the object is no longer where
    the hand gripped it. lost : beyond this load the path has no state at rest, or the object snaps to it: inertia and
    damping decide how far it jumps.
    accuracy : estimated error of the forces, the largest of a step, as a share of the largest force. made : computes
    what is asked for later.
    question : what was asked, as which it is pickled.
    """

    entries = (
        "factor", "load_asked_N_Nm (6,) = wrench", "load_held_N_Nm (6,) = load", "geometry", "why", "binds",
        "first_slip", "slides", "lost", "accuracy", "motion = marks", "events", "doubt",
    )  # fmt: skip

    factor: float
    wrench: Array
    binds: tuple[Bind, ...]
    geometry: str
    made: Later
    first_slip: float | None = None
    slides: float | None = None
    accuracy: float = np.nan
    question: Question | None = None

    @lazy_property
    def why(self) -> str:
        """One sentence: at which load what gives out, and what the object does then."""
        return self.made.why()

    @lazy_property
    def _rest(self) -> Rest:
        return self.made.rest()

    @property
    def lost(self) -> float | None:
        """The factor beyond which the path has no state at rest, or the object snaps; None: a joint's limit ends it
        before, or nothing is known of the path beyond some load: then `marks` has "undecided".
        """
        return self._rest.lost

    @property
    def undecided(self) -> str:
        """Why nothing is known of the path beyond some load, such as a link that comes into the object; "" where the
        path was followed to its end.
        """
        return self._rest.undecided

    @property
    def doubt(self) -> str:
        """What to doubt about the limit: a pad pressed in farther than pads are thick, a command that tendons
        make in part alone; "" for nothing.
        """
        return self._rest.doubt

    @property
    def events(self) -> tuple[LimitEvent, ...]:
        """What happens on the way, to the end of the path, in order."""
        return self._rest.events

    @property
    def marks(self) -> dict[str, Reached]:
        """How far the object has moved where it matters: at "first_slip", "slides", "lost", at the "limit" of a joint
        or of the motion, and beyond which nothing is known: "undecided".
        """
        return self._rest.marks

    def sensitivity(self) -> PathSensitivity:
        """Derivatives of the factor, by differences of whole load limits: `.factor_by_friction` (n,), and so on;
        `wrench` is that of this limit.
        """
        assert self.question is not None  # `load_limit` saw to it
        return self.question.sensitivity()

    @property
    def load(self) -> Array:
        """(6,) factor × wrench [N, N·m]; where the factor is infinite, so are the entries that are not zero."""
        with np.errstate(invalid="ignore"):
            return read_only(np.where(self.wrench == 0.0, 0.0, self.factor * self.wrench))

    @lazy_property
    def path(self) -> LimitPath:
        """The path at its events."""
        return self.made.path()

    @lazy_property
    def at_limit(self) -> GraspSolution:
        """Forces, torques and contact states at the limit, certified; of a grasp without a limit, as far as the path
        was followed.
        """
        return self.made.at_limit()

    @lazy_property
    def some_equilibrium(self) -> float:
        """The largest factor for which any equilibrium was found, at least `factor`. A slowly growing load never
        reaches what lies beyond `factor`.
        """
        return max(self.factor, self.made.beyond(self.bound))

    @lazy_property
    def bound(self) -> float:
        """The largest factor that friction and torque limits alone allow, whatever the fingers' compliance."""
        assert self.question is not None  # `load_limit` saw to it
        return self.question.bound()

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The figure of the path: forces, friction and torques over the load, with its events.

        path : of a png, svg, pdf or jpg file; None: the matplotlib figure itself. Raises as `GraspSolution.plot`.
        """
        from handlcp.viz import draw_limit, draw_or_save  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_limit, self, title)

    def __str__(self) -> str:
        """The sentence, and what happens on the way."""
        lines = [wrap_text(self.why, "  ")]
        for name, mark in self.marks.items():
            moved = f"the object has moved {words.format_length(mark.moved)}, {words.format_angle(mark.turned)}"
            said = f"{_CALLED[name]} {mark.factor:.4g} times the load: {moved}"
            if name == "undecided" and not self.why.endswith(self.undecided):
                said = f"{said}; {self.undecided}"
            lines.append(wrap_text(said, "    ", "  "))
        others = [e for e in self.events if e.kind != "slides"]  # which `marks` tell
        lines += [wrap_text(line, "    ", "  ") for line in told(others, lambda factor: f"{factor:.4g} times the load")]
        most = self.__dict__.get("some_equilibrium", self.factor)  # as far as anybody asked
        if most > (1.0 + _SAME) * max(self.factor, self.lost or 0.0):
            said = (
                f"an equilibrium was found up to {most:.4g} times the load; a load that grows slowly never reaches it"
            )
            lines.append(wrap_text(said, "    ", "  "))
        if self.doubt:
            lines.append(wrap_text(f"Warning: {self.doubt}", "    ", "  "))
        return "\n".join(lines)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what was asked."""
        assert self.question is not None  # `load_limit` saw to it
        return (self.question.limit, ())

    def __repr__(self) -> str:
        binds = words.list_names([f"{b.kind}: {b.who}" for b in self.binds]) or "nothing"
        return f"LoadLimit(factor={self.factor:.6g}, binds={binds})"


def told(events: Iterable[LimitEvent], load: Callable[[float], str]) -> list[str]:
    """A line for each; what several do at one load as one. load : the words for a factor."""
    groups = dict[tuple[str, str], list[LimitEvent]]()
    for e in events:
        groups.setdefault((e.kind, load(e.factor)), []).append(e)
    return [
        f"{at}: {describe_event(kind, [e.who for e in same])}{jump(same[0].moved, same[0].turned, same[0].pushed)}"
        for (kind, at), same in groups.items()
    ]


@dataclass(frozen=True, slots=True)
class Later:
    """What a load limit computes when it is asked for. why : the sentence. rest : what follows beyond the factor.
    beyond : from the bound, the largest factor for which there is an equilibrium.
    """

    why: Callable[[], str]
    path: Callable[[], LimitPath]
    at_limit: Callable[[], GraspSolution]
    beyond: Callable[[float], float]
    rest: Callable[[], Rest]


class Question(Protocol):
    """What a load limit was asked."""

    def limit(self) -> LoadLimit:
        """The answer."""

    def bound(self) -> float:
        """The largest factor without compliance."""

    def sensitivity(self) -> PathSensitivity:
        """Its derivatives."""
