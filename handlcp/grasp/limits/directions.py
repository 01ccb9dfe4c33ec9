"""Load limits in many directions at once: squeeze and weight are shared, and each direction is one path."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_array, check_workers, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.failure.failure_mode import EQUILIBRIUM, OBJECT, Bind
from handlcp.grasp.limits.answered import slid_contacts
from handlcp.grasp.limits.fixed import (
    begun_of,
    ends_plainly,
    fixed_limit,
    over_nothing,
    slip_shares,
    springs_alone,
    watch_from,
)  # fmt: skip
from handlcp.grasp.limits.followed import Allowed, Before
from handlcp.grasp.limits.kernels.happens import GIVES_UP, JUMPS, LOST
from handlcp.grasp.limits.kernels.onward import onward_each
from handlcp.grasp.limits.kernels.parts import none_known, update
from handlcp.grasp.limits.load_limit import read_allowed
from handlcp.grasp.limits.path import binds_of
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.advance import read_accuracy
from handlcp.grasp.path.follow import is_followed
from handlcp.grasp.path.geometry import length_of
from handlcp.grasp.path.watch import MAX_SLIP
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.tolerances import EVENT_TOLERANCE


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
    follows = is_followed(spec, geometry)
    loads = check_array("wrenches", wrenches, (-1, 6))
    if not len(loads) or not loads.any(axis=1).all():
        raise InputError("wrenches", "at least one load, none of them zero", f"{len(loads)} of them")
    near, allowed = read_accuracy(accuracy), read_allowed(spec, motion, turn, max_slip)
    if follows or not springs_alone(spec):
        return _in_steps(spec, section, loads, allowed, near, "followed" if follows else "fixed")
    return _fixed(spec, section, loads, allowed, near)


def _in_steps(
    spec: GraspSpec, section: Section, loads: Array, allowed: Allowed, accuracy: float, geometry: str
) -> Limits:
    before = Before(spec, section, allowed, geometry, accuracy)
    workers = min(check_workers(None), len(loads))
    with ThreadPoolExecutor(workers) as threads:  # a path holds the interpreter's lock at its ends alone
        found = list(threads.map(before.limit, loads))
    factors, off = np.array([(one.factor, one.accuracy) for one in found]).T.copy()
    return Limits(loads, read_only(factors), tuple([x.binds for x in found]), geometry, read_only(off))


def _never(loads: Array) -> Limits:
    """Where squeeze or weight alone are not held."""
    m = len(loads)
    none, binds = read_only(np.zeros(m)), ((Bind(EQUILIBRIUM, OBJECT),),) * m
    return Limits(loads, none, binds, "fixed", none)


def _fixed(spec: GraspSpec, section: Section, loads: Array, allowed: Allowed, accuracy: float) -> Limits:
    system, begun = begun_of(spec, section, loads[int(abs(loads).max(axis=1).argmax())])
    m = len(loads)
    if begun.place is None:
        return _never(loads)
    p, watch = system.parts, watch_from(system, begun.place, allowed)
    n, known = len(p.mu), none_known(p)
    answers, ends = np.empty((m, 4)), np.empty((m, n + len(p.owner)), dtype=np.int64)
    points = np.empty((m, 1 + len(p.E) + len(p.G) + len(p.rows)))
    update(p, begun.place.closed, (begun.place.yields == 1).astype(np.int64), known)
    length = length_of(spec.positions)
    (per_slip, slid), slips = slip_shares(system, begun, allowed.max_slip), np.empty((m, n))
    with compile_now(m):
        onward_each(
            p, begun.place, system.load(system.weight), system.loads(loads), watch, system.sets, length, per_slip, slid,
            known, answers, ends, points, slips,
        )  # fmt: skip
    for a, w in enumerate(system.loads(loads)):
        answers[a, 2] = over_nothing(answers[a, 2], w, begun.place)
    walked = (answers[:, 0] != GIVES_UP) & (answers[:, 2] > 0.0)
    slides = np.isfinite(points[:, 0]) & walked
    answers[slides, 2] = points[slides, 0]
    binds = [
        binds_of(system, int(status), int(which), end[:n], end[n:])
        for (status, which), end in zip(answers[:, :2].tolist(), ends, strict=True)
    ]
    for a in np.flatnonzero(slides).tolist():
        binds[a] = slid_contacts(spec.names, slips[a])
    again = (answers[:, 0] == GIVES_UP) | ((answers[:, 0] == JUMPS) & np.isnan(points[:, 0]))
    off = np.full(m, EVENT_TOLERANCE)
    if not ends_plainly(system):
        again |= (answers[:, 0] == LOST) & np.isnan(points[:, 0]) & (answers[:, 2] > 0.0)
    for a in np.flatnonzero(again).tolist():
        found = fixed_limit(spec, section, loads[a], allowed, accuracy)
        answers[a, 2], binds[a], off[a] = found.factor, found.binds, found.accuracy
    return Limits(loads, read_only(answers[:, 2].copy()), tuple(binds), "fixed", read_only(off))
