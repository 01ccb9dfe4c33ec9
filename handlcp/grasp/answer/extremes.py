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
_ENOUGH = 1e-10  # a gap above this: planes around the cones are tried, too
_CUTS = 4  # how often more of them are added


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
    """The largest along · y of a family, from outside, with its gap."""
    program = Conic(-along, np.zeros((1, 0, len(along))), np.zeros((1, 0)), family.G, family.h[None], family.cones)
    if not family.cones.more and (end := _by_simplex(program)) is not None:
        return end[:2]
    found = solve_conic(program)
    if found.status[0] == UNBOUNDED:
        return np.inf, 0.0
    best = np.inf, np.inf
    if found.status[0] == ENDED:
        best = _outside(float(along @ found.x[0]), float(found.gap[0]))
    return best if best[1] <= _ENOUGH or not family.cones.more else _around(program, found.x[0], best)


def _outside(value: float, gap: float) -> tuple[float, float]:
    """(value, gap) with a value that is no less than what is possible; 0 is."""
    return max(value, 0.0) + gap * max(1.0, value), gap


def _by_simplex(program: Conic) -> tuple[float, float, Array] | None:
    """(value, gap, y) of a linear program; None: no end was found, and the other method proves that there is none."""
    from scipy.optimize import linprog  # half a second of import that only open forces should pay

    asked = {"primal_feasibility_tolerance": _TIGHT, "dual_feasibility_tolerance": _TIGHT}
    G, h = program.G, program.h[0]
    if not len(G):
        return np.inf, 0.0, np.zeros(0)
    found = linprog(program.c, G, h, bounds=(None, None), method="highs", options=asked)
    if found.status != 0:
        return None
    status, gap, _ = judged(program, 0, found.x, np.zeros(0), -found.ineqlin.marginals, h - G @ found.x)
    return (*_outside(-float(found.fun), gap), found.x) if status == ENDED else None


def _around(program: Conic, y: Array, best: tuple[float, float]) -> tuple[float, float]:
    """A better bound than `best` of interior points, where there is one: by planes around the cones. They touch these
    where the forces of y are, then where they are at the largest that these planes allow (Kelley's cutting planes), and
    bound from outside whatever y is.
    """
    first, where, G, h = program.cones.linear, list[tuple[int, int]](), program.G, program.h[0]
    for d, count in program.cones.more:
        where += [(first + d * k, d) for k in range(count)]
        first += d * count
    inside = max(best[0] - best[1] * max(1.0, best[0]), 0.0) if np.isfinite(best[0]) else 0.0
    rows, room = [G[: program.cones.linear]], [h[: program.cones.linear]]
    for turn in range(_CUTS):
        s = h - G @ y
        for first, d in where:
            own, t = slice(first, first + d), s[first + 1 : first + d]
            normals = limit_set(Cone(), d - 1).normals.T if turn == 0 else np.zeros((0, d - 1))
            if (size := float(np.linalg.norm(t))) > 0.0:
                normals = np.concatenate([normals, t[None] / size])
            planes = np.column_stack([-np.ones(len(normals)), normals])
            rows.append(-planes @ G[own])
            room.append(-planes @ h[own])
        flat = np.concatenate(rows)
        lines = Conic(program.c, program.A, program.b, flat, np.concatenate(room)[None], Cones(len(flat), ()))
        end = _by_simplex(lines)
        if end is None:
            break
        value, _, y = end
        inside = max(inside, _within(program, y) * float(-program.c @ y))
        if value < best[0] or inside > best[0]:  # what interior points said is no bound where more is within the cones
            best = value, max(value - inside, 0.0) / max(1.0, value)
        if best[1] <= _ENOUGH:
            break
    return best


def _within(program: Conic, y: Array) -> float:
    """The largest share, at most 1, of the way from the answer, where y is 0, that stays within all cones."""
    cones, change, h = program.cones, program.G @ y, program.h[0]
    share, first = 1.0, cones.linear
    falls = change[:first] > 0.0
    share = min(share, float((h[:first][falls] / change[:first][falls]).min(initial=1.0)))
    for d, count in cones.more:
        for _ in range(count):
            a, b = h[first : first + d], -change[first : first + d]
            first += d
            # |a_u + x b_u| = a_t + x b_t: the first x > 0 at which the way leaves the cone
            two, one = float(b[1:] @ b[1:] - b[0] ** 2), 2.0 * float(a[1:] @ b[1:] - a[0] * b[0])
            zero = min(float(a[1:] @ a[1:] - a[0] ** 2), 0.0)
            ends = np.roots([two, one, zero])
            real = ends[np.isreal(ends)].real
            share = min(share, float(real[real > 0.0].min(initial=1.0)))
            if a[0] + share * b[0] < 0.0:
                return 0.0
    return max(share, 0.0)
