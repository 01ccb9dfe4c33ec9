"""What can be asked of a grasp beyond one solve: one method a question, each a call to the room that answers it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from handlcp.check import number
from handlcp.errors import InputError, NoSolutionFound, shown
from handlcp.grasp.friction import Pyramid, Section, as_section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.keywords import helped, helped_methods
from handlcp.views import view

if TYPE_CHECKING:
    from handlcp.grasp.analysis.equilibria import Equilibria
    from handlcp.grasp.analysis.required import Required
    from handlcp.grasp.analysis.suggestions import Suggestions
    from handlcp.grasp.answer.solution import GraspSolution
    from handlcp.grasp.answer.verdict import Verdict
    from handlcp.grasp.design.best_change import BestChange
    from handlcp.grasp.design.stiffness import RequiredStiffness
    from handlcp.grasp.limits.result import LoadLimit
    from handlcp.grasp.margins.margins import Margins
    from handlcp.grasp.path.follow import Loading


@helped_methods
class Questions(ABC):
    """Base of `Grasp`: what is asked of it, as `spec` (data) and `scene` (arrays) have it."""

    spec: GraspSpec
    scene: Scene

    @abstractmethod
    def solve(self, faces: int | str | Pyramid = "cone", *args: Any, **options: Any) -> GraspSolution:
        """See `Grasp.solve`."""

    def suggest(
        self, solution: GraspSolution | None = None, faces: int | str | Pyramid = "cone", least: float = 0.05
    ) -> Suggestions:
        """Which effects that are left out would change the answer by more than `least` of its largest force, each
        evaluated once; of a grasp that fails, also changes that were tried and hold it, the least of each kind.

        solution : of this grasp, solved with `faces`; None: solved now. Raises InputError.
        """
        from handlcp.grasp.verdict.check import suggested

        solution = self._answer(faces, solution)
        number("least", least, minimum=0.0)
        verdict = solution.verdict if solution.verdict.ok else self.check(faces=faces, solution=solution)
        return suggested(self.spec, self._section(faces), solution, least, verdict)

    def required_preload(self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3) -> Required:
        """The smallest squeeze [m], added to every finger as a preload, with which the grasp holds, to a relative
        tolerance: as `solve` says, or `check` where hand and object are known. Its `verdict` is the word of `check`.
        """
        from handlcp.grasp.design.least import confirmed_preload

        return confirmed_preload(self.spec, self._section(faces), tolerance)

    def required_friction(self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3) -> Required:
        """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds: as
        `solve` says, or `check` where hand and object are known, which has to hold the object where it was gripped:
        with less it may snap to another place and rest there. Its `verdict` is the word of `check`, and its `hint` says
        where more friction does not hold better.
        """
        from handlcp.grasp.design.least import confirmed_friction

        return confirmed_friction(self.spec, self._section(faces), tolerance)

    def required_stiffness(
        self, motion: float, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3
    ) -> RequiredStiffness:
        """The least factor on the stiffness of all joints (of the fingers, where no joints are known) with which the
        object moves by no more than `motion` [m], its reference point from the end of the squeeze to the whole load.

        Pads stay as they are. A grip force stays the force that it is; a squeeze stays as deep, and a joint offset as
        large, so that stiffer joints press harder. tolerance : relative. Raises InputError.
        """
        from handlcp.grasp.design.stiffness import required_stiffness

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

        return equilibria(self.spec, self._section(faces), number("seconds", seconds, above=0.0))

    @helped(most_force="what an object bears is asked by required_grip(most_force=...)")
    def check(
        self, order: Any = ("squeeze", "load"), faces: int | str | Pyramid = "cone",
        solution: GraspSolution | None = None,
    ) -> Verdict:  # fmt: skip
        """Does it hold? The verdict when it is squeezed, then loaded, as by `follow`. HELD: the end is reached, the
        object neither slides through nor snaps, joints are within their torque limits, and no link or joint is where
        the hand cannot be. Doubtful limits are named; where it does not hold, what was tried and would help.
        solution : of this grasp with these faces; None: solved now.
        """
        from handlcp.grasp.verdict.check import check

        return check(self.spec, self.scene, self._section(faces), order, self._answer(faces, solution))

    def follow(
        self, load: Any = None, order: Any = ("squeeze", "load"), geometry: str | None = None,
        throw: bool = False, faces: int | str | Pyramid = "cone", steps: int = 40, tolerance: float | None = None,
        accuracy: float | None = None,
    ) -> Loading:  # fmt: skip
        """The grasp loaded in quasi-static steps: is it held to the end (`held`), what slips on the way, where is it
        lost and why.

        load : (6,) beside the object's weight at the end, about the reference; None: the grasp's own; (m, 6): one after
        the other. Of contacts without a hand it is all that loads them: their wrench is not added. order : stages
        "squeeze" (preload and joint offset), "load" (weight and load), "together", or `Stage`s. geometry : "followed",
        contacts detected anew in every step; "fixed", those of this posture; None: the first where hand and object are
        known. steps : of a stage, more where something happens. tolerance : how far a step's end may be from where its
        contacts were taken, as a share of their radii; None: 1e-9. accuracy : relative error of the forces at the end
        that is enough: steps are doubled until they change by no more; the loading's `accuracy` is that change. faces :
        as in `problem`. Raises InputError, Unsupported (known forces; an accuracy that is not reached); with `throw`,
        NoSolutionFound unless it is held.
        """
        from handlcp.grasp.path.follow import follow

        found = follow(self.spec, self._section(faces), load, order, geometry, steps, tolerance, accuracy)
        if throw and not found.held:
            raise NoSolutionFound(found.sentence, found, found.solution)
        return found

    def load_limit(
        self, wrench: Any = None, *, geometry: str | None = None, faces: int | str | Pyramid = "cone",
        motion: float | None = None, turn: float | None = None, accuracy: float | None = None,
    ) -> LoadLimit:  # fmt: skip
        """The largest factor on a load that the grasp holds when it is squeezed, then carries its weight, and the load
        grows slowly; and what gives out there: the object slides through or is lost, a joint is at its torque limit or
        at the end of its range. `first_slip`, `slides` and `lost` are the loads of these. With `TorqueSaturation` a
        joint at its limit yields, and the load grows on until something else gives out.

        wrench : (6,) force [N] and torque [N·m] beside the weight, about the reference, or (3,) of a planar grasp, as
        in `Grasp`; None: the grasp's own. Nobody knows what of the wrench of contacts without a hand is weight: all of
        it stays on while another load grows, and a load of None is that wrench itself, from nothing. geometry : as in
        `follow`. faces : as in `problem`. motion, turn : how far
        the object may move [m] and turn [rad] from where the load finds it; None: any distance. accuracy : relative
        error of the factor that is enough, where the geometry is followed: steps are doubled until it changes by no
        more. Raises InputError, Unsupported (known forces; an accuracy that is not reached).
        """
        from handlcp.grasp.limits.load_limit import load_limit

        return load_limit(self.spec, self._section(faces), wrench, geometry, motion, turn, accuracy)

    def payload(
        self, orientations: Any = 6, acceleration: float = 0.0, *, geometry: str | None = None,
        faces: int | str | Pyramid = "cone", motion: float | None = None, turn: float | None = None,
        accuracy: float | None = None,
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
            accuracy : relative, of the masses, as in `load_limit`.

        The hand closes as it does in this grasp, without the object's own mass or another load. Then the mass grows
        slowly, weight and inertia together, at the object's centre of mass, or at the reference for contacts without
        an object. Contacts without a hand keep their wrench, which does not turn with gravity, and the mass comes
        beside it: leave an object's own weight out of it, with replace(wrench=...). The fingers' weight turns with
        gravity, and is accelerated, where the grasp counts it (`finger_weight`). An infinite mass means that nothing
        gives out. For repeated use design for `first_slip` of the rows: beyond it a finger slides each time. Raises
        InputError, Unsupported (known forces; an accuracy that is not reached).
        """
        return view("payload")(self, orientations, acceleration, geometry, faces, motion, turn, accuracy)

    def margins(
        self, solution: GraspSolution | None = None, faces: int | str | Pyramid = "cone", length: float | None = None
    ) -> Margins:
        """How far from failing: what is left of friction, torque and load, and the classic measures of contacts alone:
        force closure, form closure, ε and volume of the wrench space.

        solution : of this grasp with these faces; None: solved now. length : that moments are divided by in the wrench
        space [m]; None: the root mean square of the contacts' distances from their centre. Raises InputError.
        """
        from handlcp.grasp.margins.margins import margins_of

        return margins_of(self.spec, self.scene, self._section(faces), self._answer(faces, solution), length)

    def _answer(self, faces: int | str | Pyramid, solution: GraspSolution | None) -> GraspSolution:
        """The solution that is given; None: solved now. Raises InputError for one that is of another grasp."""
        from handlcp.grasp.answer.solution import GraspSolution

        if solution is None:
            return self.solve(faces, throw=False)
        if not isinstance(solution, GraspSolution) or len(solution.forces) != self.scene.n:
            raise InputError("solution", "a solution of this grasp, or None", shown(solution))
        return solution

    def _section(self, faces: int | str | Pyramid) -> Section:
        return as_section(faces, planar=self.scene.kind.planar)
