"""A path that was followed, as arrays in SI, and its end as a certified solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.failure.failure_mode import EQUILIBRIUM, MOTION, OBJECT, OPENS, SLIPS, TORQUE, Bind
from handlcp.grasp.limits.kernels.happens import GIVES_UP, RAY, REACHED, WATCHED
from handlcp.grasp.limits.kernels.onward import is_sound
from handlcp.grasp.limits.kernels.parts import CLOSED, OPENS as TOUCHES_LAST, Place
from handlcp.grasp.limits.result import LimitEvent, LimitPath
from handlcp.grasp.limits.system import System
from handlcp.grasp.model.contact import Placement, shift_twist
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.solve_spec import certify_known_answer, solve_spec
from handlcp.lcp import Auto
from handlcp.tolerances import CERTIFY_TOLERANCE

# ----------------------------------------------------------------
# What binds at the end of a path in one posture, and what happens on the way, by name.

_KINDS = ("slips", "sticks", "opens", "touches", "yields", "holds")


def binds_of(system: System, status: int, which: int, closed: Ints, active: Ints) -> tuple[Bind, ...]:
    """What binds at the end of a path. status, which : as `trace` returns them; closed (n,), active (f,) : of the place
    where it ended.

    Where contact forces cannot change so as to balance more load, what binds are the contacts that open there; if none
    does, all that slide; if none does that either, balance itself.
    """
    if status in (RAY, REACHED, GIVES_UP):
        return ()
    if status == WATCHED:
        if which >= len(system.watched):
            return (Bind(MOTION, OBJECT),)
        return (Bind(*system.watched[which]),)
    names, p = system.spec.names, system.parts
    if opened := [i for i in range(len(p.mu)) if closed[i] == TOUCHES_LAST]:
        return tuple([Bind(OPENS, names[i]) for i in opened])
    sliding = sorted({int(i) for i, on in zip(p.owner, active, strict=True) if on and closed[i] == CLOSED})
    return tuple([Bind(SLIPS, names[i]) for i in sliding]) or (Bind(EQUILIBRIUM, OBJECT),)


def events_of(system: System, log: Array) -> tuple[LimitEvent, ...]:
    """From the rows that `trace` writes."""
    names = system.spec.names
    rows = _limited(system) if system.limits else ()
    called = [(factor, int(kind), (names if kind < 4 else rows)[int(who)]) for factor, kind, who in log.tolist()]
    return tuple([LimitEvent(_KINDS[kind], who, factor) for factor, kind, who in called])


def with_joints(system: System, binds: tuple[Bind, ...], yields: Ints) -> tuple[Bind, ...]:
    """The joints that yield, where no contact gives out. yields (k,) : as a `Place` has it."""
    if not len(yields) or binds != (Bind(EQUILIBRIUM, OBJECT),) or system.spec.mechanism is None:
        return binds
    joints = system.spec.mechanism.names
    rows = zip(_limited(system), yields.tolist(), strict=True)
    return (
        tuple([Bind(TORQUE, who) for who in dict.fromkeys([who for who, on in rows if on and who in joints])]) or binds
    )


def _limited(system: System) -> tuple[str, ...]:
    """(k,) whom each limit is of: a joint, a finger, or the title of a bound on several."""
    spec, scene, found = system.spec, system.scene, list[str]()
    for e in spec.effects:
        for limit in e.present(scene):
            if isinstance(e, TorqueSaturation):
                joints, _, limited = e.limited(scene)
                found += [joints.names[j] for j in limited]
                continue
            for row in limit.rows[:, : 3 * scene.n]:
                pressed = np.flatnonzero(row.reshape(-1, 3).any(axis=1))
                found.append(spec.names[int(pressed[0])] if len(pressed) == 1 else f"the {e.title}")
    return tuple(found)


# ----------------------------------------------------------------

_ALL = Auto(search_seconds=0.0)
_MORE = 1e-3  # load, where a path seems to end


@dataclass(frozen=True, eq=False)
class _Moved(Effect):
    """How far slips and turns before the last step have moved the contacts. It has no title, so that no list of effects
    shows it.
    """

    shift: Array

    by_name = False

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        return self.shift


@dataclass(frozen=True, eq=False)
class TracedPath:
    """A path of a system under a load: points (k, 1 + m + dof + limits) as `trace` writes them, place at its end;
    None: squeeze or weight alone are not held, and there are no points. whole : what it is the first part of.
    """

    system: System
    wrench: Array
    points: Array
    place: Place | None
    whole: TracedPath | None = None

    @property
    def sound(self) -> bool:
        """Whether its end obeys balance, contact and friction as closely as a certifier asks."""
        system, place = self.system, self.place
        if place is None or not np.isfinite(self.points[-1]).all():
            return False
        load = system.load(system.weight + float(self.points[-1, 0]) * self.wrench)
        return is_sound(system.parts, place, load, CERTIFY_TOLERANCE)

    def arrays(self) -> LimitPath:
        """In SI, for users."""
        system, m, dof = self.system, len(self.system.parts.E), len(self.system.parts.G)
        scene, count = system.scene, len(self.points)
        forces, torques, moved = np.empty((count, scene.n, 3)), [], np.empty((count, 6))
        for k, point in enumerate(self.points):
            components = self._components(point[1 : 1 + m])
            physical = scene.forces_to_contact_axes(components)
            forces[k] = physical[: 3 * scene.n].reshape(-1, 3)
            moved[k] = self._motion(point[1 + m : 1 + m + dof])
            joints = system.spec.mechanism
            torques.append(
                np.zeros(0)
                if joints is None
                else physical @ joints.jacobian_rows(scene.soft) + scene.bias_torque_or_zero
            )  # fmt: skip
        return LimitPath(*(read_only(a) for a in (self.points[:, 0].copy(), forces, np.array(torques), moved)))

    def solution(self) -> GraspSolution:
        """The end of the path, certified."""
        system, place = self.system, self.place
        if place is None:
            held = system.spec.replace(wrench=read_only(system.weight))
            return solve_spec(held, system.section, proof=False)
        scene, p, factor = system.scene, system.parts, float(self.points[-1, 0])
        m, dof = len(p.E), len(p.G)
        v = self._motions(self.points[-1])
        change = v - self._motions(self.points[-2]) if len(self.points) > 1 else np.zeros(m)
        slip = np.zeros(m)
        for i, row in enumerate(p.contacts):
            own = row[1:][row[1:] >= 0]
            slides = [f for f in range(len(p.owner)) if p.owner[f] == i and place.slides[f]]
            if row[0] < 0:
                continue
            if place.closed[i] == CLOSED and slides:
                size = float(np.linalg.norm(change[own]))
                round_ = p.moving[slides[0]]
                slip[own] = -size * place.r[own] / np.linalg.norm(place.r[own]) if round_ else change[own]
            elif place.closed[i] != CLOSED:
                slip[row[0]], slip[own] = place.gap[i], change[own]
        d = np.zeros(scene.components)
        d[scene.kind.index] = (slip - v - scene.natural.d) * scene.units.motion_unit
        spec = system.spec.replace(
            wrench=read_only(system.weight + factor * self.wrench),
            effects=(*system.spec.effects, _Moved(scene.motions_to_contact_axes(d))),
        )
        point = self.points[-1]
        candidate = SolverCandidate(
            self._components(point[1 : 1 + m]), scene.twist(point[1 + m : 1 + m + dof]),
            self._extra(point[1 + m + dof :]), len(scene.soft),
        )  # fmt: skip
        return certify_known_answer(spec, build_scene(spec), system.section, candidate, "the end of a path")

    def ends(self) -> bool:
        """Whether no solver finds an equilibrium under slightly more load, started from the contact states at the
        path's end.
        """
        system, place = self.system, self.place
        if place is None or place.give.any():
            return True
        scene, p = system.scene, system.parts
        slip = np.zeros(len(p.E))
        for i, row in enumerate(p.contacts):
            if row[0] >= 0 and place.closed[i] != CLOSED:
                slip[row[0]] = place.gap[i]
        d = np.zeros(scene.components)
        d[scene.kind.index] = (slip - self._motions(self.points[-1]) - scene.natural.d) * scene.units.motion_unit
        spec = system.spec.replace(
            wrench=read_only(system.weight + (1.0 + _MORE) * float(self.points[-1, 0]) * self.wrench),
            effects=(*system.spec.effects, _Moved(scene.motions_to_contact_axes(d))),
        )
        return not solve_spec(spec, system.section, _ALL).held

    def _extra(self, give: Array) -> dict[str, Array]:
        """By name, SI, how far limits give way."""
        found, at = dict[str, Array](), 0
        for limit in self.system.limits:
            s = give[at : at + len(limit.room)] * self.system.scene.units.motion_unit
            found[limit.name] = s if limit.levers is None else s / limit.levers
            at += len(limit.room)
        return found

    def _motions(self, point: Array) -> Array:
        """(m,) Gᵀu + E r + Aᵀ s."""
        p = self.system.parts
        m, dof = len(p.E), len(p.G)
        moved = p.E @ point[1 : 1 + m] + point[1 + m : 1 + m + dof] @ p.G + point[1 + m + dof :] @ p.rows
        return np.asarray(moved)

    def _components(self, r: Array) -> Array:
        out = np.zeros(self.system.scene.components)
        out[self.system.scene.kind.index] = r * self.system.scene.units.force_unit
        return out

    def _motion(self, u: Array) -> Array:
        scene = self.system.scene
        return shift_twist(scene.twist(u), self.system.spec.reference - scene.units.centre)
