"""`solve_with_preload_hint`: a solve that can say what squeeze helps; `solve_to_accuracy`: one as accurate as asked."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from handlcp.check import Array, Bools
from handlcp.contact.friction import Cone, Interval, Pyramid, Section
from handlcp.errors import NoSolutionFound, Unsupported
from handlcp.grasp.assembly.problem import AnyProblem, GraspContactProblem, asked_effects_with_rows, solution_candidate
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows
from handlcp.grasp.derivatives.parameter.load import MAX_SQUEEZE_SHARE
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solution.solution import Accuracy, GraspSolution
from handlcp.grasp.solve.compiled_answer import NO_START, start_values
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verify.contact_state import GLIDING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.lcp import Auto, ContactSolver, SemismoothNewton, Solver, Status, as_chain
from handlcp.lcp.kernels.contact_newton import row_scales
from handlcp.lcp.solve import AnySolver
from handlcp.tolerances import ACTIVE_TOLERANCE, RANK_TOLERANCE


def solve_with_preload_hint(
    spec: GraspSpec,
    section: Section,
    solver: AnySolver = None,
    start: Array = NO_START,
    scene: Scene | None = None,
    proof: bool = True,
) -> GraspSolution:
    """As `solve_spec`; NO_EQUILIBRIUM can be asked for the `required_preload` that would hold."""
    return attach_advice(solve_spec(spec, section, solver, start, scene, proof), spec, section)


def attach_advice(solution: GraspSolution, spec: GraspSpec, section: Section) -> GraspSolution:
    """The solution that knows where to ask for the squeeze that would help."""
    if solution.status is not Status.NO_EQUILIBRIUM or solution.certificate is not None:  # no squeeze moves a limit
        return solution
    return replace(solution, advise=partial(_find_helpful_squeeze, spec, section))


def _find_helpful_squeeze(spec: GraspSpec, section: Section) -> float | None:
    """The smallest squeeze that holds within the joints' torque limits, up to a fifth of the grasp's size [m]: of two
    digits, as it is said, where that holds, too.
    """
    from handlcp.grasp.analysis.required_value import BRIEF_CHAIN, required_preload  # 40 ms that only advice pays

    def holds(spec: GraspSpec, section: Section) -> bool:
        found = solve_spec(spec, section, BRIEF_CHAIN)
        check = getattr(found, "torque_check", None)
        return found.held and (check is None or not check.over)

    most = MAX_SQUEEZE_SHARE * build_scene(spec).units.length_unit
    least = required_preload(spec, section, limit=most, test=holds, sure=holds).value
    if not least:
        return least
    step = 10.0 ** (math.floor(math.log10(least)) - 1)
    said = float(f"{math.ceil(least / step * (1 - 1e-12)) * step:.2g}")
    return said if holds(spec.with_squeeze(said), section) else least


def make_no_solution_error(problem: AnyProblem, solution: GraspSolution) -> NoSolutionFound:
    """The error that carries them; its message, advice included, is made when somebody reads it."""
    return NoSolutionFound(partial(_error_message, solution), problem, solution)


def _error_message(solution: GraspSolution) -> str:
    lines, reached = [str(solution), *solution.trace], solution.accuracy
    if solution.held and reached is not None:
        advice = f"double precision shows no more here: ask for {2.0 * reached.error:.0e}"
        lines = [f"no setting is shown to keep what was asked for: {reached}", advice, *lines]
    return "\n  ".join(lines)


# ----------------------------------------------------------------
# How far the forces of an answer are from those that solve its laws exactly: an estimate from the answer itself.
#
# The laws are rows F(x) = 0, y = M x + q. In a piece, which says what every contact and every pair does, they are those
# of an active set (`derivatives/active_set.py`), F = A x - B (q, 0). With ρ > 0 a scale of each contact, as in
# `evaluate_rows` (Alart & Curnier 1991), a contact that slides is at the face e = (x_T - ρ y_T) / |x_T - ρ y_T|, and
# friction turns with the slip by α = (|x_T - ρ y_T| - μ x_N) / (ρ μ x_N). Then
#
# |Δx| ≤ |A⁻¹ F| + |A⁻¹| δ
#
# to first order: Newton's step, and what rounding can have done to F in making M, q and y, entry by entry (Higham,
# Accuracy and Stability of Numerical Algorithms, 2002, section 7.2). Where A is singular, something is not determined:
# its pseudoinverse leaves that out, so that any member of the family counts as exact.
#
# A contact so near the border between two choices that this very bound covers it may be on either side: every choice of
# these contacts is a piece of its own, and the largest bound counts.

_EPS = float(np.finfo(float).eps)
_ROUNDING = 4.0 * _EPS  # of a sum, over the sum of its terms' sizes: data, product and sum
_MAX_DOUBTFUL = 5  # contacts on a border whose 2^k choices are all looked at; of more, each alone and all at once
_MIN_RCOND = 1e-9  # 1 / condition above which A is inverted; below, its rank is looked at
_MIN_RADIUS_SHARE = 1e-12  # of |x_T - ρ y_T|: limits below it turn with any slip


def force_error(problem: GraspContactProblem, solution: GraspSolution) -> float:
    """The largest error of a contact force, over the largest contact force, that the answer to `problem` may have.

    Where no finger pushes noticeably, beside load and squeeze, it is over the natural unit of force instead.

    problem : with the cone or the planar interval as its section, without soft contacts. solution : certified for it.
    """
    scene, at = problem.scene, problem.system.at
    laws = _ErrorLaws(problem, problem.natural(solution_candidate(scene, solution)))
    bound = laws.bound(laws.piece)
    for piece in _other_pieces(laws.piece, laws.find_doubtful(bound)):
        bound = np.maximum(bound, laws.bound(piece))
    off = np.zeros(3 * scene.n)
    for name, index in (("r_N", scene.kind.normal_index), ("r_T", scene.kind.tangent_index)):
        if name in at:
            off[index] = bound[at[name]]
    size = float(np.sqrt((solution.forces**2).sum(axis=1)).max()) / scene.units.force_unit
    most = float(np.sqrt((off.reshape(-1, 3) ** 2).sum(axis=1)).max()) + _EPS * size  # the way to newtons rounds, too
    if size <= ACTIVE_TOLERANCE:
        return most
    # Relative to exact forces that may be smaller by as much
    return most / (size - most) if most < size else np.inf


class _ErrorLaws:
    """The laws at a solution x (n,), and what rounding can have done there.

    noise, rho, s (n,) : of y, the scales ρ, and s = x - ρ y.
    size, along, radius : of each block's s_T the length and direction, and the limit μ x_N.
    piece (n + k,) bool : which pairs touch, then which of k blocks stick.
    """

    def __init__(self, problem: GraspContactProblem, x: Array) -> None:
        self.M, self.q, self.x, self.blocks, self.limits = problem.M, problem.q, x, problem.blocks, problem.limits
        self.noise, self.rho = _rounding_noise(problem, x), row_scales(self.M, self.blocks)
        self.s, self.pair = x - self.rho * (self.M @ x + self.q), problem.role == 1
        tangential = self._of_tangents(self.s)
        self.size = np.hypot(*tangential.T)
        self.along = tangential / np.where(self.size > 0.0, self.size, 1.0)[:, None]
        self.radius = self.limits * np.maximum(x[self.blocks[:, 0]], 0.0)
        self.piece: Bools = np.concatenate([self.pair & (self.s > 0.0), self.size <= self.radius])
        pairs = np.flatnonzero(self.pair)
        self.own = np.searchsorted(pairs, self.blocks[:, 0])  # which of the pairs each block belongs to
        contacts, limits = np.full((len(pairs), 4), -1), np.zeros(len(pairs))
        contacts[:, 0], contacts[self.own], limits[self.own] = pairs, self.blocks, self.limits
        self.laws = LinearLaws(self.M.copy(), problem.role == 0, contacts, limits, 1.0)

    def _of_tangents(self, values: Array) -> Array:
        """(k, 2) those of each block's tangents, 0 for the one that is missing in a plane."""
        tangents = self.blocks[:, 1:3]
        return np.where(tangents >= 0, values[tangents], 0.0)

    def bound(self, piece: Bools) -> Array:
        """(n,) |A⁻¹ F| + |A⁻¹| δ, the largest error of every unknown in this piece."""
        n, x = len(self.x), self.x
        A, B = active_rows(self.laws, self._states(piece[:n], piece[n:]))
        F = A @ x - B[:, :n] @ self.q
        on_limit = (B[:, n:] != 0.0).any(axis=1)
        off = abs(B[:, :n]) @ self.noise + np.where(on_limit, _ROUNDING * (abs(A) @ abs(x)), 0.0)
        inverse = _inverse(A)
        return np.asarray(abs(inverse @ F) + abs(inverse) @ off)

    def _states(self, touches: Bools, sticks: Bools) -> ContactStates:
        """Of all pairs; a contact that has no friction glides."""
        pairs = self.laws.contacts[:, 0]
        kind, faces, turn = np.full(len(pairs), GLIDING), np.zeros((len(pairs), 3, 3)), np.zeros(len(pairs))
        kind[self.own], faces[self.own, 0, :2] = np.where(sticks, STICKING, SLIDING), self.along
        beyond = np.maximum(self.size - self.radius, 0.0)
        turn[self.own] = beyond / (self.rho[self.blocks[:, 1]] * np.maximum(self.radius, _MIN_RADIUS_SHARE * self.size))
        kind[~touches[pairs]] = SEPARATED
        return ContactStates(kind, (kind == SLIDING).astype(np.int64), faces, turn)

    def find_doubtful(self, bound: Array) -> Bools:
        """(n + k,) pairs and blocks that may be on the other side of their border, for all the bound (n,) says."""
        moved = bound + self.rho * (self.noise + abs(self.M) @ bound)
        slack = np.hypot(*self._of_tangents(moved).T) + self.limits * bound[self.blocks[:, 0]]
        return np.concatenate([self.pair & (abs(self.s) <= moved), abs(self.size - self.radius) <= slack])


def _rounding_noise(problem: GraspContactProblem, x: Array) -> Array:
    """(n,) what rounding can have done to M x + q. Levers are differences of positions, moments those of the load's
    about the origin: what they are differences of counts.
    """
    scene, u = problem.scene, problem.system.at["u"].start
    far = float(abs(scene.positions).max()) / scene.units.length_unit
    turns = np.zeros(len(x), dtype=bool)
    turns[u + (3 if scene.dof == 6 else 2) : u + scene.dof] = True
    terms = abs(problem.q) + abs(problem.M) @ abs(x) + (turns[:, None] != turns) @ (far * abs(x))
    terms[turns] += far * float(abs(scene.natural.w).max())
    return np.asarray(_ROUNDING * terms)


def _inverse(A: Array) -> Array:
    """Inverse of a matrix of rows of size one, or what the rank tolerance leaves of it."""
    try:
        inverse = np.linalg.inv(A)
        if np.linalg.norm(inverse, np.inf) * np.linalg.norm(A, np.inf) < 1.0 / _MIN_RCOND:
            return np.asarray(inverse)
    except np.linalg.LinAlgError:
        pass  # singular to the last bit
    return np.asarray(np.linalg.pinv(A, rcond=RANK_TOLERANCE))


def _other_pieces(piece: Bools, doubtful: Bools) -> Iterator[Bools]:
    """The pieces with doubtful pairs and blocks on their other side, in every way but none at all."""
    at = np.flatnonzero(doubtful)
    patterns = np.vstack([np.eye(len(at), dtype=bool), np.ones(len(at), dtype=bool)])
    if len(at) <= _MAX_DOUBTFUL:
        patterns = np.array(list(itertools.product((False, True), repeat=len(at)))[1:], dtype=bool)
    for pattern in patterns:
        other = piece.copy()
        other[at[pattern]] ^= True
        yield other


# ----------------------------------------------------------------
# Asking for an accuracy instead of settings: the exact cone, whose force error is shown to keep the request.
#
# Pyramids of 4 to 64 faces would take 5 or 6 % longer (median of 340 scenes), and an answer on one says nothing of its
# error. What is left of an error on the cone is the solver's and rounding's (`force_error`). A plane's interval, and
# contacts without friction, are exact whatever the solver.

_START_FACES = (4, 8, 16, 32)  # faces of the pyramids whose answers may lead to the cone's
_NEWTON = SemismoothNewton()
_FINEST_NEWTON = SemismoothNewton(tol=1e-13)  # as far as rounding lets Newton's method go


def solve_to_accuracy(
    spec: GraspSpec, accuracy: float, solver: AnySolver, start: Array, proof: bool = True
) -> GraspSolution:
    """The solution on the exact section with its `Accuracy`, and more Newton steps where the request needs them.

    A proof that nothing holds the object, or that there is no equilibrium, is a final answer and passes unchanged.
    proof : as in `Grasp.solve`.
    Raises Unsupported for soft fingers, and for a solver that knows no cones where there is one.
    """
    begun, scene = time.perf_counter(), build_scene(spec)
    if scene.soft:
        raise Unsupported("accuracy= knows no soft fingers: solve(faces) and solve('cone') do")
    section, words = _exact_section(scene, solver)
    solution, solves = solve_with_preload_hint(spec, section, solver, start, scene, proof), 1
    if proof and solution.status is Status.UNDECIDED and isinstance(section, Cone):
        solution, solves, words = _through_pyramids(spec, scene, solver, solution)
    error = _solution_error(spec, scene, solution)
    if solution.held and not error <= accuracy and scene.frictional:
        begin = start_values(solution, scene)
        finer, solves = solve_with_preload_hint(spec, _true_section(scene), _FINEST_NEWTON, begin, scene), solves + 1
        if (better := _solution_error(spec, scene, finer)) < error:
            solution, error, words = finer, better, f"{words}, more Newton steps"
    reached = Accuracy(accuracy, error, words, solves, time.perf_counter() - begun)
    return replace(solution, accuracy=reached, trace=(*solution.trace, f"accuracy: {reached}"))


def _exact_section(scene: Scene, solver: AnySolver) -> tuple[Section, str]:
    """The section that stands for the exact one with this solver, and its name."""
    # A class, or anything that is no solver, is refused where it is used
    plain = not isinstance(solver, (Auto, ContactSolver, type)) and isinstance(solver, Solver)
    exact = _true_section(scene)
    if not scene.frictional:
        return Pyramid(4) if plain and not scene.kind.planar else exact, "exact, no friction"
    if plain and not scene.kind.planar:
        known = f"{type(solver).__name__} knows no cones, and pyramids seldom get below 1e-3"
        raise Unsupported(f"{known}: leave the solver to accuracy=, or ask for faces")
    return exact, exact.name


def _true_section(scene: Scene) -> Section:
    """Friction as it is."""
    return Interval() if scene.kind.planar else Cone()


def _through_pyramids(
    spec: GraspSpec, scene: Scene, solver: AnySolver, best: GraspSolution
) -> tuple[GraspSolution, int, str]:
    """Run Newton's method on the cone from the answers of pyramids, until one is held: (solution, solves, words)."""
    method = replace(as_chain(solver) or Auto(), search_seconds=0.0)
    for k, faces in enumerate(_START_FACES):
        near = solve_with_preload_hint(spec, Pyramid(faces), method, scene=scene)
        if near.held:
            cone = solve_with_preload_hint(spec, Cone(), _NEWTON, start_values(near, scene), scene)
            if cone.held:
                return cone, 2 * k + 3, f"{Cone().name}, from the {Pyramid(faces).name}"
    return best, 1 + 2 * len(_START_FACES), Cone().name


def _solution_error(spec: GraspSpec, scene: Scene, solution: GraspSolution) -> float:
    """Of an answer on the exact section; NaN without one."""
    if not solution.held:
        return math.nan
    problem = GraspContactProblem(scene, _true_section(scene), asked_effects_with_rows(spec.effects))
    return force_error(problem, solution)
