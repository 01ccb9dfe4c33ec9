"""How much load a grasp holds in one direction, what gives out there, and what happened on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.grasp.answer.shown import Data
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.sensitivity.paths import PathSensitivity
from handlcp.lazy import lazy
from handlcp.text_table import wrapped
from handlcp.views import view

__all__ = [
    "EQUILIBRIUM", "MOTION", "OBJECT", "OPENS", "RANGE", "SLIPS", "TORQUE", "Bind", "Later", "LimitEvent", "LimitPath",
    "LoadLimit",
]  # fmt: skip

# What binds
SLIPS, OPENS, TORQUE, RANGE, EQUILIBRIUM, MOTION = "slips", "opens", "torque", "range", "equilibrium", "motion"
OBJECT = "the object"
_SAME = 1e-6  # factors that differ by less are the same


@dataclass(frozen=True, slots=True)
class Bind:
    """What ends a load's growth. kind : "slips" (a finger that slips), "opens" (a contact that lets go),
    "torque" (a joint at its torque limit), "range" (a joint at the end of its range), "equilibrium" (forces can no
    longer balance the load), "motion" (the object moves farther than was allowed). who : the finger, the joint or
    "the object".
    """

    kind: str
    who: str


@dataclass(frozen=True, slots=True)
class LimitEvent:
    """What happens while the load grows. kind : "slips", "sticks", "opens", "touches" (a contact), "yields", "holds"
    (what is limited, such as a joint with `TorqueSaturation`), "snaps" (the object, to another place). who : its name.
    factor : on the load, when it happens.
    """

    kind: str
    who: str
    factor: float

    def __str__(self) -> str:
        return f"{self.factor:.4g} times the load: {self.who} {self.kind}"


@dataclass(frozen=True, slots=True)
class LimitPath:
    """The path at its events, m of them, the first before there is any load and the last at the limit.

    factors (m,) on the load. forces (m, n, 3) on the object, contact axes [N]. torques (m, nv) of the joints [N·m].
    displacement (m, 6) of the object since the squeeze began: of the reference point [m], and rotation vector [rad].
    """

    factors: Array
    forces: Array
    torques: Array
    displacement: Array


@dataclass(frozen=True, eq=False)
class LoadLimit(Data):
    """The largest factor on a load that a grasp holds when the load grows slowly; made by `Grasp.load_limit`.

    factor : times `wrench`; inf where nothing binds however large the load, 0 where squeeze or weight alone are not
    held. wrench (6,) : the load [N, N·m], beside the weight, about the grasp's reference. binds : what gives out, one
    or several. why : one sentence. events : on the way, in order. geometry : "fixed" or "followed".
    made : computes what is asked for later. question : what was asked, as which it is pickled.
    """

    factor: float
    wrench: Array
    binds: tuple[Bind, ...]
    why: str
    events: tuple[LimitEvent, ...]
    geometry: str
    made: Later
    question: Question | None = None

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

    @lazy
    def path(self) -> LimitPath:
        """The path at its events."""
        return self.made.path()

    @lazy
    def at_limit(self) -> GraspSolution:
        """Forces, torques and contact states at the limit, certified; of a grasp without a limit, as far as the path
        was followed.
        """
        return self.made.at_limit()

    @lazy
    def some_equilibrium(self) -> float:
        """The largest factor for which any equilibrium was found, at least `factor`. A slowly growing load never
        reaches what lies beyond `factor`.
        """
        return max(self.factor, self.made.beyond(self.bound))

    @lazy
    def bound(self) -> float:
        """The largest factor that friction and torque limits alone allow, whatever the fingers' compliance."""
        assert self.question is not None  # `load_limit` saw to it
        return self.question.bound()

    def plot(self, path: Any = None, *, title: str = "") -> Any:
        """The figure of the path: forces, friction and torques over the load, with its events.

        path : of a png, svg, pdf or jpg file; None: the matplotlib figure itself. Raises as `GraspSolution.plot`.
        """
        return view("limit_plot")(self, path, title)

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        return {
            "factor": _finite(self.factor), "load_asked_N_Nm": self.wrench.tolist(),
            "load_held_N_Nm": [_finite(x) for x in self.load.tolist()], "geometry": self.geometry, "why": self.why,
            "binds": [{"kind": b.kind, "who": b.who} for b in self.binds],
            "events": [{"kind": e.kind, "who": e.who, "factor": e.factor} for e in self.events],
        }  # fmt: skip

    def __str__(self) -> str:
        """The sentence, and what happens on the way."""
        lines = [wrapped(self.why, "  ")]
        lines += [wrapped(f"{e}", "    ", "  ") for e in self.events]
        most = self.__dict__.get("some_equilibrium", self.factor)  # as far as anybody asked
        if most > (1.0 + _SAME) * self.factor:
            said = (
                f"an equilibrium was found up to {most:.4g} times the load; a load that grows slowly never reaches it"
            )
            lines.append(wrapped(said, "    ", "  "))
        return "\n".join(lines)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what was asked."""
        assert self.question is not None  # `load_limit` saw to it
        return (self.question.limit, ())

    def __repr__(self) -> str:
        binds = words.listed([f"{b.kind}: {b.who}" for b in self.binds]) or "nothing"
        return f"LoadLimit(factor={self.factor:.6g}, binds={binds})"


def _finite(x: float) -> float | None:
    return x if np.isfinite(x) else None


@dataclass(frozen=True, slots=True)
class Later:
    """What a load limit computes when it is asked for. beyond : from the bound, the largest factor for which there is
    an equilibrium.
    """

    path: Callable[[], LimitPath]
    at_limit: Callable[[], GraspSolution]
    beyond: Callable[[float], float]


class Question(Protocol):
    """What a load limit was asked."""

    def limit(self) -> LoadLimit:
        """The answer."""

    def bound(self) -> float:
        """The largest factor without compliance."""

    def sensitivity(self) -> PathSensitivity:
        """Its derivatives."""
