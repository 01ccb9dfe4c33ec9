"""`Grasp.load_limit` and limits in many directions: which geometry, and what is asked."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp.check import Array, check_array, check_number, check_workers, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.derivatives.path_sensitivity import PathSensitivity
from handlcp.grasp.failure.failure_mode import Bind
from handlcp.grasp.limits.followed import Allowed, Before
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.model.request import GraspSpec, check_load
from handlcp.grasp.path.advance import ACCURACY, read_accuracy
from handlcp.grasp.path.follow import is_followed
from handlcp.grasp.path.watch import MAX_SLIP, read_max_slip
from handlcp.grasp.verify.static_load_bound import static_load_bounds
from handlcp.progress import track_progress

# ----------------------------------------------------------------
# What is asked of a load limit: which load, which geometry, how far the object may move.


def load_of(spec: GraspSpec, wrench: Any) -> tuple[GraspSpec, Array]:
    """The grasp with what rests on it alone, and the load (6,) that grows beside that, given as `Grasp` takes it; None:
    the grasp's own, of contacts without a hand from nothing. Raises InputError.
    """
    if wrench is not None:
        given = check_load(spec, wrench)
        if not given.any():
            raise InputError("wrench", "a load that is not zero", given.tolist())
        return spec, given
    if not spec.load_beside_weight.any():
        raise InputError("wrench", _LOAD + _down(spec.wrench), wrench)
    return without_wrench(spec), spec.load_beside_weight


def without_wrench(spec: GraspSpec) -> GraspSpec:
    """Contacts without a hand before their wrench comes; a hand's grasp as it is."""
    return spec if spec.mechanism is not None else spec.replace(wrench=read_only(np.zeros(6)), asked=spec.asked)


_LOAD = "the load that is to grow, force [N] and torque [N·m], as this grasp has none of its own"


def _down(weight: Array) -> str:
    """Which load (6,) acts as the weight (6,) does: 1 N of it."""
    size = float(np.linalg.norm(weight[:3]))
    if size == 0.0:
        return ""
    row = ", ".join([f"{round(x, 3) + 0.0:g}" for x in (weight / size).tolist()])
    return f" beside the weight, which acts along ({row})"


def read_allowed(spec: GraspSpec, motion: Any, turn: Any, max_slip: Any) -> Allowed:
    """What the object may do, as `Grasp.load_limit` takes it. Raises InputError, UnknownName."""
    most = [
        np.inf if x is None else check_number(name, x, above=0.0) for name, x in (("motion", motion), ("turn", turn))
    ]
    return Allowed(most[0], most[1], read_max_slip(max_slip, spec.names))


# ----------------------------------------------------------------


@track_progress("load limit")
def load_limit(
    spec: GraspSpec, section: Section, wrench: Any, geometry: Any, motion: Any, turn: Any, accuracy: Any = None,
    max_slip: Any = MAX_SLIP,
) -> LoadLimit:  # fmt: skip
    """See `Grasp.load_limit`."""
    follows, allowed = is_followed(spec, geometry), read_allowed(spec, motion, turn, max_slip)
    near = read_accuracy(accuracy)
    _, load = load_of(spec, wrench)
    return _Question(spec, section, load, follows, allowed, near, wrench is None).limit()


@dataclass(frozen=True, eq=False)
class _Question:
    """What was asked: a load (6,) beside the weight, whether the geometry is followed, what the object may
    do. own : whether the load is the grasp's own, which grows from nothing; another one grows beside the wrench of
    contacts without a hand. A load limit is pickled as this, and found again.
    """

    spec: GraspSpec
    section: Section
    wrench: Array
    follows: bool
    allowed: Allowed
    accuracy: float = ACCURACY
    own: bool = False

    def limit(self) -> LoadLimit:
        """The answer."""
        return replace(self.varied(self.spec, self.wrench), question=self)

    def varied(self, spec: GraspSpec, wrench: Array) -> LoadLimit:
        """The same of another grasp, or of another load."""
        spec = without_wrench(spec) if self.own else spec
        return Before(spec, self.section, self.allowed, _geometry_name(self.follows), self.accuracy).limit(wrench)

    def bound(self) -> float:
        """See `LoadLimit.bound`."""
        spec = without_wrench(self.spec) if self.own else self.spec
        return float(static_load_bounds(spec, self.section, self.wrench[None]).factors[0])

    def sensitivity(self) -> PathSensitivity:
        """See `LoadLimit.sensitivity`."""
        return PathSensitivity(self.spec, self._factor)

    def _factor(self, varied: GraspSpec) -> dict[str, Array]:
        load = read_only(self.wrench + varied.load_beside_weight - self.spec.load_beside_weight)
        own = varied.replace(wrench=self.spec.wrench, asked=varied.asked)
        return {"factor": np.array(self.varied(own, load).factor)}


def _geometry_name(follows: bool) -> str:
    return "followed" if follows else "fixed"


# ----------------------------------------------------------------
# Many directions: squeeze and weight are shared, and each direction is one path.


@dataclass(frozen=True, eq=False)
class Limits:
    """Limits of one grasp in m directions. wrenches (m, 6) : the loads, beside what rests on the object as
    `GraspSpec.resting_wrench` has it [N, N·m]. factors (m,) : of
    each, inf where nothing binds. binds (m,) : what gives out, as in `LoadLimit`. geometry : "fixed" or "followed".
    accuracy (m,) : estimated relative errors of the factors; NaN: not asked.
    """

    wrenches: Array
    factors: Array
    binds: tuple[tuple[Bind, ...], ...]
    geometry: str
    accuracy: Array

    @property
    def kinds(self) -> tuple[str, ...]:
        """(m,) the first thing that binds: a kind of `Bind`, "" where nothing does."""
        return tuple([b[0].kind if b else "" for b in self.binds])

    @property
    def who(self) -> tuple[tuple[str, ...], ...]:
        """(m,) names of what binds."""
        return tuple([tuple([b.who for b in every]) for every in self.binds])


def limits_of(
    spec: GraspSpec, section: Section, wrenches: Any, geometry: Any = None, motion: Any = None, turn: Any = None,
    accuracy: Any = None, max_slip: Any = MAX_SLIP,
) -> Limits:  # fmt: skip
    """Of loads (m, 6), other arguments as in `Grasp.load_limit`. Raises InputError, UnknownName, Unsupported."""
    how = _geometry_name(is_followed(spec, geometry))
    loads = check_array("wrenches", wrenches, (-1, 6))
    if not len(loads) or not loads.any(axis=1).all():
        raise InputError("wrenches", "at least one load, none of them zero", f"{len(loads)} of them")
    before = Before(spec, section, read_allowed(spec, motion, turn, max_slip), how, read_accuracy(accuracy))
    workers = min(check_workers(None), len(loads))
    with ThreadPoolExecutor(workers) as threads:  # a path holds the interpreter's lock at its ends alone
        found = list(threads.map(before.limit, loads))
    factors, off = np.array([(one.factor, one.accuracy) for one in found]).T.copy()
    return Limits(loads, read_only(factors), tuple([x.binds for x in found]), how, read_only(off))
