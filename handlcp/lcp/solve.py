"""`Auto`: the default solver, a chain of methods in the order of what they solve in the time they take.

Of 2,370 contact problems that are solved (480 scenes of the peers' corpus and the hard cases, 4, 8 and 16 faces and the
cone) the first stage solves five in six: four by Newton's steps alone, one after Kaczmarz steps. Of the others a brief
search over contact modes solves three in four, and proves for most of the rest that they have no answer; Lemke's method
on the own pyramid, and Newton's method from its answer, solve nearly all of what is left.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial

import numpy as np

from handlcp.check import Array, check_array, check_call, check_init_call, check_integer, check_number, read_only
from handlcp.errors import InputError, NoSolutionFound, Unsupported
from handlcp.lcp.certificate import certify, certify_scaled, farkas_vector, search_active_sets
from handlcp.lcp.contact_problem import ContactProblem, MultiplierLCP
from handlcp.lcp.lemke import Lemke
from handlcp.lcp.problem import LCP, LCPSolution, Proposal, Status, stage_line
from handlcp.lcp.solver import (
    NSNGRK,
    ContactSolver,
    OtherStarts,
    SemismoothNewton,
    Solver,
    has_converged,
    scale_by_limits,
    solve_compiled,
)
from handlcp.tolerances import FINE_SOLVE_TOLERANCE, SOLVE_TOLERANCE

Stage = tuple[str, Callable[[], Proposal | None]]

FIRST_STAGE = "NSNGRK, Newton first"
STATIC_STAGE = "balance of rigid contacts"
BRIEF_SEARCH_STAGE, LONG_SEARCH_STAGE = "search, briefly", "search, longer"
STAGES_BETWEEN_SEARCHES = 2  # stages between these two, here and in the stages of a grasp
_NSNGRK_STAGE = "NSNGRK"
_ON_SET_SUFFIX = ", on the friction set"  # ends the names of stages that work on an LCP's contact form
_FIRST_STAGE_ON_SET = FIRST_STAGE + _ON_SET_SUFFIX
_FINE_NEWTON = SemismoothNewton(tol=FINE_SOLVE_TOLERANCE)


@dataclass(frozen=True)
class StageOptions:
    """Which starts and pyramids the later stages of `Auto` try."""

    start_faces: tuple[int, ...] = (16, 4)  # of pyramids whose answers are worth a start, besides the own or of 8 faces
    default_faces: int = 8  # of the pyramid that is pivoted where the problem has none, or too many faces
    max_pivoted_faces: int = 16  # faces beyond which pivoting costs more than the other methods
    max_other_starts: int = 30  # other starts: most that help are among the first ten


_OPTIONS = StageOptions()


@check_init_call()
@dataclass(frozen=True, slots=True)
class Auto:
    """Stages until the certifier is content; `plan` lists them for a problem, the solution's `trace` those that ran.

    On contact problems, and on LCPs that have such a form: NSNGRK that begins with Newton's steps, on a small budget;
    of a grasp, the proof that nothing could hold it, forces that balance the load where all contacts are rigid (any
    such forces are an answer), and a brief search; Lemke's method on the problem's own pyramid, and Newton's method
    from its answer (the cone: from that of 8 faces); of a grasp, a longer search; Newton's method from where other
    subsets of the contacts stick or stay apart, and from the answers of other pyramids; of a grasp, the rest of the
    search.
    On other LCPs: NSNGRK, Lemke's method with one, then with other covering vectors, Newton's method from other active
    sets, NSNGRK again with other seeds and more steps; a Farkas vector, which proves that there is none; the search.

    seed : of the first run; later runs use the seeds that follow.
    restarts : NSNGRK runs with other seeds on LCPs without a contact form, after all else.
    search_work : multiply-adds for the exact search over all contact modes or active sets, which finds a solution or
        proves that there is none within bounds; 5e8 are about 0.2 s. 0: no search. Of a grasp with more than ten
        contacts, that times the cube of their number over ten. The same work has the same end on any machine;
        search_seconds : a limit in time besides, which has not.
    """

    seed: int = 0
    restarts: int = 1
    search_work: float = 5e8
    search_seconds: float = math.inf

    def __post_init__(self) -> None:
        for name in ("seed", "restarts"):
            check_integer(name, getattr(self, name), 0)
        check_number("search_work", self.search_work, minimum=0.0)
        if self.search_seconds is not math.inf:
            check_number("search_seconds", self.search_seconds, minimum=0.0, finite=False)

    def first(self, problem: LCP | ContactProblem, start: Array | None = None) -> tuple[str, Proposal]:
        """(method, candidate) of the first stage: most problems end here, before any list of stages is made."""
        if isinstance(problem, ContactProblem):
            return FIRST_STAGE, self._newton_first(problem, start)
        if start is None and isinstance(problem, MultiplierLCP):
            p = self._newton_first(problem.contact, None)
            return _FIRST_STAGE_ON_SET, replace(p, z=problem.lift(p.z))
        return _NSNGRK_STAGE, _nsngrk(self.seed, 3 * problem.n).propose(problem.scaled, start)

    def _newton_first(self, problem: ContactProblem, start: Array | None) -> Proposal:
        """As `NSNGRK` with as many steps as unknowns."""
        return solve_compiled(problem, self.seed, problem.n, True, SOLVE_TOLERANCE, start)

    def others(self, problem: LCP | ContactProblem, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) of the stages after the first, each computed when asked for."""
        if isinstance(problem, ContactProblem):
            later = self._on_contacts(problem)
        elif start is None and isinstance(problem, MultiplierLCP):
            later = self._on_faces(problem)
        else:
            later = self._without_contacts(problem)
        for name, run in later:
            if (p := run()) is not None:
                yield name, p

    def stages(self, problem: LCP, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a plain LCP, each computed when asked for."""
        yield self.first(problem, start)
        yield from self.others(problem, start)

    def contact_stages(
        self, problem: ContactProblem, start: Array | None = None, first: Proposal | None = None
    ) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a contact problem, each computed when asked for; `first` where it is known."""
        yield (FIRST_STAGE, first) if first else self.first(problem, start)
        yield from self.others(problem, start)

    def plan(self, problem: LCP | ContactProblem) -> tuple[str, ...]:
        """What would run on this problem, in order, until one answer is certified; `Grasp.plan` says it of a grasp.

        Stages may be passed over (where Lemke's method has no answer, nothing starts from it); none is added. The
        solution's `trace` begins its lines with these names. Holdability and search belong to `Grasp.solve`;
        `solve_lcp` of a contact problem does without them. Raises InputError for anything but a problem.
        """
        search = (self.search_stage,) if self.searches else ()
        if isinstance(problem, ContactProblem):
            rest = [name for name, _ in self._on_contacts(problem)]
            if not hasattr(problem, "scene"):
                return (FIRST_STAGE, *rest)
            begin = FIRST_STAGE, "holdability", *((STATIC_STAGE,) if is_static(problem) else ())
            if not search:
                return *begin, *rest
            between, after = rest[:STAGES_BETWEEN_SEARCHES], rest[STAGES_BETWEEN_SEARCHES:]
            return *begin, BRIEF_SEARCH_STAGE, *between, LONG_SEARCH_STAGE, *after, *search
        if not isinstance(problem, LCP):
            raise InputError("problem", "an LCP or a ContactProblem, such as grasp.problem()", type(problem).__name__)
        if isinstance(problem, MultiplierLCP):
            first, later = _FIRST_STAGE_ON_SET, self._on_faces(problem)
        else:
            first, later = _NSNGRK_STAGE, self._without_contacts(problem)
        return (first, *(name for name, _ in later), "Farkas vector", *search)

    @property
    def search_stage(self) -> str:
        """Name of the exact search in plans and traces."""
        clock = "" if self.search_seconds == math.inf else f" or {self.search_seconds:g} s"
        return f"search, {self.search_work / 1e6:g} million multiply-adds{clock} at most"

    @property
    def searches(self) -> bool:
        """Whether there is an exact search."""
        return self.search_work > 0 and self.search_seconds > 0

    def search_end(self) -> float:
        """When a search that begins now has to end, of `time.monotonic`."""
        return time.monotonic() + self.search_seconds

    def _on_faces(self, problem: MultiplierLCP) -> Iterator[Stage]:
        def propose_lifted(run: Callable[[], Proposal | None]) -> Proposal | None:
            p = run()
            return p if p is None else replace(p, z=problem.lift(p.z))

        yield "Lemke", lambda: Lemke(seed=self.seed).propose(problem.scaled)
        for name, run in self._on_contacts(problem.contact):
            if name != "Lemke":  # the same as on this problem itself
                yield name + _ON_SET_SUFFIX, partial(propose_lifted, run)
        yield self._coverings(problem)

    def _without_contacts(self, problem: LCP) -> Iterator[Stage]:
        n, seed = problem.n, self.seed

        @cache
        def propose_pivoted() -> Proposal:
            return Lemke(seed=seed).propose(problem.scaled)

        def retry_with_seed(k: int) -> Proposal:
            """The first from Lemke's answer, where that is a number."""
            where = propose_pivoted().z if k == 1 and np.isfinite(propose_pivoted().z).all() else None
            return _nsngrk(seed + k, 200 * n).propose(problem.scaled, where)

        yield "Lemke", propose_pivoted
        yield self._coverings(problem)
        yield "Newton from other starts", lambda: OtherStarts(seed=seed).propose(problem.scaled)
        for k in range(1, 1 + self.restarts):
            yield f"{_NSNGRK_STAGE}, seed {seed + k}", partial(retry_with_seed, k)

    def _coverings(self, problem: LCP) -> Stage:
        again = Lemke(coverings=30, seed=self.seed + 1)
        return "Lemke, other covering vectors", lambda: again.propose(problem.scaled)

    def _on_contacts(self, problem: ContactProblem) -> Iterator[Stage]:
        seed, m = self.seed, problem.faces

        @cache
        def propose_pivoted(faces: int) -> Proposal:
            """Lemke's answer for a pyramid, as an x of the problem."""
            assert problem.flat is not None  # nothing else is planned
            lcp = MultiplierLCP(problem, problem.flat(faces))
            p = Lemke(seed=seed).propose(lcp.scaled)
            return replace(p, z=lcp.back(p.z))

        def newton(faces: int) -> Proposal | None:
            """From Lemke's answer, where that is a number; where it fails, once more in units of the limits."""
            where = propose_pivoted(faces).z
            if not np.isfinite(where).all():
                return None
            p = _FINE_NEWTON.propose_contact(problem, where)
            if has_converged(p) or not len(problem.blocks):
                return p
            return propose_in_limit_units(_FINE_NEWTON, problem, where)

        # A plane's interval, and contacts without friction, are the same with any faces
        flat = m == 2 or len(problem.blocks) == 0
        own = m if 3 <= m <= _OPTIONS.max_pivoted_faces else _OPTIONS.default_faces
        if problem.flat is not None:
            if flat or own == m:
                yield "Lemke", partial(propose_pivoted, own)
            yield f"Newton from Lemke, {own} faces", partial(newton, own)
        others = OtherStarts(_OPTIONS.max_other_starts, seed=seed)
        yield "Newton from other starts", lambda: propose_in_limit_units(others, problem, None)
        if problem.flat is not None and not flat:
            for faces in _OPTIONS.start_faces:
                if faces != own:
                    yield f"Newton from Lemke, {faces} faces", partial(newton, faces)


def is_static(problem: ContactProblem) -> bool:
    """Whether any forces within friction that balance the load of a grasp are an answer, with an object that does not
    move: nothing gives way, nothing is commanded, every contact touches, and effects have no unknowns of their own.
    """
    forces = problem.role > 0
    return not ((~forces).sum() > 6 or problem.q[forces].any() or problem.M[np.ix_(forces, forces)].any())


def propose_in_limit_units(solver: ContactSolver, problem: ContactProblem, start: Array | None) -> Proposal:
    """A solver on the problem with forces in units of their limits, from `start` (n,) of the problem itself."""
    other, s = scale_by_limits(problem)
    p = solver.propose_contact(other, None if start is None else start / s)
    return replace(p, z=s * p.z)


def as_chain(solver: object) -> Auto | None:
    """The chain that this stands for: an `Auto`, stages in order, and the default one where `solver` is None; None for
    a single method.
    """
    return _DEFAULT_CHAIN if solver is None else solver if isinstance(solver, Auto) else None


_DEFAULT_CHAIN = Auto()


@lru_cache(maxsize=256)
def _nsngrk(seed: int, most: int) -> NSNGRK:
    """The same few solvers are asked for again and again; checking their settings would cost a tenth of a solve."""
    return NSNGRK(seed=seed, max_iterations=most)


# ----------------------------------------------------------------
# Solve, certify, report: the one door to the solvers.


AnySolver = Solver | ContactSolver | Auto | None


@check_call()
def solve_lcp(
    problem: LCP | ContactProblem, solver: AnySolver = None, throw: bool = True, start: Array | None = None
) -> LCPSolution:
    """The certified answer to a (mixed) linear complementarity problem.

    solver : `Auto()` when None. start : (n,) first guess in the user's units, zero when None.

    A `ContactProblem` (the exact cone, `grasp.problem("cone")`) is solved likewise; its w is y = M x + q.
    A solver only proposes: the status is the certifier's, recomputed from M, q and z. Raises NoSolutionFound (with
    the problem and the solution) unless SOLVED, or returns whatever came when `throw` is False. Raises InputError
    for anything but an LCP, a solver and a start of the right shape.
    """
    if not isinstance(problem, (LCP, ContactProblem)):
        raise InputError("problem", "an LCP, or a ContactProblem", type(problem).__name__)
    solution = _solve(problem, solver, start)
    if solution.status is not Status.SOLVED and isinstance(problem, LCP):
        solution = _prove_none(problem, solver, solution)
    if throw and solution.status is not Status.SOLVED:
        raise NoSolutionFound("\n  ".join((solution.status.meaning, *solution.trace)), problem, solution)
    return solution


def _solve(problem: LCP | ContactProblem, solver: AnySolver, start: Array | None) -> LCPSolution:
    """Stage by stage, until the certifier is content; else the best there was."""
    units = problem.scaled.units if isinstance(problem, LCP) else problem.units
    if start is not None:
        start = check_array("start", start, (problem.n,)) / units.z
    trace: list[str] = []
    best: tuple[Array, Array, Status, float, Proposal] | None = None
    for name, p in proposals(problem, solver, start):
        z, status, w, residual = certify_scaled(problem, p.z)
        trace.append(stage_line(name, p.outcome, p.iterations, residual))
        if best is None or residual < best[3]:
            best = read_only(z), read_only(w), status, residual, p
        if status is Status.SOLVED:
            break
    assert best is not None  # every solver proposes something
    z, w, status, residual, p = best
    return LCPSolution(z, w, status, residual, p.iterations, None, p.outcome, tuple(trace), p.history)


def _prove_none(problem: LCP, solver: AnySolver, best: LCPSolution) -> LCPSolution:
    """What can still be said where no stage had an answer: no feasible point exists, or the exact search's answer."""
    certificate = farkas_vector(problem)
    trace = (*best.trace, f"Farkas vector: {'none' if certificate is None else 'found'}")
    z, w, status, residual, outcome = best.z, best.w, best.status, best.residual, best.outcome
    if certificate is not None:
        status, residual, outcome = Status.INFEASIBLE, np.inf, "Farkas vector found"
        z = w = read_only(np.full(problem.n, np.nan))  # so that nobody uses them by accident
    elif (chain := as_chain(solver)) is not None and chain.searches:
        exact = search_active_sets(problem, work=chain.search_work, end=chain.search_end())
        trace = (*trace, f"{chain.search_stage}: over active sets, {exact.outcome}")
        if exact.z is not None:
            z, outcome = read_only(exact.z * problem.scaled.units.z), trace[-1]
            status, w, residual = certify(problem, z)
            w = read_only(w)
    return LCPSolution(z, w, status, residual, best.iterations, certificate, outcome, trace, best.history)


def proposals(
    problem: LCP | ContactProblem, solver: AnySolver = None, start: Array | None = None, first: Proposal | None = None
) -> Iterator[tuple[str, Proposal]]:
    """(method, candidate) pairs in natural units, one a stage, computed only when asked for the next.

    first : what the chain's first stage proposes on a contact problem, where the caller knows that already.
    """
    solver = as_chain(solver) or solver
    if isinstance(solver, type) or not isinstance(solver, (Auto, Solver, ContactSolver)):
        known = "Auto(), NSNGRK(), Lemke(), SemismoothNewton() or anything with propose()"
        raise InputError("solver", known, repr(solver))
    name = type(solver).__name__
    if isinstance(solver, Auto):
        if isinstance(problem, LCP):
            yield from solver.stages(problem, start)
        else:
            yield from solver.contact_stages(problem, start, first)
    elif isinstance(problem, ContactProblem):
        if not isinstance(solver, ContactSolver):
            raise Unsupported(f"{name} knows no cones: use Auto(), NSNGRK() or SemismoothNewton(), or faces ≥ 3")
        yield name, solver.propose_contact(problem, start)
    elif isinstance(solver, Solver):
        yield name, solver.propose(problem.scaled, start)
    else:
        raise Unsupported(f"{name} knows contacts only, no plain LCP: use Auto() or NSNGRK()")
