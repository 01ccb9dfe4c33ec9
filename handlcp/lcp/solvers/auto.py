"""The default: a chain of methods, in the order of what they solve in the time they take.

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

from handlcp.check import Array, integer, number
from handlcp.errors import InputError
from handlcp.keywords import helped_init
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.multipliers import WithMultipliers
from handlcp.lcp.problem import LCP, Proposal
from handlcp.lcp.solvers.base import ContactSolver, converged, found_by, measured_by_limits
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.newton import SemismoothNewton
from handlcp.lcp.solvers.nsngrk import NSNGRK
from handlcp.lcp.solvers.starts import OtherStarts
from handlcp.tolerances import FINE, SOLVE

Stage = tuple[str, Callable[[], Proposal | None]]

FIRST_STAGE = "NSNGRK, Newton first"
BRIEFLY, LONGER = "search, briefly", "search, longer"
SOON = 2  # stages between these two
_PLAIN = "NSNGRK"
_ON_SET = ", on the friction set"  # ends the names of stages that work on an LCP's contact form
_FIRST_ON_SET = FIRST_STAGE + _ON_SET
_FACES = (16, 4)  # of pyramids whose answers are worth a start, besides the own or one of 8 faces
_MANY = 16  # faces beyond which pivoting costs more than the other methods
_TRIES = 30  # other starts: most that help are among the first ten
_NEWTON = SemismoothNewton(tol=FINE)


@helped_init()
@dataclass(frozen=True, slots=True)
class Auto:
    """Stages until the certifier is content; `plan` lists them for a problem, the solution's `trace` those that ran.

    On contact problems, and on LCPs that have such a form: NSNGRK that begins with Newton's steps, on a small budget;
    of a grasp, the proof that nothing could hold it, and a brief search; Lemke's method on the problem's own pyramid,
    and Newton's method from its answer (the cone: from that of 8 faces); of a grasp, a longer search; Newton's method
    from where other subsets of the contacts stick or stay apart, and from the answers of other pyramids; of a grasp,
    the rest of the search.
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
            integer(name, getattr(self, name), 0)
        number("search_work", self.search_work, minimum=0.0)
        if self.search_seconds is not math.inf:
            number("search_seconds", self.search_seconds, minimum=0.0, finite=False)

    def first(self, problem: LCP | ContactProblem, start: Array | None = None) -> tuple[str, Proposal]:
        """(method, candidate) of the first stage: most problems end here, before any list of stages is made."""
        if isinstance(problem, ContactProblem):
            return FIRST_STAGE, Proposal(*self._newton_first(problem, start))
        if start is None and isinstance(problem, WithMultipliers):
            x, steps, words = self._newton_first(problem.contact, None)
            return _FIRST_ON_SET, Proposal(problem.lift(x), steps, words)
        return _PLAIN, _nsngrk(self.seed, 3 * problem.n).propose(problem.scaled, start)

    def _newton_first(self, problem: ContactProblem, start: Array | None) -> tuple[Array, int, str]:
        return found_by(problem, self.seed, problem.n, True, SOLVE, start)  # as `NSNGRK` with so many steps

    def others(self, problem: LCP | ContactProblem, start: Array | None = None) -> Iterator[tuple[str, Proposal]]:
        """(method, candidate) of the stages after the first, each computed when asked for."""
        if isinstance(problem, ContactProblem):
            later = self._on_contacts(problem)
        elif start is None and isinstance(problem, WithMultipliers):
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
            if not search:
                return (FIRST_STAGE, "holdability", *rest)
            return (FIRST_STAGE, "holdability", BRIEFLY, *rest[:SOON], LONGER, *rest[SOON:], *search)
        if not isinstance(problem, LCP):
            raise InputError("problem", "an LCP or a ContactProblem, such as grasp.problem()", type(problem).__name__)
        if isinstance(problem, WithMultipliers):
            first, later = _FIRST_ON_SET, self._on_faces(problem)
        else:
            first, later = _PLAIN, self._without_contacts(problem)
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

    def _on_faces(self, problem: WithMultipliers) -> Iterator[Stage]:
        def lifted(run: Callable[[], Proposal | None]) -> Proposal | None:
            p = run()
            return p if p is None else Proposal(problem.lift(p.z), p.iterations, p.outcome, p.history)

        yield "Lemke", lambda: Lemke(seed=self.seed).propose(problem.scaled)
        for name, run in self._on_contacts(problem.contact):
            if name != "Lemke":  # the same as on this problem itself
                yield name + _ON_SET, partial(lifted, run)
        yield self._coverings(problem)

    def _without_contacts(self, problem: LCP) -> Iterator[Stage]:
        n, seed = problem.n, self.seed

        @cache
        def pivoted() -> Proposal:
            return Lemke(seed=seed).propose(problem.scaled)

        def again(k: int) -> Proposal:
            """The first from Lemke's answer, where that is a number."""
            where = pivoted().z if k == 1 and np.isfinite(pivoted().z).all() else None
            return _nsngrk(seed + k, 200 * n).propose(problem.scaled, where)

        yield "Lemke", pivoted
        yield self._coverings(problem)
        yield "Newton from other starts", lambda: OtherStarts(seed=seed).propose(problem.scaled)
        for k in range(1, 1 + self.restarts):
            yield f"{_PLAIN}, seed {seed + k}", partial(again, k)

    def _coverings(self, problem: LCP) -> Stage:
        again = Lemke(coverings=30, seed=self.seed + 1)
        return "Lemke, other covering vectors", lambda: again.propose(problem.scaled)

    def _on_contacts(self, problem: ContactProblem) -> Iterator[Stage]:
        seed, m = self.seed, problem.faces

        @cache
        def pivoted(faces: int) -> Proposal:
            """Lemke's answer for a pyramid, as an x of the problem."""
            assert problem.flat is not None  # nothing else is planned
            lcp = WithMultipliers(problem, problem.flat(faces))
            p = Lemke(seed=seed).propose(lcp.scaled)
            return replace(p, z=lcp.back(p.z))

        def newton(faces: int) -> Proposal | None:
            """From Lemke's answer, where that is a number; where it fails, once more in units of the limits."""
            where = pivoted(faces).z
            if not np.isfinite(where).all():
                return None
            p = _NEWTON.propose_contact(problem, where)
            return p if converged(p) or not len(problem.blocks) else in_units_of_limits(_NEWTON, problem, where)

        # A plane's interval, and contacts without friction, are the same with any faces
        flat = m == 2 or len(problem.blocks) == 0
        own = m if 3 <= m <= _MANY else 8
        if problem.flat is not None:
            if flat or own == m:
                yield "Lemke", partial(pivoted, own)
            yield f"Newton from Lemke, {own} faces", partial(newton, own)
        others = OtherStarts(_TRIES, seed=seed)
        yield "Newton from other starts", lambda: in_units_of_limits(others, problem, None)
        if problem.flat is not None and not flat:
            for faces in _FACES:
                if faces != own:
                    yield f"Newton from Lemke, {faces} faces", partial(newton, faces)


def in_units_of_limits(solver: ContactSolver, problem: ContactProblem, start: Array | None) -> Proposal:
    """A solver on the problem with forces in units of their limits, from `start` (n,) of the problem itself."""
    other, s = measured_by_limits(problem)
    p = solver.propose_contact(other, None if start is None else start / s)
    return replace(p, z=s * p.z)


def as_chain(solver: object) -> Auto | None:
    """The chain that this stands for, the default where it is None; None for a single method."""
    return _DEFAULT if solver is None else solver if isinstance(solver, Auto) else None


_DEFAULT = Auto()


@lru_cache(maxsize=256)
def _nsngrk(seed: int, most: int) -> NSNGRK:
    """The same few solvers are asked for again and again; checking their settings would cost a tenth of a solve."""
    return NSNGRK(seed=seed, max_iterations=most)
