"""`Grasp`: what is held, by which contacts, under which load; and everything that can be asked of it."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, Self, overload

from handlcp.check import Array, check_call, check_flag, check_init_call, check_method_calls, check_number, read_only
from handlcp.contact.friction import Pyramid, Section, as_section
from handlcp.errors import InputError, NoSolutionFound, shorten_repr
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.request import ContactGraspRequest, GraspSpec, check_loads, rebuild

if TYPE_CHECKING:
    from handlcp.grasp.analysis.equilibria import Equilibria
    from handlcp.grasp.analysis.explanation import Explanation
    from handlcp.grasp.analysis.required_value import Required
    from handlcp.grasp.analysis.suggestions import Suggestions
    from handlcp.grasp.assembly.problem import AnyProblem, GraspContactProblem, GraspProblem
    from handlcp.grasp.design.best_change import BestChange
    from handlcp.grasp.design.required_value import RequiredStiffness
    from handlcp.grasp.limits.result import LoadLimit
    from handlcp.grasp.margins.margins import Margins
    from handlcp.grasp.path.follow import Loading
    from handlcp.grasp.solution.solution import GraspSolution
    from handlcp.grasp.solution.verdict import Verdict
    from handlcp.lcp import Auto, ContactSolver, Solver


@cache
def _solve_functions() -> tuple[Any, Any, Any]:
    """What a solve calls, imported at the first one; an import statement in each would take a tenth of its time."""
    from handlcp.grasp.analysis.solve_to_accuracy import make_no_solution_error, solve_with_preload_hint
    from handlcp.grasp.solve.compiled_answer import start_values

    return solve_with_preload_hint, start_values, make_no_solution_error


@check_init_call()
@check_method_calls
class Grasp:
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
        if isinstance(contacts, GraspSpec):
            if any(x is not None for x in (wrench, offset, plane, environment)) or effects != ():
                given = "a GraspSpec, which says all of it"
                raise InputError("contacts", "contacts, where other arguments are given", given)
            self.spec = contacts
        else:
            more = (wrench, flexibility, preload, offset, reference, effects, plane, environment)
            self.spec = ContactGraspRequest(contacts, *more).spec()
        self.scene = build_scene(self.spec)

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
        return read_only(self.scene.motions_to_contact_axes(self.scene.offset)[: 3 * self.scene.n].reshape(-1, 3))

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) names of the contacts, the fingers' first: their own, or "finger 1", "finger 2", … for those without."""
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
        from handlcp.grasp.assembly.problem import asked_effects_with_rows, assemble

        problem = assemble(self.scene, self._section(faces), asked_effects_with_rows(self.spec.effects))
        problem.complete()
        return problem

    def explain(self, faces: int | str | Pyramid = "cone", measure: bool = False) -> Explanation:
        """Which effects are on and off, why, and what each costs in unknowns.

        measure : also in time: each one's share of a solve, from half a second of solves with it and without it (see
        `measure_shares`); none where the grasp has no answer, or no scene is without the effect.
        """
        from handlcp.grasp.analysis.explanation import explain_effects, measure_shares
        from handlcp.lcp import Auto

        section = self._section(faces)
        found = explain_effects(self.spec, self.scene, section)
        solution = self.solve(faces, Auto(search_seconds=0), throw=False) if measure else None
        return found if solution is None else measure_shares(self.spec, section, found, solution)

    def plan(self, faces: int | str | Pyramid = "cone", chain: Auto | None = None) -> tuple[str, ...]:
        """The stages that `solve` would run, in order, until one answer is certified; see `Auto.plan`."""
        from handlcp.grasp.assembly.problem import GraspContactProblem, asked_effects_with_rows
        from handlcp.lcp import Auto

        if not (chain is None or isinstance(chain, Auto)):
            raise InputError("chain", "an Auto, or None", shorten_repr(chain))
        return (chain or Auto()).plan(
            GraspContactProblem(self.scene, self._section(faces), asked_effects_with_rows(self.spec.effects))
        )

    def solve(
        self, faces: int | str | Pyramid = "cone", solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True, accuracy: float | None = None, start: GraspSolution | None = None, proof: bool = True,
    ) -> GraspSolution:  # fmt: skip
        """Grasp forces, slips and object motion, certified.

        faces : see `problem`. solver : `Auto()` when None. accuracy : the error of the forces that will do, as a share
        of the largest; on the exact cone alone. The solution's `accuracy` says what error it estimates.
        start : the solution of a nearby grasp of as many contacts; from there it takes one or two Newton steps. Where
        friction allows several equilibria, it also says which one to look for.
        proof : where none is found, whether to prove that there is none; False: the first stage and the escape
        proof alone, in bounded time; UNDECIDED may then be an answer that later stages find.
        Raises NoSolutionFound (with problem and solution) unless SOLVED, and as accurate as asked; or returns what came
        when `throw` is False. Raises InputError for bad arguments, faces and accuracy both among them.
        """
        solve_with_preload_hint, warm_start_values, no_solution = _solve_functions()
        where, proof = warm_start_values(start, self.scene), check_flag("proof", proof)
        if accuracy is None:
            section = self._section(faces)
            solution: GraspSolution = solve_with_preload_hint(self.spec, section, solver, where, self.scene, proof)
        elif faces == "cone":
            from handlcp.grasp.analysis.solve_to_accuracy import solve_to_accuracy

            asked = check_number("accuracy", accuracy, above=0.0)
            section, solution = self._section("cone"), solve_to_accuracy(self.spec, asked, solver, where, proof)
        else:
            raise InputError("accuracy", "no faces beside it: it is of the exact cone", f"faces={faces!r}")
        reached = solution.accuracy
        if not throw or (solution.held and (reached is None or reached.met)):
            return solution
        from handlcp.grasp.assembly.problem import asked_effects_with_rows, assemble

        raise no_solution(assemble(self.scene, section, asked_effects_with_rows(self.spec.effects)), solution)

    def replace(
        self, *, wrench: Any = None, flexibility: Any = None, offset: Any = None, preload: Any = None,
        friction: Any = None, effects: Any = None, environment: Any = None,
    ) -> Self:  # fmt: skip
        """The grasp made again with other arguments, each as in `Grasp`; None: as it was given. friction : of the
        fingers: a coefficient, a law, or a mapping by finger, where the others keep theirs. () takes effects or
        environment away. Raises InputError.
        """
        given = dict(wrench=wrench, flexibility=flexibility, offset=offset, preload=preload, friction=friction)
        given |= dict(effects=effects, environment=environment)
        return type(self)(rebuild(self.spec, given, ContactGraspRequest))

    def suggest(
        self, solution: GraspSolution | None = None, faces: int | str | Pyramid = "cone", least: float = 0.05
    ) -> Suggestions:
        """Which effects that are left out would change the answer by more than `least` of its largest force, each
        evaluated once; of a grasp that fails, also changes that were tried and hold it, the least of each kind.

        solution : of this grasp, solved with `faces`; None: solved now. Raises InputError.
        """
        from handlcp.grasp.verdict.check import make_suggestions

        solution = self._take_solution(faces, solution)
        check_number("least", least, minimum=0.0)
        verdict = solution.verdict if solution.verdict.ok else self.check(faces=faces, solution=solution)
        return make_suggestions(self.spec, self._section(faces), solution, least, verdict)

    def required_preload(self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3) -> Required:
        """The smallest squeeze [m], added to every finger as a preload, with which the grasp holds, to a relative
        tolerance: as `solve` says, or `check` where hand and object are known. Its `verdict` is the word of `check`.
        """
        from handlcp.grasp.design.required_value import confirm_required_preload

        return confirm_required_preload(self.spec, self._section(faces), tolerance)

    def required_friction(self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3) -> Required:
        """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds: as
        `solve` says, or `check` where hand and object are known, which has to hold the object where it was gripped:
        with less it may snap to another place and rest there. Its `verdict` is the word of `check`, and its `hint` says
        where more friction does not hold better.
        """
        from handlcp.grasp.design.required_value import confirm_required_friction

        return confirm_required_friction(self.spec, self._section(faces), tolerance)

    def required_stiffness(
        self, motion: float, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3
    ) -> RequiredStiffness:
        """The least factor on the stiffness of all joints (of the fingers, where no joints are known) with which the
        object moves by no more than `motion` [m], its reference point from the end of the squeeze to the whole load.

        Pads stay as they are. A grip force stays the force that it is; a squeeze stays as deep, and a joint offset as
        large, so that stiffer joints press harder. tolerance : relative. Raises InputError.
        """
        from handlcp.grasp.design.required_value import required_stiffness

        return required_stiffness(self.spec, self._section(faces), motion, tolerance)

    def best_change(
        self, wrench: Any = None, share: float = 0.1, *, geometry: str | None = None,
        faces: int | str | Pyramid = "cone",
    ) -> BestChange:  # fmt: skip
        """Which single change buys most load: preload, friction or stiffness (of a hand: grip, friction, stiffness or
        torque limits), each changed by the same share, more and less where both can help. A grip force stays the force
        that it is where joints are made stiffer or softer.

        wrench : (6,) the load that grows, beside the weight, as in `load_limit`; None: the grasp's own, or where it has
        none, extra weight of the object. The load limit is found anew with each change, and `check()` judges the best
        one.
        Raises InputError, Unsupported (known forces).
        """
        from handlcp.grasp.design.best_change import best_change

        return best_change(self.spec, self._section(faces), wrench, share, geometry)

    def equilibria(self, faces: int | str | Pyramid = "cone", seconds: float = 2.0) -> Equilibria:
        """All equilibria that `seconds` are enough for, certified, and whether it is proven that there are no more.

        faces : see `problem`. Friction can hold an object in several ways under one load; `solve` returns one of them.
        """
        from handlcp.grasp.analysis.equilibria import equilibria

        return equilibria(self.spec, self._section(faces), check_number("seconds", seconds, above=0.0))

    @check_call(most_force="what an object bears is asked by required_grip(most_force=...)")
    def check(
        self, order: Any = ("squeeze", "load"), faces: int | str | Pyramid = "cone",
        solution: GraspSolution | None = None, *, max_slip: Any = 1e-3,
    ) -> Verdict:  # fmt: skip
        """Does it hold? The verdict when it is squeezed, then loaded, as by `follow`. HELD: the end is reached, no
        contact has slid as far as `max_slip` and the object has not snapped since the load began, joints are within
        their torque limits, and no link or joint is where the hand cannot be. Doubtful limits are named; where it does
        not hold, what was tried and would help.

        order, faces : as in `follow`.
        solution : of this grasp with these faces; None: solved now.
        max_slip : how far a contact that presses may slide since the load began [m], the length of its way: a number,
            one for each contact or by name; inf: any distance.
        Raises InputError, UnknownName.
        """
        from handlcp.grasp.verdict.check import check

        found = self._take_solution(faces, solution)
        return check(self.spec, self.scene, self._section(faces), order, found, max_slip)

    def follow(
        self, load: Any = None, order: Any = ("squeeze", "load"), geometry: str | None = None,
        throw: bool = False, faces: int | str | Pyramid = "cone", steps: int = 40, tolerance: float | None = None,
        accuracy: float | None = None, max_slip: Any = 1e-3,
    ) -> Loading:  # fmt: skip
        """The grasp loaded in quasi-static steps: is it held to the end (`held`), what slips on the way, where is it
        lost and why.

        load : (6,) beside the object's weight at the end, about the reference; None: the grasp's own; (m, 6): one after
        the other; of a planar grasp also (3,) and (m, 3), as in `Grasp`. Of contacts without a hand it is all that
        loads them: their wrench is not added. order : stages "squeeze" (preload and joint offset), "load" (weight and
        load), "together", or `Stage`s. geometry : "followed", contacts detected anew in every step; "fixed", those of
        this posture; None: the first where hand and object are known. steps : of a stage at least; how many there are
        is for their errors to say. tolerance : how far a step's end may be from where its contacts were taken, as a
        share of their radii; None: 1e-9. accuracy : estimated error of the forces that a step may have, as a share of
        the largest; None: 1e-3. max_slip : as in `check`. faces : as in `problem`. Raises InputError, UnknownName,
        Unsupported (known forces); with `throw`, NoSolutionFound unless it is held.
        """
        from handlcp.grasp.path.follow import follow

        loads = None if load is None else check_loads(self.spec, load, "load")
        found = follow(self.spec, self._section(faces), loads, order, geometry, steps, tolerance, accuracy, max_slip)
        if throw and not found.held:
            raise NoSolutionFound(found.sentence, found, found.solution)
        return found

    def load_limit(
        self, wrench: Any = None, *, geometry: str | None = None, faces: int | str | Pyramid = "cone",
        motion: float | None = None, turn: float | None = None, accuracy: float | None = None, max_slip: Any = 1e-3,
    ) -> LoadLimit:  # fmt: skip
        """The largest factor on a load that the grasp holds when it is squeezed, then carries its weight, and the load
        grows slowly; and what gives out there: a contact has slid `max_slip`, the object is lost, a joint is at its
        torque limit or at the end of its range. `first_slip`, `slides` and `lost` are loads of these. With
        `TorqueSaturation` a joint at its limit yields, and the load grows on until something else gives out.

        wrench : (6,) force [N] and torque [N·m] beside the weight, about the reference, or (3,) of a planar grasp, as
        in `Grasp`; None: the grasp's own. Nobody knows what of the wrench of contacts without a hand is weight: all of
        it stays on while another load grows, and a load of None is that wrench itself, from nothing. geometry : as in
        `follow`. faces : as in `problem`. motion, turn : how far
        the object may move [m] and turn [rad] from where the load finds it; None: any distance. accuracy : estimated
        error of the forces that a step may have, as a share of the largest; None: 1e-3. max_slip : as in `check`.
        Raises InputError, UnknownName, Unsupported (known forces).
        """
        from handlcp.grasp.limits.load_limit import load_limit

        return load_limit(self.spec, self._section(faces), wrench, geometry, motion, turn, accuracy, max_slip)

    def payload(
        self, orientations: Any = 6, acceleration: float = 0.0, *, geometry: str | None = None,
        faces: int | str | Pyramid = "cone", motion: float | None = None, turn: float | None = None,
        accuracy: float | None = None, max_slip: Any = 1e-3,
    ) -> Any:  # fmt: skip
        """The largest mass [kg] that the grasp holds in every direction of gravity that is asked for, and what gives
        out first: `mass`, `binds`, and `by_orientation`, a row for each direction; a `Payload`.

        orientations : 6: gravity both ways along x, y and z of the hand's base, which are the world's axes (four in a
            planar scene). "any": the worst direction all around, too. It is looked for in directions spread evenly,
            then in steps of at last half a degree from the two lowest of them: a sampled minimum, no proof, since what
            compliant fingers hold is no convex set.
        acceleration : a [m/s²] of the hand, while gravity acts: its inertia loads the object as well. Of 6 the least
            mass counts with the hand speeding up along any of the same six directions: against gravity (which makes
            it g + a), with it, or sideways. With "any", the worst direction is that of gravity and inertia together,
            most of which, g + a, comes with a hand that speeds up against gravity.
        geometry : as in `load_limit`. With "any" and None, the worst direction is looked for with contacts that stay
            where they are, unless following takes seconds alone; every row is followed, as with 6. faces : as in
            `problem`. motion, turn : how far the object may move [m] and turn [rad] under the mass; None: any distance.
            accuracy, max_slip : as in `load_limit`.

        The hand closes as it does in this grasp, without the object's own mass or another load. Then the mass grows
        slowly, weight and inertia together, at the object's centre of mass, or at the reference for contacts without
        an object. Contacts without a hand keep their wrench, which does not turn with gravity, and the mass comes
        beside it: leave an object's own weight out of it, with replace(wrench=...). The fingers' weight turns with
        gravity, and is accelerated, where the grasp counts it (`finger_weight`). An infinite mass means that nothing
        gives out. For repeated use design for `first_slip` of the rows: beyond it a finger slides each time. Raises
        InputError, UnknownName, Unsupported (known forces).
        """
        from handlcp.studies import find_payload  # only who asks pays for a study

        return find_payload(self, orientations, acceleration, geometry, faces, motion, turn, accuracy, max_slip)

    def margins(
        self, solution: GraspSolution | None = None, faces: int | str | Pyramid = "cone", length: float | None = None
    ) -> Margins:
        """How far from failing: what is left of friction, torque and load, and the classic measures of contacts alone:
        force closure, form closure, ε and volume of the wrench space.

        solution : of this grasp with these faces; None: solved now. length : that moments are divided by in the wrench
        space [m]; None: the root mean square of the contacts' distances from their centre. Raises InputError.
        """
        from handlcp.grasp.margins.margins import make_margins

        return make_margins(self.spec, self.scene, self._section(faces), self._take_solution(faces, solution), length)

    def _take_solution(self, faces: int | str | Pyramid, solution: GraspSolution | None) -> GraspSolution:
        """The solution that is given; None: solved now. Raises InputError for one that is of another grasp."""
        from handlcp.grasp.solution.solution import GraspSolution

        if solution is None:
            return self.solve(faces, throw=False)
        if not isinstance(solution, GraspSolution) or len(solution.forces) != self.scene.n:
            raise InputError("solution", "a solution of this grasp, or None", shorten_repr(solution))
        return solution

    def _section(self, faces: int | str | Pyramid) -> Section:
        return as_section(faces, planar=self.scene.kind.planar)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what was asked."""
        return (type(self), (self.spec,))

    def __repr__(self) -> str:
        s = self.scene
        more = ", planar" if s.kind.planar else ""
        more += f", {s.environment} of the environment" if s.environment else ""
        return f"{type(self).__name__}({s.n} contacts, {sum(t > 0 for t in s.kind.tangent_count)} with friction{more})"
