"""What binds at the end of a path in one posture, and what happens on the way, by name."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.cause.cause import EQUILIBRIUM, MOTION, OBJECT, OPENS, SLIPS, TORQUE, Bind
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.limits.kernels.happens import GIVES_UP, RAY, REACHED, WATCHED
from handlcp.grasp.limits.kernels.parts import CLOSED
from handlcp.grasp.limits.kernels.parts import OPENS as TOUCHES_LAST
from handlcp.grasp.limits.result import LimitEvent
from handlcp.grasp.limits.system import System

_KINDS = ("slips", "sticks", "opens", "touches", "yields", "holds")


def binds_of(system: System, status: int, which: int, closed: Ints, active: Ints) -> tuple[Bind, ...]:
    """status, which : as `trace` returns them; closed (n,), active (f,) : of the place where it ended.

    Where no rates exist that balance more load: the contacts that open there; if there are none, all that slide; if
    there are none either, balance itself.
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
