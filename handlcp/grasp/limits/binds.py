"""What binds at the end of a path, by name, and the sentence that says so."""

from __future__ import annotations

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints
from handlcp.grasp.limits.kernels.happens import RAY, REACHED, WATCHED
from handlcp.grasp.limits.kernels.parts import CLOSED
from handlcp.grasp.limits.kernels.parts import OPENS as TOUCHES_LAST
from handlcp.grasp.limits.result import (
    EQUILIBRIUM,
    MOTION,
    OBJECT,
    OPENS,
    RANGE,
    SLIPS,
    TORQUE,
    Bind,
    LimitEvent,
)  # fmt: skip
from handlcp.grasp.limits.system import System

__all__ = ["binds_of", "events_of", "why_of"]

_MOST = 4  # names in a sentence
_STRAIGHT = 1e-9  # of a load: less of it across an axis is none
_KINDS = ("slips", "sticks", "opens", "touches", "yields", "holds")


def binds_of(system: System, status: int, which: int, closed: Ints, active: Ints) -> tuple[Bind, ...]:
    """status, which : as `trace` returns them; closed (n,), active (f,) : of the place where it ended."""
    if status in (RAY, REACHED):
        return ()
    if status == WATCHED:
        if which >= len(system.watched):
            return (Bind(MOTION, OBJECT),)
        return (Bind(*system.watched[which]),)
    names, p = system.spec.names, system.parts
    opened = [i for i in range(len(p.mu)) if closed[i] == TOUCHES_LAST]
    if opened:
        return tuple([Bind(OPENS, names[i]) for i in opened])
    loaded = [i for i in range(len(p.mu)) if closed[i] == CLOSED]
    sliding = sorted({int(i) for i, on in zip(p.owner, active, strict=True) if on})
    slippery = [i for i in loaded if i in sliding or not (p.contacts[i, 1:] >= 0).any()]
    if sliding and slippery == loaded:
        return tuple([Bind(SLIPS, names[i]) for i in sliding])
    return (Bind(EQUILIBRIUM, OBJECT),)


def events_of(system: System, log: Array) -> tuple[LimitEvent, ...]:
    """From the rows that `trace` writes."""
    names = system.spec.names
    rows = [row for limit in system.limits for row in [limit.name] * len(limit.room)]
    called = [(factor, int(kind), (names if kind < 4 else rows)[int(who)]) for factor, kind, who in log.tolist()]
    return tuple([LimitEvent(_KINDS[kind], who, factor) for factor, kind, who in called])


def why_of(factor: float, wrench: Array, binds: tuple[Bind, ...]) -> str:
    """One sentence."""
    if not binds:
        return "nothing binds, however large the load"
    amount = _amount(factor * wrench)
    who, kind = _listed([b.who for b in binds]), binds[0].kind
    many = len(binds) > 1
    said = {
        SLIPS: f"{who} {'slip' if many else 'slips'} through",
        OPENS: f"{who} {'let' if many else 'lets'} go, and nothing balances the load",
        TORQUE: f"{who} {'reach their torque limits' if many else 'reaches its torque limit'}",
        RANGE: f"{who} {'reach the ends of their ranges' if many else 'reaches the end of its range'}",
        EQUILIBRIUM: "the forces can no longer balance the load",
        MOTION: "the object has moved as far as was allowed",
    }[kind]
    return f"at {factor:.4g} × the load{amount}: {said}"


def _listed(names: list[str]) -> str:
    """Such as "a, b and c"."""
    told, more = (names, 0) if len(names) <= _MOST else (names[: _MOST - 1], len(names) - _MOST + 1)
    if more:
        return f"{', '.join(told)} and {more} more"
    return told[0] if len(told) == 1 else f"{', '.join(told[:-1])} and {told[-1]}"


def _amount(load: Array) -> str:
    """Such as ", 12.3 N along +x", ", 0.4 N·m about -z"."""
    parts = []
    for part, of, how in ((load[:3], words.force, "along"), (load[3:], words.torque, "about")):
        if (size := float(np.linalg.norm(part))) > 0.0:
            axis = int(abs(part).argmax())
            straight = abs(part[axis]) >= (1.0 - _STRAIGHT) * size
            where = f" {how} {'+' if part[axis] > 0 else '-'}{'xyz'[axis]}" if straight else ""
            parts.append(f"{of(size)}{where}")
    return f", {' and '.join(parts)}" if parts else ""
