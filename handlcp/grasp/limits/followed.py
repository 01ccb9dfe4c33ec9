"""The load limit by following the path: squeeze, weight, then a load that grows until something ends it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.contact.friction import Section
from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    OBJECT,
    FailureMode,
    find_exceeded_closing,
    state_limits,
)
from handlcp.grasp.limits.answered import OWN_WRENCH, Followed, answer as answered, nothing, slid_contacts
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import PathStatus
from handlcp.grasp.path.advance import ACCURACY, PATIENT, Leg, Open, PathLimits, Patience, advance
from handlcp.grasp.path.follow import TOLERANCE, begun, geometry_of, loading_of
from handlcp.grasp.path.state import STILL, Goal, Run, Stage, State
from handlcp.grasp.path.step import Stepper
from handlcp.grasp.path.trajectory import closing_efforts
from handlcp.grasp.path.watch import MAX_SLIP, watch_of
from handlcp.grasp.verify.static_load_bound import static_load_bounds

_STEPS = 2  # of squeeze and weight
_FIRST = 0.1  # of the load that is as large as the forces before it: the first step
_BEYOND = 1e-9  # relative: what is followed up to a limit of others goes on by so much, and is no tie
_RAY = 1e4  # times that load: nothing binds that has not bound by then


def resting_stage(spec: GraspSpec) -> Stage:
    """What comes on the object before a load grows: its weight, or the wrench of contacts without a hand."""
    return Stage("weight", weight=1.0) if spec.mechanism is not None else Stage(OWN_WRENCH, load=spec.resting_wrench)


class Allowed(NamedTuple):
    """What the object may do: motion [m] and turn [rad], from where the load finds it; max_slip (n,), how far each
    contact may slide [m].
    """

    motion: float
    turn: float
    max_slip: Array


def anything_else(spec: GraspSpec) -> Allowed:
    """Any motion, and as much slip as contacts may unless something else is said."""
    return Allowed(np.inf, np.inf, np.full(spec.n, MAX_SLIP))


class Before:
    """What comes before a load grows, followed once: squeeze, weight, and `beside` (6,), a load that is there already
    besides the weight; of contacts without a hand always their own wrench. geometry : "followed" or "fixed".
    tolerance : of steps, as in `Stepper`. accuracy, patience : as in `advance`.
    """

    def __init__(
        self, spec: GraspSpec, section: Section, allowed: Allowed, geometry: str = "followed",
        accuracy: float = ACCURACY, beside: Array = STILL, tolerance: float = TOLERANCE, patience: Patience = PATIENT,
    ) -> None:  # fmt: skip
        self._body, self._allowed, self._patience = geometry_of(spec, geometry), allowed, patience
        self._spec, self._section, self._geometry, self._beside = spec, section, geometry, beside
        self._accuracy = accuracy
        if spec.mechanism is None:
            self._beside = spec.resting_wrench
        path = np.stack([beside, beside]) if beside.any() else STILL
        order = ("squeeze", resting_stage(spec), "load")
        first, self._goals, self._stepper = begun(spec, section, self._body, tolerance, order, path)
        self._watch = watch_of(spec, self._body, allowed.max_slip)
        self._run = advance(self._stepper, self._watch, first, self._goals[:-1], _STEPS, accuracy, patience)
        self._closing = find_exceeded_closing(spec.mechanism, lambda: closing_efforts(self._run.states))

    @property
    def held(self) -> bool:
        """Whether the object is held by then, and has not left its place, and motors close so hard."""
        return not self._closing and self._run.status == PathStatus.REACHED and self._run.gives_way is None

    def bounds(self, wrenches: Array) -> Array:
        """(k,) the largest factors on loads (k, 6) that friction and torque limits alone allow."""
        return static_load_bounds(self._spec, self._section, wrenches).factors

    def holds_more(self, wrench: Array, factor: float) -> bool:
        """Whether more than this factor of a load (6,) is held."""
        return factor <= 0.0 or self.limit(wrench, until=(1.0 + _BEYOND) * factor).factor > factor

    def limit(self, wrench: Array, until: float = np.inf) -> LoadLimit:
        """Of a load (6,) that grows, up to this factor: none is found that is larger."""
        spec, section, before, stepper = self._spec, self._section, self._run, self._stepper
        if before.status != PathStatus.REACHED or self._closing:
            loading = loading_of(before, self._goals[:-1], stepper, section, self._allowed.max_slip)
            return nothing(spec, section, wrench, before, self._geometry, loading, self._closing)
        start, follows = before.states[-1], self._body.follows
        size = _as_large(stepper, start, wrench)
        at = stepper.geometry.displacement(start.where.pose)
        limits = state_limits(
            spec, motion=self._allowed[:2], ranges=follows, nominal=start.where.q if follows else None
        )

        run = Run.beginning_at(start, before.slipped[-1])
        goal = Goal(self._goals[-1].name, self._goals[-1].end._replace(load=self._beside + wrench))
        grows = Open(_FIRST * size, min(_RAY * size, until), PathLimits(limits, at, start))
        leg = Leg(stepper, self._watch, run, 0, goal, 1.0, grows, self._accuracy, self._patience)
        leg.through(pause=True)
        slid = None
        if before.slides is not None and before.gives_way is before.slides:
            shares = before.slipped[before.slides.number] / self._allowed.max_slip
            slid = before.slides.share, slid_contacts(spec.names, shares)
        elif before.jump is not None:
            slid = before.jump.share, (FailureMode(EQUILIBRIUM, OBJECT),)
        found = Followed(
            spec, section, wrench, run, leg, stepper, limits, at, self._geometry, slid, self._allowed.max_slip
        )  # fmt: skip
        return replace(answered(found), accuracy=max(run.errors))


def up_to_the_first(
    loads: Sequence[tuple[Before, Array]], least: float, most: float = np.inf, likely: Sequence[float] = ()
) -> list[tuple[LoadLimit, float]]:  # fmt: skip
    """Loads (6,) of which the first to give out is asked for, each with what comes before it. The weakest are followed
    first, and others no further than the least factor that was found before them, or `most`; and than `least` if that
    is more. A limit beyond that is infinite. With each limit the factor up to which it was followed.

    likely : which are the weakest: about the limit of each, or nothing where that is not known; then bounds tell.
    """
    found = dict[int, tuple[LoadLimit, float]]()
    for k in np.argsort(likely if len(likely) == len(loads) else _bounds(loads), kind="stable").tolist():
        before, wrench = loads[k]
        until = max(most, least)
        found[k] = before.limit(wrench, until), until
        most = min(most, (1.0 + _BEYOND) * found[k][0].factor)
    return [found[k] for k in range(len(loads))]


def _bounds(loads: Sequence[tuple[Before, Array]]) -> Array:
    """(k,) the largest factors that friction and torque limits alone allow."""
    bound = np.empty(len(loads))
    for before in {id(before): before for before, _ in loads}.values():
        its = [k for k, (one, _) in enumerate(loads) if one is before]
        bound[its] = before.bounds(np.stack([loads[k][1] for k in its]))
    return bound


def _as_large(stepper: Stepper, start: State, wrench: Array) -> float:
    """The factor with which the load is as large as the forces before it; where there are none, with which it moves a
    finger by a hundredth of the contacts' distances.
    """
    load = float(np.sqrt(wrench[:3] @ wrench[:3] + wrench[3:] @ wrench[3:] / stepper.length**2))
    forces = float(np.linalg.norm(start.read.forces, axis=1).sum())
    return (forces or 0.01 * stepper.stiffness * stepper.length) / load
