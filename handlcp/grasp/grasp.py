"""The grasp: contacts, load and flexibility in; certified forces, slips and motions out."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, Self, overload

from handlcp.check import Array, number, read_only, yes_or_no
from handlcp.errors import InputError, shown
from handlcp.grasp.assembly.asked import Asked, alone, remade
from handlcp.grasp.assembly.build import build
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Pyramid
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.questions import Questions
from handlcp.keywords import helped_init, helped_methods

if TYPE_CHECKING:
    from handlcp.grasp.analysis.explanation import Explanation
    from handlcp.grasp.answer.solution import GraspSolution
    from handlcp.grasp.assembly.contact_form import GraspContactProblem
    from handlcp.grasp.assembly.problem import AnyProblem, GraspProblem
    from handlcp.lcp import Auto, ContactSolver, Solver


@cache
def _solving() -> tuple[Any, Any, Any]:
    """What a solve calls, imported at the first one; an import statement in each would take a tenth of its time."""
    from handlcp.grasp.analysis.advice import no_solution, solve_with_advice
    from handlcp.grasp.solve.compiled_answer import start_from

    return solve_with_advice, start_from, no_solution


@helped_init()
@helped_methods
class Grasp(Questions):
    """Fingers on an object under a load. Immutable.

    Parameters
    ----------
    contacts : sequence of `Contact`, n of them; all made of 3-vectors, or all of 2-vectors (a planar scene in xy). Or
        a `GraspSpec`, which says all of the following, too.
    wrench : (6,) force [N] and torque [N·m] about `reference` that the world applies to the object, gravity
        included; None: none. A planar scene in xy also takes (Fx, Fy, M).
    flexibility : E [m/N] in contact axes (x, y tangents, z normal): a number, a (3,) diagonal for every contact,
        (n, 3, 3) blocks or the full coupled (3n, 3n) matrix; symmetric positive semidefinite, 0 for rigid fingers. Of
        many contacts on a few joints a `Flexibility`, which is faster.
    preload : squeeze of each normal [m], a number or (n,); short for offset[:, 2] = -preload.
    offset : (n, 3) motion of the object relative to the tips before anything is loaded [m], contact axes; along the
        normal > 0 a gap, < 0 a preload. With a row for every contact it also moves the environment.
    reference : (3,) point [m] that wrench and object motion refer to.
    effects : effects asked for by name, such as `TotalForceBound(50.0)`; the others follow from the data. Compliances
        (`ContactCompliance`, `SoftWrist`) become part of the scene's flexibility.
    plane : (3,) unit normal of the plane of a planar scene given by 3-vectors; None: a spatial scene.
    environment : an `Environment`, or several: what the object touches besides the fingers. Its contacts come last;
        flexibility, preload and offset above are the fingers', n of them, and effects act on fingers alone where their
        docstrings say so.

    Attributes: spec, what was asked, as data; scene, what was built of it: arrays in the coordinates of the friction
    laws, which are contact axes unless a law is anisotropic or soft; and the properties below.

    `replace`, copies and pickles are made as type(self)(spec): a subclass takes a `GraspSpec` as its one argument, too.
    Raises InputError for anything that is not as described.
    """

    def __init__(
        self, contacts: Iterable[Contact] | GraspSpec, wrench: Any = None, *, flexibility: Any = 0.0,
        preload: Any = 0.0, offset: Any = None, reference: Any = (0.0, 0.0, 0.0), effects: Iterable[Effect] = (),
        plane: Any = None, environment: Any = None,
    ) -> None:  # fmt: skip
        more = (wrench, flexibility, preload, offset, reference, effects, plane, environment)
        self.spec = alone(contacts, more) if isinstance(contacts, GraspSpec) else Asked(contacts, *more).spec()
        self.scene = build(self.spec)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """(n,) the fingers', then the environment's."""
        return self.spec.contacts

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Those asked for by name, in `effects=`."""
        return tuple([e for e in self.spec.effects if e.by_name])

    @property
    def reference(self) -> Array:
        """(3,) point that wrench and object motion refer to [m]."""
        return self.spec.reference

    @property
    def frames(self) -> Array:
        """(n, 3, 3) contact axes in columns, world axes."""
        return self.spec.frames

    @property
    def flexibility(self) -> Array:
        """(3n, 3n) E [m/N] of fingers and environment, contact axes; that of `scene` has what effects add."""
        return self.spec.flexibility

    @property
    def offset(self) -> Array:
        """(n, 3) offsets in contact axes [m], with what effects add."""
        return read_only(self.scene.lawful(self.scene.offset)[: 3 * self.scene.n].reshape(-1, 3))

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) finger names: the contacts' own, or "finger 1", "finger 2", …; then the environment's."""
        return self.spec.names

    @overload
    def problem(self, faces: int | Pyramid = 8) -> GraspProblem: ...
    @overload
    def problem(self, faces: str) -> GraspProblem | GraspContactProblem: ...
    def problem(self, faces: int | str | Pyramid = 8) -> AnyProblem:
        """The assembled complementarity problem: look at it, or hand it to `solve_lcp`.

        faces : of the friction pyramids, ≥ 3 (inscribed), or a `Pyramid`: a (mixed) LCP with a multiplier a face; a
        planar scene is exact and ignores them. "cone": the exact cone, whose size doesn't depend on any faces.
        Raises InputError for anything else.
        """
        from handlcp.grasp.assembly.contact_form import stamped
        from handlcp.grasp.assembly.problem import assemble

        problem = assemble(self.scene, self._section(faces), stamped(self.spec.effects))
        problem.complete()
        return problem

    def explain(self, faces: int | str | Pyramid = "cone", measure: bool = False) -> Explanation:
        """Which effects are on and off, why, and what each costs in unknowns.

        measure : also in time: each one's share of a solve, from half a second of solves with it and without it (see
        `grasp.analysis.compare_without`); none where the grasp has no answer, or no scene is without the effect.
        """
        from handlcp.grasp.analysis.compare_without import measured
        from handlcp.grasp.analysis.explanation import explain
        from handlcp.lcp import Auto

        section = self._section(faces)
        found = explain(self.spec, self.scene, section)
        solution = self.solve(faces, Auto(search_seconds=0), throw=False) if measure else None
        return found if solution is None else measured(self.spec, section, found, solution)

    def plan(self, faces: int | str | Pyramid = "cone", chain: Auto | None = None) -> tuple[str, ...]:
        """The stages that `solve` would run, in order, until one answer is certified; see `Auto.plan`."""
        from handlcp.grasp.assembly.contact_form import GraspContactProblem, stamped
        from handlcp.lcp import Auto

        if not (chain is None or isinstance(chain, Auto)):
            raise InputError("chain", "an Auto, or None", shown(chain))
        return (chain or Auto()).plan(GraspContactProblem(self.scene, self._section(faces), stamped(self.spec.effects)))

    def solve(
        self, faces: int | str | Pyramid = "cone", solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True, accuracy: float | None = None, start: GraspSolution | None = None, proof: bool = True,
    ) -> GraspSolution:  # fmt: skip
        """Grasp forces, slips and object motion, certified.

        faces : see `problem`. solver : `Auto()` when None. accuracy : the error of the forces that will do, as a share
        of the largest; on the exact cone alone. The solution's `accuracy` says what error it estimates.
        start : the solution of a nearby grasp of as many contacts; from there it takes one or two Newton steps. Where
        friction allows several equilibria, it also says which one to look for.
        proof : where none is found, whether to prove that there is none; False: stop there, in bounded time, and say
        UNDECIDED.
        Raises NoSolutionFound (with problem and solution) unless SOLVED, or returns what came when `throw` is False;
        InputError for bad arguments, faces and accuracy both among them.
        """
        solve_with_advice, start_from, no_solution = _solving()
        where, proof = start_from(start, self.scene), yes_or_no("proof", proof)
        if accuracy is None:
            section = self._section(faces)
            solution: GraspSolution = solve_with_advice(self.spec, section, solver, where, self.scene, proof)
        elif faces == "cone":
            from handlcp.grasp.analysis.solve_to_accuracy import solve_to_accuracy

            asked = number("accuracy", accuracy, above=0.0)
            section, solution = self._section("cone"), solve_to_accuracy(self.spec, asked, solver, where, proof)
        else:
            raise InputError("accuracy", "no faces beside it: it is of the exact cone", f"faces={faces!r}")
        reached = solution.accuracy
        if not throw or (solution.held and (reached is None or reached.met)):
            return solution
        from handlcp.grasp.assembly.contact_form import stamped
        from handlcp.grasp.assembly.problem import assemble

        raise no_solution(assemble(self.scene, section, stamped(self.spec.effects)), solution)

    def replace(
        self, *, wrench: Any = None, flexibility: Any = None, offset: Any = None, preload: Any = None,
        friction: Any = None, effects: Any = None, environment: Any = None,
    ) -> Self:  # fmt: skip
        """The grasp made again with other arguments, each as in `Grasp`; None: as it was given. friction : of the
        fingers: a coefficient, a law, or a mapping by finger, where the others keep theirs. () takes effects or
        environment away. Raises InputError.
        """
        given = dict(wrench=wrench, flexibility=flexibility, offset=offset, preload=preload, friction=friction)
        return type(self)(remade(self.spec, given | dict(effects=effects, environment=environment)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what was asked."""
        return (type(self), (self.spec,))

    def __repr__(self) -> str:
        s = self.scene
        more = (", planar" if s.kind.planar else "") + (
            f", {s.environment} of the environment" if s.environment else ""
        )
        return f"{type(self).__name__}({s.n} contacts, {sum(t > 0 for t in s.kind.tangents)} with friction{more})"
