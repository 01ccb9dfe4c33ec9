"""Doors into the mathematics: kernels one call at a time, single stages of the chain, the search over active sets."""

import inspect
import pathlib

import numpy as np

from handlcp.grasp.verify.certifier import certify_candidate
from handlcp.lcp import (
    ContactProblem,
    FrictionSets,
    Pattern,
    Status,
    Units,
    certify as _public_certify,
    lemke as _lemke,
)
from handlcp.lcp.certificate import certify_contact
from handlcp.lcp.contact_problem import MultiplierLCP
from handlcp.lcp.kernels import contact_newton as _contact_newton, kaczmarz as _kaczmarz
from handlcp.lcp.kernels.dense import multiply_add
from handlcp.lcp.kernels.projection import project_on_set as _nearest
from handlcp.lcp.modes import mode_cones as _modes
from handlcp.lcp.modes.mode_fit import fit_mode, new_active_columns

# Where the certifiers of answers to problems and to grasps are
CERTIFIERS = tuple(pathlib.Path(inspect.getfile(certifier)) for certifier in (certify_contact, certify_candidate))


# ---------------------------------------------------------------- the certifier's word on natural units
def certified(problem, z):
    """Whether z in natural units is a solution."""
    return _public_certify(problem, z * problem.scaled.units.z)[0] is Status.SOLVED


def status_of_contact(problem, x):
    """What the certifier calls x, natural units, of a problem with friction as a set."""
    return certify_contact(problem, x)[0]


def solves_contact(problem, x):
    """Whether it is an answer."""
    return status_of_contact(problem, x) is Status.SOLVED


# ---------------------------------------------------------------- kernels
def eliminated(M, q, complementary):
    """(M, q) without the free unknowns, which come after so many complementary ones: the package's own arithmetic."""
    pattern = Pattern.from_blocks(np.arange(len(q)) >= complementary, np.zeros((0, 4), np.int64))
    contact = ContactProblem(M.copy(), q.copy(), pattern, FrictionSets(np.zeros(0), 0), Units.ones(len(q)))
    problem = MultiplierLCP(contact)
    return problem.scaled.M, problem.scaled.q


def pivoted(M, q, covering, most, tolerance=1e-11):
    """Lemke's method from one covering vector: ("solved" | "ray" | "other", pivots, z)."""
    status, pivots, z = _lemke.pivot_lemke(M, q, covering, most, tolerance)
    return {_lemke.SOLVED: "solved", _lemke.RAY: "ray"}.get(status, "other"), pivots, z


class Kaczmarz:
    """The steps of NSNGRK on one problem in natural units."""

    def __init__(self, M, q, free):
        self.rows = _kaczmarz.PlainRows(M, np.ascontiguousarray(M.T), M @ M.T, q, free)

    def run(self, z, w, seed, steps):
        """(steps taken, norm, z, w) after so many steps at most; z and w = M z + q are overwritten."""
        state, history = np.full(1, seed, np.uint64), np.empty((0, 2))
        done, norm, _ = _kaczmarz.run_kaczmarz(self.rows, z, w, state, steps, 0.0, 0, history)
        return done, norm, z, w


def uniform_numbers(seed, count):
    """(count,) of the generator that the kernels draw rows with."""
    state = np.full(1, seed, np.uint64)
    return np.array([_kaczmarz.draw_uniform(state) for _ in range(count)])


def projection(x, y, limit, mu, faces):
    """(P, D): (x, y) projected on the section of the friction cone of this size, and its derivative by x, y and the
    normal force (2, 3). faces : 0 for the disc, 2 for the interval.
    """
    P, D = np.zeros(3), np.zeros((3, 4))
    tangents = 1 if faces == 2 else 2
    _nearest(np.array([x, y, 0.0]), tangents, limit, mu, faces, np.zeros((0, 3)), P, D)
    return P[:2], D[:2, [0, 1, 3]]


def nearest_point(s, tangents, limit, faces):
    """(3,) s projected on the friction set of so many tangents."""
    P = np.zeros(3)
    _nearest(s, tangents, limit, 0.0, faces, np.zeros((0, 3)), P, np.zeros((3, 4)))
    return P


def contact_rows(problem, x):
    """(F, J): the laws of a problem with friction as a set as equations at x (n,), and a subgradient (n, n) of them;
    both, and x, in the order in which the solvers have the unknowns.
    """
    p, n = problem.arrays, problem.n
    F, g, y, J = np.empty(n), _contact_newton.new_subgradient(p), np.empty(n), np.empty((n, n))
    multiply_add(p.M, x, p.q, y)
    _contact_newton.evaluate_rows(p, x, y, F, g)
    _contact_newton.write_jacobian(p, g, J)
    return F, J


def nearest_in_polyhedron(point, distance, normals):
    """(3,) nearest to the point among x with normals @ x ≤ distance."""
    p = np.empty(3)
    _nearest(point, 3, distance, 0.0, 8, normals, p, np.empty((3, 4)))
    return p


# ---------------------------------------------------------------- contact modes
def patches(tangents, faces, splits):
    """All patches (3, 3) that sliding is divided into after so many splits of each."""
    now = []
    for k in range(_modes.count_patches(tangents)):
        now.append(np.zeros((3, 3)))
        _modes.write_first_patch(k, tangents, faces, now[-1])
    for _ in range(splits):
        finer = []
        for corners in now:
            for k in range(_modes.count_parts(corners, tangents, faces)):
                finer.append(np.zeros((3, 3)))
                _modes.split_patch(corners, k, tangents, faces, finer[-1])
            if not _modes.count_parts(corners, tangents, faces):
                finer.append(corners)
        now = finer
    return now


def misses_patch(limit, faces, corners, force, motion):
    """How much of a force and a motion (1 + tangents,), normal first, lies outside the cones of a patch."""
    d = len(force) - 1
    columns = np.zeros((2 * (1 + d), 1, 2, 4))
    columns[: 1 + d, 0, 0, : 1 + d] = columns[1 + d :, 0, 1, : 1 + d] = np.eye(1 + d)
    cones = _modes.new_mode_cones(columns.reshape(-1, 1, 8), np.array([d]), np.array([limit]), faces)
    b = np.concatenate([force, motion])
    left, _ = fit_mode(cones, np.array([_modes.SLIDES]), corners[None], new_active_columns(b))
    return float(left)
