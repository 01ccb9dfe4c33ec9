"""The default: a documented chain of methods, in the order of what they solve in the time they take.

Of the contact problems that the first stage leaves unsolved and anything solves, Lemke's method on the own pyramid
solves 95 in 100, Newton's method from its answer 97 (of cones: 88), at the price of a few Newton runs. Each later stage
is there because it solves some that nothing before it does. What never did is left out: the first stage with another
seed and as few steps, and growing the load from the preload alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from handlcp.check import Array, integer, number
from handlcp.errors import InputError
from handlcp.lcp.balls import BallProblem
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import LCP
from handlcp.lcp.result import Proposal
from handlcp.lcp.solvers.balls import ball_plan
from handlcp.lcp.solvers.base import ContactSolver
from handlcp.lcp.solvers.continuation import Continuation
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.newton import SemismoothNewton
from handlcp.lcp.solvers.nsngrk import NSNGRK
from handlcp.lcp.solvers.starts import OtherStarts
from handlcp.lcp.solvers.variants import FINE, converged, in_units_of_limits

__all__ = ["Auto", "as_chain"]

Stage = tuple[str, Callable[[], Proposal | None]]

_ON_SET = ", on the friction set"  # ends the names of stages that work on an LCP's contact form


@dataclass(frozen=True, slots=True)
class Auto:
    """Stages until the certifier is content; `plan` lists them for a problem, the solution's `trace` those that ran.

    On contact problems, and on LCPs that have such a form: NSNGRK with polish on a small budget; Lemke's method on the
    problem's own pyramid; Newton's method from its answer (the cone: from that of 8 faces); from where other subsets
    of the contacts stick or stay apart; Lemke's method with other covering vectors; Newton's method from the answers of
    other pyramids; continuation from a stronger squeeze and from more friction; more subsets; NSNGRK again with more
    steps, from Lemke's answer and from other starts and seeds, at last on a pyramid's multipliers.
    On balls (soft fingers on the exact cone): Newton's method from where contacts stick, from Lemke's answers on two
    polyhedra, from other starts, and from more friction.
    On other LCPs: NSNGRK, Lemke's method with one, then with other covering vectors, Newton's method from other active
    sets, NSNGRK again.
    Then the proof that there is no answer: a Farkas vector, or of a grasp that nothing could hold it; and last the
    exact search.

    seed : of the first run; later runs use the seeds that follow.
    restarts : NSNGRK runs with other seeds, after all else.
    search_seconds : where none of these solves a grasp that could be held, or an LCP that is not proven infeasible:
        time for an exact search over all contact modes or active sets, which finds a solution or, for a grasp, proves
        that there is none within bounds. 0: no search.
    """

    seed: int = 0
    restarts: int = 1
    search_seconds: float = 2.0

    def __post_init__(self) -> None:
        """Check the settings."""
        for name in ("seed", "restarts"):
            integer(name, getattr(self, name), 0)
        number("search_seconds", self.search_seconds, minimum=0.0)

    def stages(self, problem: LCP, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a plain LCP, each computed when asked for."""
        if start is None and (contact := problem.contact) is not None:
            # Most problems end here, sooner than the list of what else there is could be made
            p = _nsngrk(self.seed, contact.n).propose_contact(contact)
            yield _FIRST + _ON_SET, Proposal(problem.lift(p.z), p.iterations, p.outcome)
        for name, run in self._plain(problem, start):
            if name != _FIRST + _ON_SET and (later := run()) is not None:
                yield name, later

    def contact_stages(
        self, problem: ContactProblem, start: Array | None = None, first: Proposal | None = None
    ) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) for a contact problem, each computed when asked for; `first` where it is known."""
        yield _FIRST, first or _nsngrk(self.seed, problem.n).propose_contact(problem, start)
        for name, run in self._contact(problem, start):
            if name != _FIRST and (later := run()) is not None:
                yield name, later

    def plan(self, problem: LCP | ContactProblem | BallProblem) -> tuple[str, ...]:
        """What would run on this problem, in order, until one answer is certified; `Grasp.plan` says it of a grasp.

        Stages may be passed over (where Lemke's method has no answer, nothing starts from it); none is added. The
        solution's `trace` begins its lines with these names. The end of a contact problem's plan is what `Grasp.solve`
        does; `solve_lcp` stops before it. Raises InputError for anything but a problem.
        """
        search = (self.search_stage,) if self.search_seconds > 0 else ()
        if isinstance(problem, BallProblem):
            return (*ball_plan(problem), *(("holdability", *search) if hasattr(problem, "scene") else ()))
        if not isinstance(problem, (LCP, ContactProblem)):
            raise InputError("problem", "an LCP or a ContactProblem, such as grasp.problem()", type(problem).__name__)
        if isinstance(problem, ContactProblem):
            names = tuple(name for name, _ in self._contact(problem, None))
            return (*names, "holdability", *search) if hasattr(problem, "scene") else names
        return (*(name for name, _ in self._plain(problem, None)), "Farkas vector", *search)

    @property
    def search_stage(self) -> str:
        """Name of the exact search in plans and traces."""
        return f"search, {self.search_seconds:g} s at most"

    def _plain(self, problem: LCP, start: Array | None) -> Iterator[Stage]:
        n, contact, seed = problem.n, problem.contact if start is None else None, self.seed
        pivoted: list[Array] = []

        def pivot() -> Proposal:
            pivoted.append((p := Lemke(seed=seed).propose(problem.scaled)).z)
            return p

        def lifted(run: Callable[[], Proposal | None]) -> Proposal | None:
            p = run()
            return p if p is None else Proposal(problem.lift(p.z), p.iterations, p.outcome)

        if contact is not None:
            on_set = self._contact(contact, None)
            name, first = next(on_set)
            yield name + _ON_SET, lambda: lifted(first)
        else:
            yield _FIRST, lambda: _nsngrk(seed, 3 * n).propose(problem.scaled, start)
        yield "Lemke", pivot
        if contact is not None:
            for name, run in on_set:
                if name not in ("Lemke", _COVERINGS, "NSNGRK with multipliers"):  # the same as on this problem itself
                    yield name + _ON_SET, lambda run=run: lifted(run)  # type: ignore[misc]
        yield _COVERINGS, lambda: Lemke(coverings=30, seed=seed + 1).propose(problem.scaled)
        if contact is None:
            yield "Newton from other starts", lambda: OtherStarts(seed=seed).propose(problem.scaled)
        for k in range(self.restarts):
            again = _nsngrk(seed + 1 + k, 200 * n)
            where = _finite(pivoted) if k == 0 else None
            yield f"NSNGRK, seed {seed + 1 + k}", lambda a=again, w=where: a.propose(problem.scaled, w)  # type: ignore[misc]

    def _contact(self, problem: ContactProblem, start: Array | None) -> Iterator[Stage]:
        n, seed, m = problem.n, self.seed, problem.faces
        yield _FIRST, lambda: _nsngrk(seed, n).propose_contact(problem, start)

        stage = _Later(problem, seed)
        # A plane's interval, and contacts without friction, are the same with any faces
        flat = m == 2 or len(problem.blocks) == 0
        own = m if 3 <= m <= _MANY else 8
        exact = problem.pyramid is not None and (flat or own == m)
        pyramids = [] if problem.pyramid is None else [own] if flat else [own, 16, 12, 6, 4]
        if exact:
            yield "Lemke", lambda: stage.lemke(own)
        for faces in pyramids[:1]:
            yield f"Newton from Lemke, {faces} faces", lambda f=faces: stage.near(f)  # type: ignore[misc]
        yield "Newton from other starts", lambda: stage.on_limits(OtherStarts(10, seed=seed))
        if exact:
            yield _COVERINGS, lambda: stage.lemke(own, 30)
        for faces in dict.fromkeys((*pyramids[1:], *((m,) if _MANY < m <= 64 else ()))):
            if faces != own:
                yield f"Newton from Lemke, {faces} faces", lambda f=faces: stage.near(f)  # type: ignore[misc]
        yield "continuation of the squeeze", lambda: Continuation("squeeze", 3.0).propose_contact(problem)
        if len(problem.blocks):
            yield "continuation of the friction", lambda: Continuation("friction", 10.0).propose_contact(problem)
        yield "Newton from more starts", lambda: stage.on_limits(OtherStarts(100, seed=seed + 1))
        for k in range(self.restarts):
            # The first from Lemke's answer, where there is one; the second from nothing
            again = _nsngrk(seed + 1 + k, 100 * n)

            def run(again: NSNGRK = again, k: int = k) -> Proposal:
                start = stage.pivoted(own) if k == 0 else np.zeros(n) if k == 1 else None
                return again.propose_contact(problem, start)

            yield f"NSNGRK, seed {seed + 1 + k}", run
        if exact:
            yield "NSNGRK with multipliers", lambda: stage.multipliers(own)


class _Later:
    """The stages after the first, which share what Lemke's method found."""

    def __init__(self, problem: ContactProblem, seed: int) -> None:
        self.problem, self.seed = problem, seed
        self.answers: dict[int, Proposal] = {}

    def on_limits(self, solver: ContactSolver, start: Array | None = None) -> Proposal:
        """A solver on the problem with forces in units of their limits, from `start` (n,) of the problem itself."""
        problem, s = in_units_of_limits(self.problem)
        p = solver.propose_contact(problem, None if start is None else start / s)
        return replace(p, z=s * p.z)

    def lemke(self, faces: int, coverings: int = 3) -> Proposal:
        """Lemke's answer for a pyramid, as an x of the problem."""
        if faces not in self.answers or coverings > 3:
            assert self.problem.pyramid is not None
            lcp, back = self.problem.pyramid(faces)
            p = Lemke(coverings=coverings, seed=self.seed + (coverings > 3)).propose(lcp.scaled)
            self.answers[faces] = replace(p, z=back(p.z))
        return self.answers[faces]

    def multipliers(self, faces: int) -> Proposal:
        """NSNGRK as the paper has it: on the plain LCP, a multiplier a face."""
        assert self.problem.pyramid is not None
        lcp, back = self.problem.pyramid(faces)
        p = _nsngrk(self.seed + 1, 20 * self.problem.n).propose(lcp.scaled)
        return replace(p, z=back(p.z))

    def pivoted(self, faces: int) -> Array | None:
        """Lemke's answer where it was asked for and is a number."""
        z = self.answers[faces].z if faces in self.answers else None
        return z if z is not None and np.isfinite(z).all() else None

    def near(self, faces: int) -> Proposal | None:
        """Newton's method from Lemke's answer; where it fails, once more with forces in units of their limits."""
        self.lemke(faces)
        where = self.pivoted(faces)
        if where is None:
            return None
        p = _NEWTON.propose_contact(self.problem, where)
        return p if converged(p) or not len(self.problem.blocks) else self.on_limits(_NEWTON, where)


def as_chain(solver: object) -> Auto | None:
    """The chain that this stands for, the default where it is None; None for a single method."""
    return Auto() if solver is None else solver if isinstance(solver, Auto) else None


_FIRST = "NSNGRK"
_COVERINGS = "Lemke, other covering vectors"
_MANY = 16  # faces beyond which pivoting costs more than the other methods: tried late
_NEWTON = SemismoothNewton(tol=FINE)


def _finite(answers: list[Array]) -> Array | None:
    return answers[-1] if answers and np.isfinite(answers[-1]).all() else None


@lru_cache(maxsize=256)
def _nsngrk(seed: int, most: int) -> NSNGRK:
    """The same few solvers are asked for again and again; checking their settings would cost a tenth of a solve."""
    return NSNGRK(seed=seed, max_iterations=most)
