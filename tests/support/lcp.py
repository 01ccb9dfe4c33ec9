"""Doors into the mathematics: kernels one call at a time, single stages of the chain, the search over active sets."""

from __future__ import annotations

import inspect
import pathlib
from typing import Any

import numpy as np

from handlcp.grasp.certify import judge
from handlcp.lcp import LCP, Status
from handlcp.lcp import certify as _public_certify
from handlcp.lcp.certify import certify_contact
from handlcp.lcp.kernels import arrow as _arrow
from handlcp.lcp.kernels import contact as _contact
from handlcp.lcp.kernels import kaczmarz as _kaczmarz
from handlcp.lcp.kernels import lemke as _lemke
from handlcp.lcp.kernels.polyhedron import nearest_in_polyhedron as _nearest_in_polyhedron
from handlcp.lcp.kernels.schur import schur
from handlcp.lcp.reduce import reduce
from handlcp.lcp.search import search
from handlcp.lcp.solvers.continuation import Continuation
from handlcp.lcp.solvers.starts import OtherStarts
from handlcp.lcp.solvers.variants import in_units_of_limits

# Where the certifiers of answers to problems and to grasps are
CERTIFIERS = tuple(pathlib.Path(inspect.getfile(certifier)) for certifier in (certify_contact, judge))

__all__ = [
    "CERTIFIERS",
    "Continuation",
    "Kaczmarz",
    "OtherStarts",
    "Reordered",
    "certified",
    "contact_rows",
    "eliminated",
    "in_units_of_limits",
    "nearest_in_polyhedron",
    "pivoted",
    "projection",
    "reduce",
    "search",
    "solves_contact",
    "status_of_contact",
    "uniform_numbers",
]


# ---------------------------------------------------------------- the certifier's word on natural units
def certified(problem: LCP, z: np.ndarray) -> bool:
    """Whether z in natural units is a solution."""
    return _public_certify(problem, z * problem.scaled.units.z)[0] is Status.SOLVED


def status_of_contact(problem: Any, x: np.ndarray) -> Status:
    """What the certifier calls x, natural units, of a problem with friction as a set."""
    return certify_contact(problem, x)[0]


def solves_contact(problem: Any, x: np.ndarray) -> bool:
    """Whether it is an answer."""
    return status_of_contact(problem, x) is Status.SOLVED


# ---------------------------------------------------------------- kernels
def eliminated(M: np.ndarray, q: np.ndarray, complementary: int) -> tuple[np.ndarray, np.ndarray]:
    """(M, q) without the free unknowns, which come after so many complementary ones: the package's own arithmetic."""
    return schur(M, q, complementary)[:2]


def pivoted(M: Any, q: Any, covering: Any, most: int, tolerance: float = 1e-11) -> tuple[str, int, np.ndarray]:
    """Lemke's method from one covering vector: ("solved" | "ray" | "other", pivots, z)."""
    status, pivots, z = _lemke.lemke(M, q, covering, most, tolerance)
    return {_lemke.SOLVED: "solved", _lemke.RAY: "ray"}.get(status, "other"), pivots, z


class Kaczmarz:
    """The steps of NSNGRK on one problem in natural units."""

    def __init__(self, M: np.ndarray, q: np.ndarray, free: np.ndarray) -> None:
        self.M, self.q, self.free = M, q, free
        self.columns, self.products = np.ascontiguousarray(M.T), M @ M.T

    def run(
        self, z: np.ndarray, w: np.ndarray, seed: int, steps: int, greedy: bool = True
    ) -> tuple[int, float, np.ndarray, np.ndarray]:
        """(steps taken, norm, z, w) after so many steps at most; z and w = M z + q are overwritten."""
        state, history = np.full(1, seed, np.uint64), np.empty((0, 2))
        done, norm, _ = _kaczmarz.kaczmarz(
            self.M, self.columns, self.products, self.q, self.free, z, w, state, steps, 0.0, 0, history, greedy
        )
        return done, norm, z, w


def uniform_numbers(seed: int, count: int) -> np.ndarray:
    """(count,) of the generator that the kernels draw rows with."""
    state = np.full(1, seed, np.uint64)
    return np.array([_kaczmarz.uniform(state) for _ in range(count)])


def projection(x: float, y: float, limit: float, mu: float, faces: int) -> tuple[np.ndarray, np.ndarray]:
    """(P, D): (x, y) projected on the section of the friction cone of this size, and its derivative by x, y and the
    normal force (2, 3). faces : 0 for the disc, 2 for the interval.
    """
    P, D = np.empty(2), np.empty((2, 3))
    _contact.project(x, y, limit, mu, faces, P, D)
    return P, D


def contact_rows(problem: Any, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(F, J): the laws of a problem with friction as a set as equations at x (n,), and a subgradient (n, n) of them;
    both, and x, in the order in which the solvers have the unknowns.
    """
    order, starts, own, side, below, q, role, rho, blocks = problem.prepared
    M, n = problem.M[np.ix_(order, order)], problem.n
    form = _arrow.Arrow(own, side, below, starts)
    contacts = _contact.Contacts(form, q, role, rho, blocks, problem.limits, problem.faces)
    F, g = np.empty(n), _contact.work(n)
    _contact.rows(contacts, x, M @ x + q, F, g)
    J = g.b[:, :1] * M[g.row[:, 0]] + g.b[:, 1:] * M[g.row[:, 1]]
    for i in range(n):
        for a in range(3):
            J[i, g.unit[i, a]] += g.c[i, a]
    return F, J


def nearest_in_polyhedron(point: np.ndarray, distance: float, normals: np.ndarray) -> np.ndarray:
    """(3,) nearest to the point among x with normals @ x ≤ distance."""
    p = np.empty(3)
    _nearest_in_polyhedron(point, distance, normals, p, np.empty((3, 4)))
    return p


class Reordered:
    """A matrix (n, n) as blocks and a border, in the order in which they are eliminated; `blocks` says how many."""

    def __init__(self, M: np.ndarray, role: np.ndarray, friction: np.ndarray) -> None:
        self.order, self.starts = _arrow.arrow_order(M, role, friction)
        self.matrix, self.blocks = M[np.ix_(self.order, self.order)], len(self.starts) - 1
        self._form = _arrow.Arrow(*_arrow.pack(M, self.order, self.starts), self.starts)

    def multiplied(self, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        """M x + q, in this order."""
        y = np.empty(len(x))
        _arrow.multiply_arrow(self._form, x, q, y)
        return y

    def solved(self, rows: np.ndarray, units: np.ndarray, right: np.ndarray, tolerance: float) -> np.ndarray:
        """The x with (diag(rows) M + diag(units)) x = right, in this order: some rows of M, some unit vectors."""
        n = len(right)
        index, b, c, x = np.repeat(np.arange(n)[:, None], 3, axis=1), np.zeros((n, 2)), np.zeros((n, 3)), np.empty(n)
        b[:, 0], c[:, 0] = rows, units
        J = _arrow.Subgradient(index, c, index[:, :2].copy(), b)
        _arrow.solve_arrow(self._form, J, right, x, _arrow.room(self._form), tolerance)
        return x
