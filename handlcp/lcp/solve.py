"""Solve, certify, report: the one door to the solvers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, NoSolutionFound, Unsupported
from handlcp.keywords import helped
from handlcp.lcp.certify import certified, certify, farkas_vector
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import LCP, LCPSolution, Proposal, Status, stage_line
from handlcp.lcp.search import search
from handlcp.lcp.solvers.auto import Auto, as_chain
from handlcp.lcp.solvers.base import ContactSolver, Solver

AnySolver = Solver | ContactSolver | Auto | None


@helped()
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
        solution = _proof(problem, solver, solution)
    if throw and solution.status is not Status.SOLVED:
        raise NoSolutionFound("\n  ".join((solution.status.meaning, *solution.trace)), problem, solution)
    return solution


def _solve(problem: LCP | ContactProblem, solver: AnySolver, start: Array | None) -> LCPSolution:
    """Stage by stage, until the certifier is content; else the best there was."""
    units = problem.scaled.units if isinstance(problem, LCP) else problem.units
    if start is not None:
        start = array("start", start, (problem.n,)) / units.z
    trace: list[str] = []
    best: tuple[Array, Array, Status, float, Proposal] | None = None
    chain = as_chain(solver)
    if chain is None:
        found = proposals(problem, solver, start)
    else:
        found = itertools.chain((chain.first(problem, start),), chain.others(problem, start))
    for name, p in found:
        z, status, w, residual = certified(problem, p.z)
        trace.append(stage_line(name, p.outcome, p.iterations, residual))
        if best is None or residual < best[3]:
            best = read_only(z), read_only(w), status, residual, p
        if status is Status.SOLVED:
            break
    assert best is not None  # every solver proposes something
    z, w, status, residual, p = best
    return LCPSolution(z, w, status, residual, p.iterations, None, p.outcome, tuple(trace), p.history)


def _proof(problem: LCP, solver: AnySolver, best: LCPSolution) -> LCPSolution:
    """What can still be said where no stage had an answer: no feasible point exists, or the exact search's answer."""
    certificate = farkas_vector(problem)
    trace = (*best.trace, f"Farkas vector: {'none' if certificate is None else 'found'}")
    z, w, status, residual, outcome = best.z, best.w, best.status, best.residual, best.outcome
    if certificate is not None:
        status, residual, outcome = Status.INFEASIBLE, np.inf, "Farkas vector found"
        z = w = read_only(np.full(problem.n, np.nan))  # so that nobody uses them by accident
    elif (chain := as_chain(solver)) is not None and chain.searches:
        exact = search(problem, work=chain.search_work, end=chain.search_end())
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
