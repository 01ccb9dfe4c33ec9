"""The load limit in one posture, with fixed contacts and normals: a path from event to event."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.binds import binds_of, events_of, why_of, with_joints
from handlcp.grasp.limits.further import largest_held
from handlcp.grasp.limits.kernels.happens import GIVES_UP, Watch
from handlcp.grasp.limits.kernels.parts import Place, none_known
from handlcp.grasp.limits.kernels.trace import EVENTS, trace
from handlcp.grasp.limits.path import TracedPath
from handlcp.grasp.limits.result import EQUILIBRIUM, OBJECT, Bind, Later, LoadLimit
from handlcp.grasp.limits.start import begun_of
from handlcp.grasp.limits.stepped import confirms, stepped_limit
from handlcp.grasp.limits.system import System
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["fixed_limit", "watch_from"]


def watch_from(system: System, place: Place, most: tuple[float, float]) -> Watch:
    """What ends a path that begins at a place; most : as in `fixed_limit`."""
    return system.watch._replace(start=system.watch.moves @ place.u, motion=most[0], turn=most[1])


def fixed_limit(spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float]) -> LoadLimit:
    """Most : motion [m] and turn [rad] of the object that are allowed."""
    system, begun = begun_of(spec, section, wrench)
    if begun.place is None:
        none = TracedPath(system, wrench, np.zeros((0, 1)), None)
        binds: tuple[Bind, ...] = (Bind(EQUILIBRIUM, OBJECT),)
        return LoadLimit(0.0, wrench, binds, begun.why, (), "fixed", _later(none, 0.0))
    p, place = system.parts, begun.place
    watch = watch_from(system, place, most)
    log, points = np.empty((EVENTS, 3)), np.empty((EVENTS, 1 + len(p.E) + len(p.G) + len(p.rows)))
    w, known = system.load(wrench), none_known(p)
    status, factor, which, events, count = trace(p, place, w, np.inf, watch, known, log, points)
    path = TracedPath(system, wrench, points[:count].copy(), place)
    if status == GIVES_UP or not path.sound:
        slower = stepped_limit(spec, section, wrench, most, float(points[count - 1, 0]))
        if status != GIVES_UP or not confirms(slower, factor):
            return slower
    binds = with_joints(system, binds_of(system, status, which, place.closed, place.active), place.yields)
    happened = events_of(system, log[:events])
    return LoadLimit(factor, wrench, binds, why_of(factor, wrench, binds), happened, "fixed", _later(path, factor))


def _later(path: TracedPath, factor: float) -> Later:
    spec, section, weight, wrench = path.system.spec, path.system.section, path.system.weight, path.wrench

    def beyond(bound: float) -> float:
        return largest_held(spec, section, weight, wrench, factor, bound)

    return Later(path.arrays, path.solution, beyond)
