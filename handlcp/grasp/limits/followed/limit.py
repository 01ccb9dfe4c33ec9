"""Load limits with the geometry followed: squeeze and weight once, then a path for each load.

A load keeps its axes in the world, and acts at the object's reference point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.followed.cause import binds_of
from handlcp.grasp.limits.followed.locate import located
from handlcp.grasp.limits.followed.path import LoadedPath, Point, PushedPath
from handlcp.grasp.limits.followed.walk import RAY, WATCHED, Size, snapped, walk
from handlcp.grasp.limits.followed.watched import Watched
from handlcp.grasp.limits.result import EQUILIBRIUM, OBJECT, Bind
from handlcp.grasp.loading.drive import FINEST, drive
from handlcp.grasp.loading.follow import begun, geometry_of
from handlcp.grasp.loading.stage import Stage
from handlcp.grasp.loading.state import SLIDES, State
from handlcp.grasp.loading.step import Stepper
from handlcp.grasp.loading.why import why_lost
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["Ended", "Ready", "ended", "ready"]

_TOLERANCE = 1e-3  # of the contacts' radii: how far a step may end from where its contacts were looked at
_STEPS = 40  # of the squeeze, and of the weight
_EVENT = 0.01  # of the motion that the forces before make: an event is located more exactly than that
_TURNS = 1e-3  # of the contacts' radii: the least motion that steps are measured by


@dataclass(frozen=True, slots=True)
class Ready:
    """A grasp with squeeze and weight. state : then; None where it is not held, and why. last : as far as it is."""

    stepper: Stepper
    state: State | None
    last: State
    size: Size
    why: str


@dataclass(frozen=True, slots=True)
class Ended:
    """The end of one path. factor : inf where nothing binds. at : the last point, from which `before` leads back to
    the first; after : the contacts' states beyond it. most : the largest factor at any point that was seen.
    """

    factor: float
    binds: tuple[Bind, ...]
    at: Point
    most: float
    path: PushedPath


def ready(spec: GraspSpec, section: Section) -> Ready:
    """Squeeze the object, then let it weigh. Raises InputError for a grasp whose geometry is not known, Unsupported."""
    order = ("squeeze", Stage("weight", weight=1.0))
    first, goals, stepper = begun(spec, section, geometry_of(spec, "followed"), _TOLERANCE, order, np.zeros(6))
    run = drive(stepper, first, goals, _STEPS, FINEST)
    state = run.states[-1]
    force = float(state.read.forces[:, 2].sum())
    soft = float(state.look.elastic.E.diagonal().mean())
    size = Size(max(soft * force / spec.n, _TURNS * float(state.look.radius.min())), force)
    if run.failure is not None:
        stage = goals[run.lost_stage].name
        return Ready(stepper, None, state, size, f"the {stage} alone is not held: {why_lost(run, spec)}")
    return Ready(stepper, state, state, size, "")


def ended(held: Ready, load: Array, most: tuple[float, float]) -> Ended:
    """The limit on one load (6,) about the reference. most : motion [m] and turn [rad] of the object that are allowed.

    The factor is inf where it has grown until the load is `RAY_AT` times the forces that were there before.
    """
    assert held.state is not None
    stepper, size = held.stepper, held.size
    path = PushedPath(stepper, held.state, load)
    if not size.force > 0.0:
        size = Size(size.motion, path.strength)
    if stepper.grasp.general:
        path = LoadedPath(stepper, held.state, load, size.force / (size.motion * path.strength))
    watched = Watched(stepper, held.state, most)
    if watched.over(held.state) > 0.0:
        return Ended(0.0, watched.binds(held.state), path.start, 0.0, path)
    first: Point | None = path.start
    while first is not None:
        way = walk(path, first, size, watched.over)
        if way.how == RAY:
            return Ended(np.inf, (), way.at, way.at.factor, path)
        at, after = located(path, way, watched.over)
        first = None if way.how == WATCHED else snapped(path, at, way.after, size)
    largest = max(at.factor, 0.0 if after is None else after.factor)
    turns = after is not None and SLIDES in at.kinds and path.moved(at, after) > _EVENT * size.motion
    event = None if turns and way.how != WATCHED else after
    binds = binds_of(way.how, at, event, watched, stepper.grasp.spec.names)
    return Ended(at.factor, binds or (Bind(EQUILIBRIUM, OBJECT),), at, largest, path)
