"""`payload`: the largest mass in each direction of gravity: what pulls a kilogram of the object, and how many are held.

A hand that accelerates by s feels gravity and inertia together,

    v = g d - s        of the hand's base, |s| = a        [m/s²]

and m kilograms load the grasp by m v at the object's centre of mass. The mass is the limit of that load as it grows
from nothing, gravity and inertia together, after a squeeze without the object's own weight. Where fingers weigh
something, v pulls them, too.

Where only the load depends on v, most is asked for with s against gravity: the same path as at rest, g + a in place of
g. So over all directions of d and s together the least mass is that over v / |v|, with |v| = g + a.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import Array, check_number, read_only
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.geometry import Object
from handlcp.grasp import Grasp
from handlcp.grasp.effects.joint_offset import describe_missing_squeeze
from handlcp.grasp.failure.failure_mode import OBJECT, UNDECIDED, FailureMode
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.load_limit import load_limit
from handlcp.grasp.model.contact import axis_directions, contact_frame
from handlcp.grasp.model.request import GraspSpec, with_changes
from handlcp.grasp.path.follow import geometry_of
from handlcp.hand import HandGrasp
from handlcp.hand.request import GraspRequest
from handlcp.progress import track_progress
from handlcp.studies.envelope.direction import circle_grid, sphere_grid
from handlcp.studies.envelope.question import (
    FIXED_GEOMETRY,
    FOLLOWED_GEOMETRY,
    GRAVITY,
    DirectionalLoad,
    EnvelopeQuestion,
    read_load,
)
from handlcp.studies.payload.result import Orientation, Payload, mass_order

ANY, SIX = "any", 6
_NEGLIGIBLE_MASS = 1e-6  # [kg]: overlaps of rounding hold micrograms


def find_payload(
    grasp: Grasp,
    orientations: Any = SIX,
    acceleration: Any = 0.0,
    geometry: str | None = None,
    faces: int | str | Pyramid = "cone",
    motion: float | None = None,
    turn: float | None = None,
    accuracy: float | None = None,
    max_slip: Any = 1e-3,
) -> Payload:
    """The largest mass that a grasp holds in several directions of gravity: see `Grasp.payload`."""
    check_orientations(orientations)
    if geometry not in (None, FIXED_GEOMETRY, FOLLOWED_GEOMETRY):
        raise InputError("geometry", '"fixed", "followed" or None', repr(geometry)[:80])
    more = check_number("acceleration", acceleration, minimum=0.0)
    section, moves = as_section(faces, planar=grasp.scene.kind.planar), geometry_of(grasp.spec, geometry)
    how = FOLLOWED_GEOMETRY if moves.follows else FIXED_GEOMETRY
    searched = FOLLOWED_GEOMETRY if moves.follows and (geometry == FOLLOWED_GEOMETRY or moves.quick) else FIXED_GEOMETRY
    load = read_load(_refer_to_mass_centre(grasp), GRAVITY, None)
    names = grasp.spec.names
    question = EnvelopeQuestion.read(load, names, section, how, motion, turn, accuracy, max_slip)
    axes = axis_directions(grasp.spec.plane)
    ways, tried = axes, len(axes)
    if orientations == ANY:  # with the hand accelerating against gravity, which is worst
        pulled = replace(question, geometry=searched, load=replace(load, gravity=load.gravity + more))
        with track_progress("directions"):
            worst, tried = _find_worst_direction(pulled, grasp.spec.plane)
        ways = np.vstack([axes, worst])
    rows = []
    with track_progress("orientations", len(ways)) as done:
        for k, d in enumerate(ways):
            rows.append(_find_least_mass(question, more, d, axes if k < len(axes) else -d[None]))
            done(1)
    return Payload(tuple(rows), orientations, more, how, load, tried, searched)


def check_orientations(value: Any) -> None:
    """Raises InputError for anything but 6 and "any"."""
    if not isinstance(value, (int, str)) or value not in (SIX, ANY):
        raise InputError("orientations", '6 or "any"', repr(value)[:80])


def _refer_to_mass_centre(grasp: Grasp) -> Grasp:
    """The grasp with its object's centre of mass as the reference: a load limit loads the reference, and there a force
    stays a weight while the object turns.
    """
    asked = grasp.spec.asked
    if not isinstance(asked, GraspRequest) or asked.reference is None or not isinstance(asked.target, Object):
        return grasp
    return HandGrasp(with_changes(asked, {"reference": None}).spec())


# ----------------------------------------------------------------
# One direction of gravity: the least mass over the ways that the hand accelerates.


def _find_least_mass(q: EnvelopeQuestion, acceleration: float, d: Array, ways: Array) -> Orientation:
    """The least mass with gravity along d (3,), while the hand accelerates [m/s²] along any of `ways` (k, 3)."""
    rows = []
    for s, spec, wrench in _accelerated_loads(q.load, d, acceleration, ways):
        limit = load_limit(spec, q.section, wrench, q.geometry, q.motion, q.turn, q.accuracy, q.max_slip)
        mass, binds = limit.factor, limit.binds
        if np.isinf(mass) and np.isfinite(limit.bound):
            mass, binds = np.nan, (FailureMode(UNDECIDED, OBJECT),)
        says = (describe_missing_squeeze(spec) if mass < _NEGLIGIBLE_MASS else "") or describe_failures(binds, spec)
        rows.append(Orientation(read_only(d.copy()), mass, binds, says, s, limit))
    return min(rows, key=mass_order)


def unit_mass_loads(grasp: Grasp, acceleration: float) -> list[tuple[GraspSpec, Array]]:
    """Loads (6,) by 1 kg, each with the grasp that it is on: of the limits of these `payload` tells the least."""
    load, axes = read_load(_refer_to_mass_centre(grasp), GRAVITY, None), axis_directions(grasp.spec.plane)
    return [(spec, wrench) for d in axes for _, spec, wrench in _accelerated_loads(load, d, acceleration, axes)]


def _accelerated_loads(
    load: DirectionalLoad, d: Array, acceleration: float, ways: Array
) -> Iterator[tuple[Array, GraspSpec, Array]]:
    """The acceleration (3,) of the hand, the grasp and what 1 kg loads it with (6,), with gravity along d (3,), for
    each of `ways` (k, 3) to accelerate but those in which the object floats.
    """
    for s in acceleration * ways if acceleration else np.zeros((1, 3)):
        pull = load.gravity * d - s
        size = float(np.linalg.norm(pull))
        if size > 1e-9 * load.gravity:
            pulled, along = replace(load, gravity=size), pull[None] / size
            spec, _ = next(pulled.specs(along))
            yield read_only(s), spec, pulled.wrenches(along)[0]


# ----------------------------------------------------------------
# The worst direction of all: directions all around, then steps downhill from the lowest of them.
#
# What a grasp holds by friction and torques alone is a convex set of loads, and directions would bound it from inside.
# What compliant fingers hold on a path is not convex, so that no directions prove the minimum: it is sampled.

_SEARCH_DIRECTIONS = {FIXED_GEOMETRY: 162, FOLLOWED_GEOMETRY: 42}  # directions all around; in a plane one every 10°
_CIRCLE_DIRECTIONS = 36
_MAX_DESCENTS = 2  # the lowest of those that are lower than their neighbours
_MIN_DESCENT_STEP = np.radians(0.5)  # the last steps
_MIN_IMPROVEMENT = 1e-6  # relative: a step downhill is at least as much
_RING_DIRECTIONS = 6


def _find_worst_direction(question: EnvelopeQuestion, plane: Array | None) -> tuple[Array, int]:
    """(3,) the direction of gravity with the least mass, and how many were tried."""
    if plane is None:
        grid = sphere_grid(_SEARCH_DIRECTIONS[question.geometry])
    else:
        grid = circle_grid(contact_frame(plane).T[:2], _CIRCLE_DIRECTIONS)
    masses = _held_masses(question, grid.points)
    edges, lower = grid.edges, np.ones(len(masses), dtype=bool)
    for a, b in (edges.T, edges.T[::-1]):
        lower[a[masses[a] > masses[b]]] = False
    starts = sorted(np.flatnonzero(lower).tolist(), key=lambda k: float(masses[k]))[:_MAX_DESCENTS]
    ends = grid.points[edges]
    apart = float(np.arccos(np.clip((ends[:, 0] * ends[:, 1]).sum(axis=1), -1.0, 1.0)).max())
    found, tried = list[tuple[float, Array]](), len(masses)
    for k in starts:
        mass, d, more = _descend(question, grid.points[k], float(masses[k]), 0.5 * apart, plane)
        found.append((mass, d))
        tried += more
    return min(found, key=lambda one: one[0])[1], tried


def _descend(
    question: EnvelopeQuestion, d: Array, mass: float, step: float, plane: Array | None
) -> tuple[float, Array, int]:
    """From a direction with its mass, to the lowest around it while one is lower, then in steps of half the angle."""
    tried = 0
    while step >= _MIN_DESCENT_STEP and 0.0 < mass < np.inf:
        if plane is None:  # evenly all around, at this angle; in a plane the two beside it
            x, y = contact_frame(d).T[:2]
            turns = 2.0 * np.pi * np.arange(_RING_DIRECTIONS) / _RING_DIRECTIONS
            aside = np.outer(np.cos(turns), x) + np.outer(np.sin(turns), y)
        else:
            aside = np.cross(plane, d) * np.array([[1.0], [-1.0]])
        ring = np.cos(step) * d + np.sin(step) * aside
        masses, tried = _held_masses(question, ring), tried + len(ring)
        k = int(masses.argmin())
        if masses[k] < (1.0 - _MIN_IMPROVEMENT) * mass:
            d, mass = ring[k], float(masses[k])
        else:
            step *= 0.5
    return mass, d, tried


def _held_masses(question: EnvelopeQuestion, directions: Array) -> Array:
    """Masses (m,) [kg] that are held with gravity along directions (m, 3); inf where it is undecided."""
    masses, _, _ = question.find_factors(directions, None)
    return np.where(np.isnan(masses), np.inf, masses)
