"""A grasp to load, here and in MuJoCo, and how near the two have to be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.simulator import compare

# Of the largest force or torque. A jump is fast: where friction ends behind it is no question of statics.
NEAR = {"sticks": 0.01, "slides": 0.03, "jumps": 0.1}
LIMIT = 0.03  # of the load at which the object is lost


@dataclass(frozen=True)
class Case:
    """kind : "sticks", "slides" and "jumps" are held, and compared at the end; "lost": both lose it, in the same stage;
    "limit": at the same load, too.

    make : the grasp. load (6,), order : of `follow`, when given. seconds : of each stage in MuJoCo.
    short : whether the default suite runs it.
    """

    name: str
    hand: str
    kind: str
    make: Callable[[], Any]
    load: Any = None
    order: Any = ("squeeze", "load")
    seconds: float = 2.0
    short: bool = False

    def run(self, seconds=None):
        """Both, MuJoCo with so many seconds for each stage, or its own."""
        time = self.seconds if seconds is None else seconds
        return compare(self.make(), self.load, self.order, seconds=time)


def misses(case, found):
    """What is not as it has to be, in words; nothing where all is well."""
    ours, theirs = found.loading, found.simulation
    held = case.kind in NEAR
    wrong = [f"{who} {'lost' if held else 'held'} it" for who, h in (("handlcp", ours.held), ("MuJoCo", theirs.held))
             if h != held]  # fmt: skip
    if wrong:
        return wrong
    if held:
        near = NEAR[case.kind]
        errors = {"forces": found.force_error, "torques": found.torque_error}
        return [f"{what} {100 * e:.2g} % off" for what, e in errors.items() if not e <= near]
    if ours.lost_stage != theirs.lost_stage:
        return [f"handlcp lost it in {ours.lost_stage!r}, MuJoCo in {theirs.lost_stage!r}"]
    if case.kind == "limit" and not abs(limit_error(found)) <= LIMIT:
        return [f"load limit {100 * limit_error(found):+.2g} % off"]
    return []


def limit_error(found):
    """By how much the share of the load is off at which handlcp loses the object; NaN where one holds it."""
    ours, theirs = found.loading.lost_at, found.simulation.lost_at
    return float("nan") if ours is None or theirs is None else (ours - theirs) / max(theirs, 1e-9)


def closing(grasp, depth):
    """The same with joints commanded so that the tips would move so far along their normals [m], the smallest way."""
    k = len(grasp.fingertips)
    normal = grasp.jacobian[2 : 3 * k : 3]
    return grasp.replace(joint_offset=np.linalg.lstsq(normal, np.full(k, depth), rcond=None)[0])
