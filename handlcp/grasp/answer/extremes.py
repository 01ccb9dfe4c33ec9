"""The least and the largest of linear readings of the forces over the equilibria that keep an answer's contact states.

Each is the end of a program over a `Family`: a linear one on pyramids and in a plane, by HiGHS; one with second-order
cones on the exact cone, by Clarabel. Either is believed only as far as its multipliers prove it (`verify/conic`). What
the equations determine needs no program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools
from handlcp.grasp.answer.family import Family, Kept, Ranges, families
from handlcp.grasp.friction import Cone, limit_set
from handlcp.grasp.verify.conic import ENDED, UNBOUNDED, Cones, Conic, judged, solve_conic
from handlcp.progress import tick

_DETERMINED = 1e-9  # of a reading's size: directions that change it by less leave it as it is
_TIGHT = 1e-10  # the least that HiGHS can be asked for
_LOOSE = 1e-7  # a gap above this: the cones are tried as polygons around them, too


@dataclass(frozen=True, slots=True, eq=False)
class Extremes:
    """Of p readings: change (p, 2), by how much they may be less (≤ 0) and more (≥ 0) than at the answer; -inf and inf
    where nothing bounds them, or no method found what does. wider (n,) : as in `Family`, of any of them. gap : the
    largest, relative to the larger of a change and the unit.
    """

    change: Array
    wider: Bools
    gap: float


def extremes(kept: Kept, readings: Array, ranges: Ranges | None) -> Extremes:
    """Of readings (p, c) of the forces, in the laws' coordinates; changes in natural units of force."""
    change, gap = np.zeros((len(readings), 2)), 0.0
    wider = np.zeros(kept.scene.n, dtype=bool)
    sizes = abs(readings).max(axis=1, initial=0.0)
    for family in families(kept, ranges):
        along = readings @ family.basis
        moves = abs(along).max(axis=1, initial=0.0) > _DETERMINED * sizes
        if moves.any():
            wider |= family.wider
        for k in np.flatnonzero(moves):
            for side, sign in enumerate((-1.0, 1.0)):
                most, off = _most(family, sign * along[k] / sizes[k])
                change[k, side] = sign * max(sign * change[k, side], most * sizes[k])
                gap = max(gap, off)
            tick(f"{k + 1} of {len(readings)}")
    return Extremes(change, wider, gap)


def _most(family: Family, along: Array) -> tuple[float, float]:
    """The largest along · y of a family, with its gap."""
    program = Conic(-along, np.zeros((1, 0, len(along))), np.zeros((1, 0)), family.G, family.h[None], family.cones)
    flat = not family.cones.more
    ends = [_by_simplex] if flat else [_by_interior_points, _around]
    best = np.inf, np.inf
    for method in [*ends, *([_by_interior_points] if flat else [])]:
        status, value, gap = method(program)
        if status == UNBOUNDED:
            return np.inf, 0.0
        if status == ENDED and gap < best[1]:  # not to be less than what is possible
            best = max(value, 0.0) + gap * max(1.0, abs(value)), gap
        if best[1] <= _LOOSE:
            break
    return best


def _by_interior_points(program: Conic) -> tuple[int, float, float]:
    """(status, the largest, gap)."""
    found = solve_conic(program)
    return int(found.status[0]), -float(program.c @ found.x[0]), float(found.gap[0])


def _by_simplex(program: Conic) -> tuple[int, float, float]:
    """The same of a linear program."""
    from scipy.optimize import linprog  # half a second of import that only open forces should pay

    asked = {"primal_feasibility_tolerance": _TIGHT, "dual_feasibility_tolerance": _TIGHT}
    G, h = program.G, program.h[0]
    if not len(G):
        return UNBOUNDED, np.inf, 0.0
    found = linprog(program.c, G, h, bounds=(None, None), method="highs", options=asked)
    if found.status != 0:
        return -1, np.inf, np.inf  # without an end: the other method proves it
    status, gap, _ = judged(program, 0, found.x, np.zeros(0), -found.ineqlin.marginals, h - G @ found.x)
    return status, -float(program.c @ found.x), gap


def _around(program: Conic) -> tuple[int, float, float]:
    """The same of a program with polygons and polyhedra around its cones, which bounds it from outside."""
    at, rows, room = program.cones.linear, [program.G[: program.cones.linear]], [program.h[0, : program.cones.linear]]
    for d, count in program.cones.more:
        normals = np.column_stack(
            [-np.ones(limit_set(Cone(), d - 1).normals.shape[1]), limit_set(Cone(), d - 1).normals.T]
        )
        for _ in range(count):
            rows.append(-normals @ program.G[at : at + d])
            room.append(-normals @ program.h[0, at : at + d])
            at += d
    G, h = np.concatenate(rows), np.concatenate(room)
    return _by_simplex(Conic(program.c, program.A, program.b, G, h[None], Cones(len(G), ())))
