"""One objective: from a good design uphill by its derivatives, with scipy's SLSQP.

What a hand holds is the least of many loads, and has a kink where two of them tie. So the program that is solved has
one number more, and no kink there:

    most t    with t ≤ y_k(u) of each load k,    m(u) ≥ 0 of each requirement,    u in the cube

in rounds, each in a box around the best design so far, with the grasps that this one started from. A round that brings
nothing is tried in a smaller box.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import scipy

from handlcp.check import Array
from handlcp.design.brief import Brief
from handlcp.design.evaluation import Requirement
from handlcp.design.optimise.aims import Aim, brief_needs, margin, margins, meets
from handlcp.design.optimise.slopes import FACTOR, PAYLOAD, Gradient, Wanted, gradient, places, sample
from handlcp.design.optimise.trials import Spent, Trials, searched
from handlcp.design.space import Choices, Range
from handlcp.design.sweep.work import Row, packed
from handlcp.studies.payload.largest_mass import ANY

_BOXES = 0.25, 0.06  # half the side of a round's box
_BETTER = 2e-3  # relative: less is no progress
_UNTIL = 1.6  # times the least: loads are followed no further in a round
_NEAR = 1.2  # times the least: loads that hold less have derivatives
_ACTIVE = 0.3  # margin: requirements that are nearer have derivatives
_INSIDE = 2e-3  # margin that is kept: to be met in spite of rounding and rough paths
_FAILED = -1.0
_TOPS = 3  # designs of the samples from which it goes uphill, for each combination of choices
_STEPS = 8  # of a round
_CLOSE = 2e-3  # of the cube's side: a search along a line that comes so near to where it was has nothing to find
_SAMPLES, _MOST = 4, 64  # designs to start from: for each coordinate and combination of choices, and in all


def climb(trials: Trials, aim: Aim, needs: Sequence[Requirement], seed: int, start: Array | None) -> None:
    """Try designs until no more is gained, from a few starts for each choice. Raises Spent where the budget is over."""
    space = trials.space
    count = int(np.prod([len(e.values) for e in space.free.values() if isinstance(e, Choices)]))
    cube = space.sobol(min(_SAMPLES * len(space) * count, _MOST), seed)
    first = trials.tried(cube if start is None else np.vstack([start, cube]), {})
    if not space.ranges:
        return
    own = dict[Any, list[int]]()  # choices → designs with them, the best first
    for k in sorted(dict.fromkeys(first), key=lambda k: _order(trials.rows[k], aim, needs)):
        if np.isfinite(aim.of(trials.rows[k])):
            made = tuple(trials.values(k)[n] for n, e in space.free.items() if isinstance(e, Choices))
            own.setdefault(made, []).append(k)
    for k in [starts[top] for top in range(_TOPS) for starts in own.values() if top < len(starts)]:
        _uphill(trials, aim, needs, k)


def _order(row: Row, aim: Aim, needs: Sequence[Requirement]) -> tuple[bool, float, float]:
    """The best first: what meets all, then what misses least."""
    misses = -float(np.minimum(margins(row, needs), 0.0).sum())
    return not meets(row, needs), misses, -float(np.nan_to_num(aim.of(row), nan=-1e300))


def _uphill(trials: Trials, aim: Aim, needs: Sequence[Requirement], best: int) -> None:
    boxes = list(_BOXES)
    while True:
        around = _Round(trials, aim, needs, best)
        try:
            around.solve(boxes[0])
        except Spent:
            trials.tried(around.found[None], around.starts, last=True)
            raise
        k = trials.tried(around.found[None], around.starts)[0]
        if _gains(trials, aim, needs, k, best):
            best = k
            continue
        boxes = boxes[1:]
        if not boxes:
            return


def _gains(trials: Trials, aim: Aim, needs: Sequence[Requirement], k: int, best: int) -> bool:
    a, b = trials.rows[k], trials.rows[best]
    mine, old = _order(a, aim, needs), _order(b, aim, needs)
    if mine[:2] != old[:2]:
        return mine < old
    return aim.of(a) > aim.of(b) + _BETTER * abs(aim.of(b))


class _Close(Exception):
    """Points come no farther."""


class _Round:
    """SLSQP in a box around a design, with the grasps that it started from, or its own. found : the best point seen."""

    def __init__(self, trials: Trials, aim: Aim, needs: Sequence[Requirement], best: int) -> None:
        brief: Brief = trials.maker.asked(trials.values(best))
        self.trials, self.aim, self.number, self.u0 = trials, aim, best, trials.points[best]
        self.names = {n: i for i, (n, e) in enumerate(trials.space.free.items()) if isinstance(e, Range)}
        self.at, row = list(self.names.values()), trials.rows[best]
        self.starts = trials.started(best) | dict.fromkeys(searched(row), best)
        self.near = trials.near(self.starts)
        by_load = aim.sign > 0 and aim.name in (PAYLOAD, FACTOR) and brief.orientations != ANY
        alone = aim.name == FACTOR or (len(brief.objects) == 1 and not brief.loads)  # then more is more of the factor
        own = [need for need in brief_needs(brief) if not (by_load and alone and need.name == FACTOR)]
        self.needs = (*own, *needs)
        self.least = aim.of(trials.rows[best])
        numbers = tuple(dict.fromkeys(need.name for need in self.needs))
        self.whole = Wanted(
            aim.name if by_load else "", _UNTIL * self.least, None, numbers if by_load else (*numbers, aim.name)
        )
        self.seen = dict[bytes, _Point]()
        self.best, self.found = (-np.inf, -np.inf), self.u0

    def solve(self, box: float) -> None:
        """See points, of which `found` is then the best."""
        start, scale = self.u0[self.at], abs(self.least)
        low, high = np.maximum(start - box, 0.0), np.minimum(start + box, 1.0)
        there = self.point(start)
        if there is None:
            return
        keys = list(there.terms)

        def held(x: Array) -> Array:
            p = self.point(x[:-1])
            if p is None:
                return np.full(len(keys) + len(self.needs), _FAILED)
            return np.append([p.terms[key] / scale - x[-1] for key in keys], p.margins - _INSIDE)

        def rates(x: Array) -> Array:
            g = self.rates(x[:-1], keys)
            rows = [np.append(g.rates(key, list(self.names)) * self.sign(key) / scale, -1.0) for key in keys]
            for need in self.needs:
                way = (1.0 if need.comparison.startswith(">") else -1.0) / (abs(need.limit) or 1.0)
                rows.append(np.append(way * g.rates(need.name, list(self.names)), 0.0))
            return np.array(rows)

        with suppress(_Close):
            scipy.optimize.minimize(
                lambda x: -x[-1], np.append(start, min(there.terms.values()) / scale),
                jac=lambda x: -np.eye(len(x))[-1],
                bounds=[*zip(low, high, strict=True), (None, None)], method="SLSQP",
                constraints={"type": "ineq", "fun": held, "jac": rates}, options={"maxiter": _STEPS, "ftol": 1e-3},
            )  # fmt: skip

    def sign(self, key: str) -> float:
        """Of a term beside its number."""
        return self.aim.sign if key == self.aim.name else 1.0

    def full(self, x: Array) -> Array:
        """(d,) the point of the cube with these ranges."""
        u = self.u0.copy()
        u[self.at] = np.clip(x, 0.0, 1.0)
        return u

    def point(self, x: Array) -> _Point | None:
        """What a point holds; None where it holds nothing, or its grasps are lost."""
        u = self.full(x)
        if u.tobytes() not in self.seen:
            if self.seen and min(float(abs(u - np.frombuffer(v)).max()) for v in self.seen) < _CLOSE:
                raise _Close
            self.seen[u.tobytes()] = _Point(self, self.samples([u], self.whole)[0])
        found = self.seen[u.tobytes()]
        if not found.known:
            return None
        reached = float(found.margins.min(initial=0.0)), min(found.terms.values())
        if reached > self.best:
            self.best, self.found = reached, u
        return found

    def samples(self, cube: Sequence[Array], wanted: Wanted) -> list[dict[str, float | None]]:
        """Of points of the cube."""
        trials = self.trials
        starts = sorted(self.starts.items())
        key = repr((np.array(cube).tolist(), starts, wanted))

        def make() -> dict[str, Any]:
            maker = packed(trials.maker)
            tasks = [(maker, trials.space.point(u), self.near, wanted) for u in cube]
            found = dict(trials.sent(sample, tasks))
            return {"samples": [found[k] for k in range(len(tasks))]}

        done: list[dict[str, float | None]] = trials.kept(key, len(cube), make)["samples"]
        return done

    def rates(self, x: Array, keys: Sequence[str]) -> Gradient:
        """Of terms near the least, and of requirements that are near."""
        p, u = self.point(x), self.full(x)
        if p is None:
            return Gradient({}, {})
        least = min(p.terms.values())
        near = [key for key in keys if p.terms[key] <= least + (_NEAR - 1.0) * abs(least)]
        active = [n.name for n, m in zip(self.needs, p.margins, strict=True) if m < _ACTIVE]
        numbers = tuple(dict.fromkeys([*active, *([] if self.whole.aim else [self.aim.name])]))
        wanted = self.whole._replace(loads=tuple(near) if self.whole.aim else (), numbers=numbers)
        where = [(i, place) for i in self.at for place in places(u[i])]
        found = self.samples([_moved(u, i, place) for i, place in where], wanted)
        every = dict.fromkeys([*(near if self.whole.aim else ()), *numbers])
        g = gradient(self.names, u, dict(zip(where, found, strict=True)), p.sample, list(every))
        if (u == self.u0).all():
            self.trials.gradients[self.number] = {key: p.terms[key] for key in near}, g
        return g


def _moved(u: Array, i: int, place: float) -> Array:
    v = u.copy()
    v[i] = place
    return v


class _Point:
    """terms : more is wanted of the least of them. margins : of the requirements. sample : all numbers as they came."""

    def __init__(self, of: _Round, found: dict[str, float | None]) -> None:
        self.sample = found
        self.known = bool(found) and all(value is not None for value in found.values())
        known = {key: float(value) for key, value in found.items() if value is not None}
        terms = [key for key in known if ":" in key] if of.whole.aim else [of.aim.name]
        self.terms = {key: of.sign(key) * known[key] for key in terms if key in known}
        self.margins = np.array([margin(need, known.get(need.name, np.nan)) for need in of.needs])
