"""The load limit in one posture, with fixed contacts and normals: a path from event to event."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.effects.joint_offset import describe_missing_squeeze, find_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.failure.failure_mode import EQUILIBRIUM, MOTION, OBJECT, RANGE, SLIDES, TORQUE, Bind
from handlcp.grasp.failure.failure_text import explain_limit
from handlcp.grasp.limits.answered import alone, slid_contacts
from handlcp.grasp.limits.followed import Allowed, followed_limit, resting_stage
from handlcp.grasp.limits.further import largest_held
from handlcp.grasp.limits.kernels.happens import GIVES_UP, LOST, RAY, REACHED, TURNS, Watch
from handlcp.grasp.limits.kernels.onward import faces_reached, onward
from handlcp.grasp.limits.kernels.parts import CLOSED, CLOSES, OPEN, OPENS, Place, none_known
from handlcp.grasp.limits.kernels.rates import points_before_jump, slides_at
from handlcp.grasp.limits.kernels.trace import EVENTS, trace
from handlcp.grasp.limits.path import TracedPath, binds_of, events_of, with_joints
from handlcp.grasp.limits.result import Later, LimitEvent, LoadLimit, Reached, Rest
from handlcp.grasp.limits.system import System, system_of
from handlcp.grasp.model.contact import shift_twist
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import SLIDING, contact_statuses
from handlcp.grasp.path.advance import ACCURACY
from handlcp.grasp.path.follow import follow
from handlcp.grasp.path.geometry import length_of
from handlcp.grasp.path.state import Stage
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.tolerances import EVENT_TOLERANCE

# ----------------------------------------------------------------
# Where a path begins: the grasp squeezed, then its weight put on, before the load comes.
#
# With fingertips that just touch, a squeeze that grows makes forces and slips that grow with it. So one solve of the
# whole squeeze is the squeeze made slowly. Fingertips that are still apart, or sag, are followed in steps (`follow`).

_NONE = 3e-5  # of the contacts' distances: fingertips no farther from the object touch, as in `StepGrasp`
_KEPT = 8  # grasps
_ON = 1e-9  # of the largest force or motion


class Start(NamedTuple):
    """place : the state with squeeze and weight on; None where they are not held. why : they are not, in words; ""
    where they are. path : points on the way of the weight, as `trace` writes them.
    """

    place: Place | None
    why: str
    path: Array = np.zeros((0, 0))


def begun_of(spec: GraspSpec, section: Section, wrench: Array) -> tuple[System, Start]:
    """The arrays of a grasp, and the state that the load finds. Both are kept for the next load of the same grasp; what
    paths change are copies. wrench (6,) : as in `system_of`. Raises Unsupported.
    """
    kept = _kept(spec, section)
    if kept is None:
        system = system_of(spec, section, wrench)
        return system, _start_of(system)
    system, start = kept
    parts = system.parts._replace(normals=system.parts.normals.copy())
    place = None if start.place is None else start.place.copy()
    return replace(system, parts=parts), Start(place, start.why, start.path)


@lru_cache(maxsize=_KEPT)
def _kept(spec: GraspSpec, section: Section) -> tuple[System, Start] | None:
    """The arrays of a grasp and the state that a load finds, kept for the next load. None where there is neither
    squeeze nor weight: the load itself then sets the natural units, so that nothing can be kept.
    """
    system = system_of(spec, section, None)
    return None if system is None else (system, _start_of(system))


def _start_of(system: System) -> Start:
    squeezed = _squeezed(system)
    if squeezed.place is None or not system.weight.any():
        return squeezed
    p, w, watch = system.parts, system.load(system.weight), system.watch
    width = 1 + len(p.E) + len(p.G) + len(p.rows)
    free = watch._replace(rows=watch.rows[:0], level=watch.level[:0])
    log, path = np.empty((EVENTS, 3)), np.empty((EVENTS, width))
    status, factor, _, _, count = trace(p, squeezed.place, w, 1.0, free, none_known(p), log, path)
    rests = resting_stage(system.spec)
    if status in (GIVES_UP, TURNS):
        return _followed(system, ("squeeze", rests))
    if status != REACHED:
        share = f"{factor:.0%}" if factor > 0.0 else "nothing"
        return Start(None, f"{alone(rests.name)} is not held: the grasp holds {share} of it")
    return squeezed._replace(path=path[:count].copy())


def slip_shares(system: System, begun: Start, max_slip: Array) -> tuple[Array, Array]:
    """What `slides_at` takes: one over how far contacts may slide, max_slip (n,) [m], in natural units (m,); and how
    far they slid under the weight alone, as a share of that (n,).
    """
    scene, p = system.scene, system.parts
    per_slip = np.zeros(scene.components)
    per_slip[: 3 * scene.n].reshape(-1, 3)[:, :2] = scene.units.motion_unit / max_slip[:, None]
    if scene.scale is not None:
        per_slip /= scene.scale
    slid = np.zeros(scene.n)
    if len(begun.path):
        slides_at(p, per_slip[scene.kind.index], slid, begun.path, np.empty(begun.path.shape[1]), False)
    return np.ascontiguousarray(per_slip[scene.kind.index]), slid


def _squeezed(system: System) -> Start:
    """The place after the squeeze, with no load."""
    spec, scene = system.spec, system.scene
    size = float(abs(spec.positions - spec.positions.mean(axis=0)).max(initial=0.0))
    sags = any(isinstance(e, FingerWeight) and e.sags for e in spec.effects)
    alone = spec.replace(wrench=read_only(np.zeros(6)))
    if not sags and not _pushes(spec):
        return Start(_place(system, np.zeros(scene.components), np.zeros(6), {}), "")
    if not sags and not (spec.offset[:, 2] > _NONE * size).any():
        found = solve_spec(alone, system.section, proof=False)
        # the force of a contact that slides depends on its path
        stays = found.held and SLIDING not in contact_statuses(found.contact_state)
        if stays and abs(found.forces).max() > _ON * scene.units.force_unit:
            return Start(_from_solution(system, found), "")
    return _followed(system, ("squeeze",))


def _followed(system: System, order: tuple[str | Stage, ...]) -> Start:
    """The place after stages that are followed in steps."""
    scene = system.scene
    loading = follow(system.spec, system.section, np.zeros(6), order, "fixed", 40, None)
    if not loading.reached:
        return Start(None, f"{alone(str(loading.lost_stage))} is not held: {loading.why.partition(': ')[2]}")
    last = loading.last
    forces = np.concatenate([last.read.forces.reshape(-1), last.read.torsion[list(scene.soft)]])
    return Start(_place(system, scene.forces_to_law_axes(forces), last.where.pose, {}), "")


def _pushes(spec: GraspSpec) -> bool:
    """Whether anything squeezes the object: a preload, tips that are moved along it, joints that are commanded."""
    command = find_command(spec.effects)
    commanded = command is not None and bool(command.command.any())
    return bool(spec.offset[:, :2].any() or (spec.offset[:, 2] < 0.0).any() or commanded)


def _from_solution(system: System, found: GraspSolution) -> Place:
    scene = system.scene
    torsion = np.zeros(0) if found.torsion is None else found.torsion[list(scene.soft)]
    forces = scene.forces_to_law_axes(np.concatenate([found.forces.reshape(-1), torsion]))
    return _place(system, forces, found.object_displacement, found.extra)


def _place(system: System, components: Array, displacement: Array, extra: dict[str, Array]) -> Place:
    """From forces (c,) in the laws' coordinates and the object's motion about the reference, SI."""
    scene, units = system.scene, system.scene.units
    r = components[scene.kind.index] / units.force_unit
    u = scene.natural_twist(shift_twist(displacement, units.centre - system.spec.reference))
    give = np.zeros(len(system.parts.rows))
    if extra and system.limits:
        give = np.concatenate([limit.natural_motion(scene, extra) for limit in system.limits])
    return place_of(system, r, u, give)


def place_of(system: System, r: Array, u: Array, give: Array) -> Place:
    """From natural unknowns: forces (m,), which are changed where contacts are open, motion (dof,), limits (k,)."""
    scene, p, room = system.scene, system.parts, np.zeros(0)
    if system.limits:
        room = np.concatenate([limit.natural_room(scene) for limit in system.limits])
    v = p.E @ r + u @ p.G + give @ p.rows + scene.natural.d
    n, force, motion = len(p.mu), float(abs(r).max(initial=0.0)), max(1.0, float(abs(v).max(initial=0.0)))
    gap, closed = np.zeros(n), np.full(n, OPEN, dtype=np.int64)
    for i, j in enumerate(p.contacts[:, 0].tolist()):
        if r[j] > _ON * force:
            closed[i] = CLOSED
        elif v[j] <= _ON * motion:
            closed[i] = CLOSES if force == 0.0 else OPENS
            r[p.contacts[i][p.contacts[i] >= 0]] = 0.0
        else:
            gap[i] = v[j]
            r[p.contacts[i][p.contacts[i] >= 0]] = 0.0
    slack = room - p.rows @ r
    yields = np.where(give > _ON * motion, 1, np.where(slack <= _ON * force, 2, 0)) if len(give) else np.zeros(0)
    active = np.zeros(len(p.owner), dtype=np.int64)
    faces_reached(p, r, closed, active, _ON * force)
    return Place(r, u, gap, give, slack, closed, yields.astype(np.int64), active, active.copy())


# ----------------------------------------------------------------

_NOTHING = 1e-7  # of the squeeze: a smaller load is borne by the damper of loose motions


def watch_from(system: System, place: Place, allowed: Allowed) -> Watch:
    """What ends a path that begins at a place."""
    return system.watch._replace(start=system.watch.moves @ place.u, motion=allowed.motion, turn=allowed.turn)


def fixed_limit(
    spec: GraspSpec, section: Section, wrench: Array, allowed: Allowed, accuracy: float = ACCURACY
) -> LoadLimit:
    """The load limit under a wrench (6,). accuracy : as in `followed_limit`."""
    if not springs_alone(spec):
        return followed_limit(spec, section, wrench, allowed, "fixed", accuracy)
    system, begun = begun_of(spec, section, wrench)
    if begun.place is None:
        none = TracedPath(system, wrench, np.zeros((0, 1)), None)
        binds: tuple[Bind, ...] = (Bind(EQUILIBRIUM, OBJECT),)
        text = f"{told}; {begun.why}" if (told := describe_missing_squeeze(spec)) else begun.why
        return LoadLimit(0.0, wrench, binds, "fixed", _later(text, none, 0.0, 0.0, None, ()), accuracy=0.0)
    p, place = system.parts, begun.place
    watch = watch_from(system, place, allowed)
    log, points = np.empty((EVENTS, 3)), np.empty((EVENTS, 1 + len(p.E) + len(p.G) + len(p.rows)))
    w, known = system.load(wrench), none_known(p)
    status, factor, which, events, count = onward(
        p, place, w, system.load(system.weight), watch, system.sets, known, log, points
    )
    factor = over_nothing(factor, w, place)
    path = TracedPath(system, wrench, points[:count].copy(), place)
    if status == GIVES_UP:  # for example where a contact opens while it slides: small steps find the path
        return followed_limit(spec, section, wrench, allowed, "fixed", accuracy)
    if status == LOST and factor > 0.0 and not ends_plainly(system) and not path.ends():
        return followed_limit(spec, section, wrench, allowed, "fixed", accuracy)
    happened, then = events_of(system, log[:events]), ""
    kept = points_before_jump(p, watch.moves, length_of(spec.positions), points[:count])
    if kept < count:
        status, which, count, factor, then = LOST, -1, kept, float(points[kept - 1, 0]), "snaps to another place"
        place = slid_place(system, points[kept - 1])
        path = TracedPath(system, wrench, points[:count].copy(), place)
        happened = (*[e for e in happened if e.factor <= factor], LimitEvent("snaps", OBJECT, factor))
    binds = with_joints(system, binds_of(system, status, which, place.closed, place.active), place.yields)
    first = next((e.factor for e in happened if e.kind == "slips"), None)
    lost = None if not binds or binds[0].kind in (TORQUE, RANGE, MOTION) else factor
    at, slides = np.empty(points.shape[1]), None  # of where a contact has slid as far as it may
    per_slip, slid = slip_shares(system, begun, allowed.max_slip)
    endless = status == RAY and not np.isnan(points[count, 0])
    seen = points[: count + 1] if endless else points[:count]
    if factor > 0.0 and slides_at(p, per_slip, slid, seen, at, endless):
        slides, then = float(at[0]), ""
        factor = slides
        binds = slid_contacts(spec.names, slid)
        before = points[:count][points[:count, 0] < factor]
        whole = path if factor <= points[count - 1, 0] else None
        path = TracedPath(system, wrench, np.vstack([before, at]), slid_place(system, at), whole)
        happened += tuple([LimitEvent(SLIDES, one.who, factor) for one in binds])
    later = _later(explain_limit(binds, factor, wrench, spec, then), path, factor, lost, slides, happened)
    return LoadLimit(factor, wrench, binds, "fixed", later, first, slides, EVENT_TOLERANCE)


def springs_alone(spec: GraspSpec) -> bool:
    """Whether fingers give way as springs do, as a trace takes it; others are followed in steps."""
    return spec.mechanism is None or spec.mechanism.joint_model.is_elastic


def ends_plainly(system: System) -> bool:
    """Whether the end that a trace or a walk finds is the limit. With soft fingers or anisotropic friction one path in
    ten goes on in a way that neither of them finds.
    """
    return not system.scene.soft and not system.scene.anisotropic


def over_nothing(factor: float, w: Array, place: Place) -> float:
    """The factor on a load w (dof,); 0 where that load is so small beside the forces of the squeeze that numerical
    dampers alone may bear it.
    """
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
        return Rest(lost, marks, tuple(sorted(events, key=lambda e: e.factor)))

    return Later(lambda: text, path.arrays, path.solution, beyond, rest)
