"""Many small conic programs that share their cones, solved together: linear rows and second-order cones.

    min cᵀx    A_k x = b_k,    G x + s = h_k,    s ∈ K = R₊^l × Q_3 × … × Q_4 × …

A predictor-corrector interior-point method with Nesterov and Todd's scaling on the homogeneous self-dual embedding: it
ends with an answer, with a ray along which the cost falls for ever, or with a proof that nothing fits. Every step is
taken for all programs that are not at their end. Source: Vandenberghe, The CVXOPT linear and quadratic cone program
solvers (2010); Andersen, Roos & Terlaky, Mathematical Programming 95 (2003).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.verify.cones import Scaling
from handlcp.grasp.verify.newton import Conic, Reduced, Whole

STOPPED, ENDED, UNBOUNDED, NOTHING_FITS = 0, 1, 2, 3
_MOST = 80  # steps; few programs take 25
_GAP = 1e-12  # relative: where a program is at its end
_NEAR, _SLOWER = 1e-9, 0.3  # or below this, where a step no longer makes it so many times what it was: rounding is left
_ENOUGH = 1e-5  # of a program whose steps have become too short: what still is an end
_PROOF = 1e-9  # how far a ray or a proof may miss its equations
_STALLED = 1e-9  # shorter steps than this lead nowhere
_TO_WALL = 0.99  # of the way to the cones' boundary


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Where p programs ended. status (p,) : one of the words above. x (p, v), s (p, m), z (p, m) multipliers of the
    rows, y (p, e) of the equations; of a ray where the status is UNBOUNDED. gap (p,) : what separates the cost from a
    lower bound on it, plus what equations are missed by, relative to the larger of one and the cost.
    """

    status: Ints
    x: Array
    y: Array
    s: Array
    z: Array
    gap: Array


class _Point(NamedTuple):
    """x (p, v), y (p, e), z (p, m), s (p, m), tau (p,), kappa (p,) of the embedding; or a step of them."""

    x: Array
    y: Array
    z: Array
    s: Array
    tau: Array
    kappa: Array

    def at(self, rows: Array | Ints | Bools) -> _Point:
        return _Point(*(a[rows] for a in self))

    def plus(self, step: _Point, alpha: Array) -> _Point:
        return _Point(*(a + (alpha[:, None] if a.ndim == 2 else alpha) * d for a, d in zip(self, step, strict=True)))


def solve_conic(programs: Conic) -> Ends:
    """All of them; where a program stops short of its end, the status says so and the gap how far.

    Where the short equations of a step lose too many digits, as where several contacts share what one of them could
    bear, a program starts again with the long ones.
    """
    p, e, v = programs.A.shape
    m = len(programs.G)
    ends = Ends(
        np.zeros(p, dtype=np.int64), np.full((p, v), np.nan), np.full((p, e), np.nan), np.full((p, m), np.nan),
        np.full((p, m), np.nan), np.full(p, np.inf),
    )  # fmt: skip
    _run(programs, np.arange(p), ends, Reduced)
    if (rest := np.flatnonzero(ends.gap > _NEAR)).size:
        _run(programs, rest, ends, Whole)
    return ends


def _run(programs: Conic, left: Ints, ends: Ends, equations: type[Reduced] | type[Whole]) -> None:
    """Steps of the programs in `left` until all are at an end, or get no nearer to theirs."""
    (_, e, v), unit = programs.A.shape, np.tile(programs.cones.unit, (len(left), 1))
    one = np.ones(len(left))
    point = _Point(np.zeros((len(left), v)), np.zeros((len(left), e)), unit.copy(), unit.copy(), one, one.copy())
    with np.errstate(all="ignore"):  # programs at the edge of rounding are told by what they miss
        for _ in range(_MOST):
            done = _record(programs, point, left, ends)
            left, point = left[~done], point.at(~done)
            if not len(left):
                return
            step, alpha = _step(programs.at(left), point, equations)
            moved = point.plus(step, alpha)
            usable = np.isfinite(alpha) & (alpha > _STALLED) & np.isfinite(moved.x).all(axis=1)
            left, point = left[usable], moved.at(usable)


def _record(programs: Conic, at: _Point, left: Ints, ends: Ends) -> Bools:
    """Which programs are at an end; those that come nearer to theirs than before leave their numbers in `ends`."""
    here = programs.at(left)
    c, A, b, G, h, _ = here
    rx, ry, rz, _ = _residuals(here, at)
    tau = at.tau
    cost = at.x @ c / tau
    bound = -_dots(here, at.y, at.z) / tau
    size = np.maximum(1.0, abs(cost))
    apart = np.maximum((at.s * at.z).sum(axis=1) / tau**2, abs(cost - bound)) / size
    # Norms of the equations, against the numbers in them
    primal = np.maximum(_norm(ry) / (1.0 + _norm(b)), _norm(rz) / (1.0 + _norm(h))) / tau
    missed = np.maximum(primal / (1.0 + 1e-3 * _norm(at.x) / tau), _norm(rx) / tau / (1.0 + np.sqrt(c @ c)))
    gap = np.maximum(apart, missed)
    before = ends.gap[left]
    better = gap < before
    rows = left[better]
    ends.gap[rows] = gap[better]
    for name, value in (("x", at.x), ("y", at.y), ("s", at.s), ("z", at.z)):
        getattr(ends, name)[rows] = (value / tau[:, None])[better]
    ended = (gap <= _GAP) | ((before <= _NEAR) & (gap > _SLOWER * before))
    ends.status[left[gap <= _ENOUGH]] = ENDED
    falls = -(at.x @ c)
    along = np.maximum(_norm(np.einsum("pev,pv->pe", A, at.x)), _norm(at.x @ G.T + at.s))
    ray = (falls > 0.0) & (along <= _PROOF * falls) & (at.kappa > tau) & (gap > _ENOUGH)
    lifts = -_dots(here, at.y, at.z)
    across = _norm(np.einsum("pev,pe->pv", A, at.y) + at.z @ G)
    proof = (lifts > 0.0) & (across <= _PROOF * lifts) & (at.kappa > tau) & (gap > _ENOUGH)
    for mask, word, of in ((ray, UNBOUNDED, falls), (proof, NOTHING_FITS, lifts)):
        rows = left[mask]
        ends.status[rows] = word
        for name, value in (("x", at.x), ("y", at.y), ("s", at.s), ("z", at.z)):
            getattr(ends, name)[rows] = (value / of[:, None])[mask]
        ends.gap[rows] = 0.0
    return np.asarray(ended | ray | proof)


def _norm(a: Array) -> Array:
    return np.asarray(np.sqrt((a * a).sum(axis=1)))


def _dots(programs: Conic, y: Array, z: Array) -> Array:
    """(p,) bᵀy + hᵀz."""
    return np.asarray((programs.b * y).sum(axis=1) + (programs.h * z).sum(axis=1))


def _residuals(programs: Conic, at: _Point) -> tuple[Array, Array, Array, Array]:
    """By how much the embedding's equations are missed: dual (p, v), equations (p, e), rows (p, m), costs (p,)."""
    c, A, b, G, h, _ = programs
    tau = at.tau[:, None]
    rx = np.einsum("pev,pe->pv", A, at.y) + at.z @ G + c * tau
    ry = np.einsum("pev,pv->pe", A, at.x) - b * tau
    rz = at.x @ G.T + at.s - h * tau
    return rx, ry, rz, at.kappa + at.x @ c + _dots(programs, at.y, at.z)


def _step(programs: Conic, at: _Point, equations: type[Reduced] | type[Whole]) -> tuple[_Point, Array]:
    """A predictor's and a corrector's step in one, and how far along it the cones allow (p,)."""
    cones = programs.cones
    scaling = cones.scaling(at.s, at.z)
    system = equations(programs, scaling)
    border = system.solve(-programs.c * np.ones((len(at.x), 1)), programs.b, programs.h)
    residuals = _residuals(programs, at)
    count = cones.count + 1
    mu = ((at.s * at.z).sum(axis=1) + at.kappa * at.tau) / count
    square = cones.product(scaling.point, scaling.point)
    know = _Known(programs, scaling, system, border, residuals)
    predictor = know.direction(at, np.zeros(len(mu)), square, at.kappa * at.tau)
    ahead = np.minimum(1.0, _reach(scaling, at, predictor))
    centring = (1.0 - ahead) ** 3
    ds, dz = scaling.inverse(predictor.s), scaling.times(predictor.z)
    target = square + cones.product(ds, dz) - (centring * mu)[:, None] * cones.unit
    last = at.kappa * at.tau + predictor.kappa * predictor.tau - centring * mu
    step = know.direction(at, centring, target, last)
    return step, np.minimum(1.0, _TO_WALL * _reach(scaling, at, step))


class _Known(NamedTuple):
    """What the predictor and the corrector of a step share; border : the equations' answer to (-c, b, h)."""

    programs: Conic
    scaling: Scaling
    system: Reduced | Whole
    border: tuple[Array, Array, Array]
    residuals: tuple[Array, Array, Array, Array]

    def direction(self, at: _Point, centring: Array, target: Array, last: Array) -> _Point:
        """The step that leaves `centring` (p,) of the residuals, with these right-hand sides of complementarity."""
        programs = self.programs
        rx, ry, rz, rt = self.residuals
        keep = (1.0 - centring)[:, None]
        inner = self.scaling.times(programs.cones.divided(self.scaling.point, target))
        x, y, z = self.system.solve(-keep * rx, -keep * ry, -keep * rz + inner)
        bx, by, bz = self.border
        slope = bx @ programs.c + _dots(programs, by, bz) - at.kappa / at.tau
        tau = (-(1.0 - centring) * rt + last / at.tau - x @ programs.c - _dots(programs, y, z)) / slope
        x, y, z = x + tau[:, None] * bx, y + tau[:, None] * by, z + tau[:, None] * bz
        # By the rows, not by the scaling: rounding then stays in the complementarity, which further steps mend
        s = tau[:, None] * programs.h - keep * rz - x @ programs.G.T
        return _Point(x, y, z, s, tau, (-last - at.kappa * tau) / at.tau)


def _reach(scaling: Scaling, at: _Point, step: _Point) -> Array:
    """(p,) multiples of a step that lead to the cones' boundary."""
    far = np.maximum(scaling.closing(scaling.inverse(step.s)), scaling.closing(scaling.times(step.z)))
    far = np.maximum(far, np.maximum(-step.tau / at.tau, -step.kappa / at.kappa))
    return np.asarray(1.0 / np.maximum(far, 1e-300))
