"""Solve, certify, report: the one door to the solvers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, NoSolutionFound, Unsupported
from handlcp.lcp.balls import BallProblem
from handlcp.lcp.certify import certify, certify_balls, certify_contact
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.infeasible import farkas_vector
from handlcp.lcp.kernels.residual import product
from handlcp.lcp.problem import LCP
from handlcp.lcp.result import LCPSolution, Proposal
from handlcp.lcp.search import search
from handlcp.lcp.solvers.auto import Auto, as_chain
from handlcp.lcp.solvers.balls import ball_stages
from handlcp.lcp.solvers.base import ContactSolver, Solver
from handlcp.lcp.status import Status

__all__ = ["proposals", "solve_lcp"]


def solve_lcp(
    problem: LCP | ContactProblem | BallProblem,
    solver: Solver | ContactSolver | Auto | None = None,
    throw: bool = True,
    start: Array | None = None,
) -> LCPSolution:
    """The certified answer to a (mixed) linear complementarity problem.

    solver : `Auto()` when None. start : (n,) first guess in the user's units, zero when None.

    A `ContactProblem` (the exact cone, `grasp.problem("cone")`), or a `BallProblem` (with soft fingers), is solved
    likewise; its w is y = M x + q.
    A solver only proposes: the status is the certifier's, recomputed from M, q and z. Raises NoSolutionFound (with
    the problem and the solution) unless SOLVED, or returns whatever came when `throw` is False. Raises InputError
    for anything but an LCP, a solver and a start of the right shape.
    """
    if not isinstance(problem, (LCP, ContactProblem, BallProblem)):
        raise InputError("problem", "an LCP, or a ContactProblem", type(problem).__name__)
    units = problem.scaled.units if isinstance(problem, LCP) else problem.units
    if start is not None:
        start = array("start", start, (problem.n,)) / units.z
    trace: list[str] = []
    best: tuple[float, Array, Array, Proposal] | None = None
    status = Status.UNDECIDED
    for name, proposal in proposals(problem, solver, start):
        z = product(proposal.z, units.z)
        if isinstance(problem, ContactProblem):
            status, w, residual = certify_contact(problem, proposal.z)
        elif isinstance(problem, BallProblem):
            status, w, residual = certify_balls(problem, proposal.z)
        else:
            status, w, residual = certify(problem, z)
        trace.append(f"{name}: {proposal.outcome}, {proposal.iterations} iterations, residual {residual:.1e}")
        if best is None or residual < best[0]:
            best = residual, z, w, proposal
        if status is Status.SOLVED:
            break
    assert best is not None  # every solver proposes something
    residual, z, w, proposal = best
    certificate = None
    outcome = proposal.outcome
    if status is not Status.SOLVED and isinstance(problem, LCP):
        certificate = farkas_vector(problem)
        trace.append(f"Farkas vector: {'none' if certificate is None else 'found'}")
        if certificate is not None:
            status, residual, outcome = Status.INFEASIBLE, np.inf, "Farkas vector found"
            z = w = np.full(problem.n, np.nan)  # so that nobody uses them by accident
        elif (chain := as_chain(solver)) is not None and chain.search_seconds > 0:
            exact = search(problem, seconds=chain.search_seconds)
            trace.append(f"{chain.search_stage}: over active sets, {exact.outcome}")
            if exact.z is not None:
                z, outcome = exact.z * units.z, trace[-1]
                status, w, residual = certify(problem, z)
    solution = LCPSolution(
        read_only(z),
        read_only(w),
        status,
        residual,
        proposal.iterations,
        certificate,
        outcome,
        tuple(trace),
        proposal.history,
    )
    if throw and solution.status is not Status.SOLVED:
        raise NoSolutionFound("\n  ".join((solution.status.meaning, *trace)), problem, solution)
    return solution


def proposals(
    problem: LCP | ContactProblem | BallProblem,
    solver: Solver | ContactSolver | Auto | None = None,
    start: Array | None = None,
    first: Proposal | None = None,
) -> Iterator[tuple[str, Proposal]]:
    """(method, candidate) pairs in natural units, one a stage, computed only when asked for the next.

    first : what the chain's first stage proposes on a contact problem, where the caller knows that already.
    """
    solver = Auto() if solver is None else solver
    if isinstance(solver, type) or not isinstance(solver, (Auto, Solver, ContactSolver)):
        raise InputError(
            "solver", "Auto(), NSNGRK(), Lemke(), SemismoothNewton() or anything with propose()", repr(solver)
        )
    if isinstance(problem, BallProblem):
        if not isinstance(solver, Auto):
            raise Unsupported(
                f"{type(solver).__name__} knows no soft fingers on the exact cone: use Auto(), or faces ≥ 3"
            )
        yield from ball_stages(problem, solver.seed, start)
    elif isinstance(problem, ContactProblem):
        if isinstance(solver, Auto):
            yield from solver.contact_stages(problem, start, first)
        elif isinstance(solver, ContactSolver):
            yield type(solver).__name__, solver.propose_contact(problem, start)
        else:
            raise Unsupported(
                f"{type(solver).__name__} knows no cones: use Auto(), NSNGRK() or SemismoothNewton(), or faces ≥ 3"
            )
    elif isinstance(solver, Auto):
        yield from solver.stages(problem, start)
    elif isinstance(solver, Solver):
        yield type(solver).__name__, solver.propose(problem.scaled, start)
    else:
        raise Unsupported(f"{type(solver).__name__} knows contacts only, no plain LCP: use Auto() or NSNGRK()")
