"""The load limit in one posture, with fixed contacts and normals: a path from event to event."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.cause.cause import EQUILIBRIUM, MOTION, OBJECT, RANGE, TORQUE, Bind
from handlcp.grasp.cause.wording import why
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.binds import binds_of, events_of, with_joints
from handlcp.grasp.limits.followed import accurate_limit
from handlcp.grasp.limits.further import largest_held
from handlcp.grasp.limits.kernels.happens import GIVES_UP, LOST, Watch
from handlcp.grasp.limits.kernels.onward import onward
from handlcp.grasp.limits.kernels.parts import Place, none_known
from handlcp.grasp.limits.kernels.slides import slides_at
from handlcp.grasp.limits.kernels.trace import EVENTS
from handlcp.grasp.limits.path import TracedPath
from handlcp.grasp.limits.result import Later, LimitEvent, LoadLimit, Reached, Rest
from handlcp.grasp.limits.start import begun_of, place_of
from handlcp.grasp.limits.system import System
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.geometry import length_of
from handlcp.tolerances import EVENTS_END

_NOTHING = 1e-7  # of the squeeze: a smaller load is borne by the damper of loose motions


def watch_from(system: System, place: Place, most: tuple[float, float]) -> Watch:
    """What ends a path that begins at a place; most : as in `fixed_limit`."""
    return system.watch._replace(start=system.watch.moves @ place.u, motion=most[0], turn=most[1])


def fixed_limit(
    spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float], accuracy: float | None = None
) -> LoadLimit:
    """Most : motion [m] and turn [rad] of the object that are allowed. accuracy : as in `accurate_limit`."""
    system, begun = begun_of(spec, section, wrench)
    if begun.place is None:
        none = TracedPath(system, wrench, np.zeros((0, 1)), None)
        binds: tuple[Bind, ...] = (Bind(EQUILIBRIUM, OBJECT),)
        return LoadLimit(0.0, wrench, binds, "fixed", _later(begun.why, none, 0.0, 0.0, None, ()), accuracy=0.0)
    p, place = system.parts, begun.place
    watch = watch_from(system, place, most)
    log, points = np.empty((EVENTS, 3)), np.empty((EVENTS, 1 + len(p.E) + len(p.G) + len(p.rows)))
    w, known = system.load(wrench), none_known(p)
    status, factor, which, events, count = onward(
        p, place, w, system.load(system.weight), watch, system.sets, known, log, points
    )
    factor = over_nothing(factor, w, place)
    path = TracedPath(system, wrench, points[:count].copy(), place)
    if status == GIVES_UP:  # where a contact opens while it slides, for one: steps of any size find the way
        return accurate_limit(spec, section, wrench, most, "fixed", accuracy)
    if status == LOST and factor > 0.0 and not ends_plainly(system) and not path.ends():
        return accurate_limit(spec, section, wrench, most, "fixed", accuracy)
    binds = with_joints(system, binds_of(system, status, which, place.closed, place.active), place.yields)
    happened = events_of(system, log[:events])
    first = next((e.factor for e in happened if e.kind == "slips"), None)
    lost = None if not binds or binds[0].kind in (TORQUE, RANGE, MOTION) else factor
    at, slides, then = np.empty(points.shape[1]), None, ""
    if factor > 0.0 and slides_at(p, watch.moves, length_of(spec.positions), points[:count], at):
        slides, then, factor = float(at[0]), "slides through", float(at[0])
        place = slid_place(system, at)
        binds = binds_of(system, LOST, -1, place.closed, place.active)
        before = points[:count][points[:count, 0] < factor]
        path = TracedPath(system, wrench, np.vstack([before, at]), place, path)
    later = _later(why(binds, factor, wrench, spec, then), path, factor, lost, slides, happened)
    return LoadLimit(factor, wrench, binds, "fixed", later, first, slides, np.nan if accuracy is None else EVENTS_END)


def ends_plainly(system: System) -> bool:
    """Whether a path ends where a trace or a walk says so. With soft fingers or anisotropic friction one in ten goes on
    by a way that neither finds.
    """
    return not system.scene.soft and not system.scene.anisotropic


def over_nothing(factor: float, w: Array, place: Place) -> float:
    """The factor on a load w (dof,), or 0 where so little load is borne by dampers alone."""
    return factor if factor * np.linalg.norm(w) > _NOTHING * np.linalg.norm(place.r) else 0.0


def slid_place(system: System, at: Array) -> Place:
    """The place at a point of a path, where contacts that press slide."""
    m, dof = len(system.parts.E), len(system.parts.G)
    return place_of(system, at[1 : 1 + m].copy(), at[1 + m : 1 + m + dof].copy(), at[1 + m + dof :].copy())


def _later(
    text: str, path: TracedPath, factor: float, lost: float | None, slides: float | None, events: tuple[LimitEvent, ...]
) -> Later:  # fmt: skip
    spec, section, weight, wrench = path.system.spec, path.system.section, path.system.weight, path.wrench

    def beyond(bound: float) -> float:
        return largest_held(spec, section, weight, wrench, factor, bound)

    def rest() -> Rest:
        arrays = (path.whole or path).arrays()
        named = [("first_slip", e.factor) for e in events if e.kind == "slips"][:1]
        if slides is not None:
            named.append(("slides", slides))
        if lost is not None:
            named.append(("lost", lost))
        named += [("limit", factor)] if lost is None and slides is None and np.isfinite(factor) else []
        marks = dict[str, Reached]()
        for name, x in named:
            if len(arrays.factors):
                moved = arrays.displacement - arrays.displacement[0]
                there = np.array([np.interp(x, arrays.factors, column) for column in moved.T])
                marks[name] = Reached(x, float(np.linalg.norm(there[:3])), float(np.linalg.norm(there[3:])))
        through = () if slides is None else (LimitEvent("slides through", OBJECT, slides),)
        return Rest(lost, marks, tuple(sorted([*events, *through], key=lambda e: e.factor)))

    return Later(lambda: text, path.arrays, path.solution, beyond, rest)
