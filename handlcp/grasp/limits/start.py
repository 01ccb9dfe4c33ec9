"""Where a path begins: the grasp squeezed, then its weight put on, before the load comes.

With fingertips that just touch, a squeeze that grows makes forces and slips that grow with it. So one solve of the
whole squeeze is the squeeze made slowly. Fingertips that are still apart, or sag, are followed in steps (`follow`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.kernels.happens import GIVES_UP, REACHED, TURNS
from handlcp.grasp.limits.kernels.parts import CLOSED, CLOSES, OPEN, OPENS, Place, none_known
from handlcp.grasp.limits.kernels.standing import faces_reached
from handlcp.grasp.limits.kernels.trace import EVENTS, trace
from handlcp.grasp.limits.system import System, system_of
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import shifted
from handlcp.grasp.path.follow import follow
from handlcp.grasp.path.program import Stage
from handlcp.grasp.solve.solve_spec import solve_spec

_NONE = 3e-5  # of the contacts' distances: fingertips no farther from the object touch, as in `StepGrasp`
_KEPT = 8  # grasps
_ON = 1e-9  # of the largest force or motion


class Start(NamedTuple):
    """place : with squeeze and weight; None where they are not held, and why."""

    place: Place | None
    why: str


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
    return replace(system, parts=parts), Start(place, start.why)


@lru_cache(maxsize=_KEPT)
def _kept(spec: GraspSpec, section: Section) -> tuple[System, Start] | None:
    """None: neither squeeze nor weight, and the load sets the units."""
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
    status, factor, *_ = trace(p, squeezed.place, w, 1.0, free, none_known(p), log, path)
    if status in (GIVES_UP, TURNS):
        return _followed(system, ("squeeze", Stage("weight", weight=1.0)))
    if status != REACHED:
        share = f"{factor:.0%}" if factor > 0.0 else "nothing"
        return Start(None, f"the weight alone is not held: the grasp holds {share} of it")
    return squeezed


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
        stays = "sliding" not in found.contact_state  # what slides remembers its way
        if found.held and stays and abs(found.forces).max() > _ON * scene.units.force:
            return Start(_from_solution(system, found), "")
    return _followed(system, ("squeeze",))


def _followed(system: System, order: tuple[str | Stage, ...]) -> Start:
    """The place after stages that are followed in steps."""
    scene = system.scene
    loading = follow(system.spec, system.section, np.zeros(6), order, "fixed", 40, None)
    if not loading.reached:
        return Start(None, f"the {loading.lost_stage} alone is not held: {loading.why.partition(': ')[2]}")
    last = loading.last
    forces = np.concatenate([last.read.forces.reshape(-1), last.read.torsion[list(scene.soft)]])
    return Start(_place(system, scene.lawful(forces), last.where.pose, {}), "")


def _pushes(spec: GraspSpec) -> bool:
    """Whether anything squeezes the object: a preload, tips that are moved along it, joints that are commanded."""
    commands = [e.command for e in spec.effects if isinstance(e, JointOffset)]
    return bool(spec.offset[:, :2].any() or (spec.offset[:, 2] < 0.0).any() or any(c.any() for c in commands))


def _from_solution(system: System, found: GraspSolution) -> Place:
    scene = system.scene
    torsion = np.zeros(0) if found.torsion is None else found.torsion[list(scene.soft)]
    forces = scene.lawful(np.concatenate([found.forces.reshape(-1), torsion]))
    return _place(system, forces, found.object_displacement, found.extra)


def _place(system: System, components: Array, displacement: Array, extra: dict[str, Array]) -> Place:
    """From forces (c,) in the laws' coordinates and the object's motion about the reference, SI."""
    scene, units = system.scene, system.scene.units
    r = components[scene.kind.index] / units.force
    u = scene.natural_twist(shifted(displacement, units.centre - system.spec.reference))
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
