"""`HandGrasp`: the grasp of a hand: one method a question, each a call to the file that answers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np

from handlcp.check import Array, check_call, check_init_call, check_method_calls, read_only
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError, Unsupported, WrongCall
from handlcp.geometry.object import Object, describe_missing_weight
from handlcp.grasp.effects.contact_mechanics import ObjectBalance, UnilateralContact
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import CommandReach, JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.request import GraspSpec, rebuild
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.solve_spec import is_force_dependent
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.request import GraspRequest
from handlcp.hand.solution import HandGraspSolution
from handlcp.lcp import Auto, ContactSolver, Solver
from handlcp.progress import track_progress
from handlcp.robot.hand_model import HandPosture
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

if TYPE_CHECKING:
    from handlcp.grasp.analysis.equilibria import Equilibria
    from handlcp.grasp.analysis.explanation import Explanation
    from handlcp.grasp.analysis.required_value import Required
    from handlcp.hand.motor_requirement import RequiredTorque


@check_init_call()
@check_method_calls
class HandGrasp(Grasp):
    """A `Grasp` that knows its hand. Made by `state.grasp(...)`; the attributes are read off its specification."""

    def __init__(self, spec: Any = None, *others: Any) -> None:
        if others or not (isinstance(spec, GraspSpec) and isinstance(spec.mechanism, HandMechanism)):
            raise WrongCall("spec", "make a HandGrasp with hand.at(q).grasp(...)")
        super().__init__(spec)

    @property
    def mechanism(self) -> HandMechanism:
        """The hand in its posture, at the contacts."""
        return cast(HandMechanism, self.spec.mechanism)

    @property
    def state(self) -> HandPosture:
        """The hand in the posture that it grasps from."""
        return self.mechanism.posture

    @property
    def fingertips(self) -> tuple[str, ...]:
        """Names, one for each finger; contacts of the environment come after them."""
        return self.mechanism.fingertips

    @property
    def target(self) -> Object | None:
        """The object; None for contacts given one by one."""
        return self.mechanism.target

    @property
    def jacobian(self) -> Array:
        """(3n, nv) velocity of the contact points in contact axes (x, y, z per contact) under the joints, zero for the
        environment's.
        """
        return self.mechanism.jacobian

    @property
    def turning(self) -> Array:
        """(k, nv) of the k soft contacts' fingertips about their normals [rad/rad]; zero for the environment's."""
        return self.mechanism.jacobian_rows(self.scene.soft)[len(self.jacobian) :]

    @property
    def finger_weight(self) -> bool | str:
        """What was asked for, as in `HandState.grasp`."""
        weight = self._find_effect(FingerWeight)
        return False if weight is None else True if weight.sags else "torques"

    @property
    def gravity_torque(self) -> Array:
        """(nv,) g(q) that adds to the torques [N·m]; zero unless the fingers' weight was asked for."""
        return read_only(self.scene.bias_torque_or_zero)

    @property
    def sag(self) -> Array:
        """(nv,) K⁻¹ g(q) [rad], how far the joints give way to the fingers' weight; zero unless it is in the elastic
        balance. The scene's offset has what that does to the tips, `tip_sag`, added.
        """
        weight = self._find_effect(FingerWeight)
        sags = weight is not None and weight.sags
        return read_only(self.mechanism.deflection(weight.torque if sags else np.zeros(self.state.hand.nv)))

    @property
    def tip_sag(self) -> Array:
        """(n, 3) J K⁻¹ g(q) [m], contact axes: object minus fingertip, for tips that sag under the fingers' weight."""
        moved = (self.jacobian @ self.sag).reshape(-1, 3)
        if self.scene.kind.planar:
            moved[:, 1] = 0.0  # what lies across the plane is left out
        return read_only(moved)

    @property
    def gravity(self) -> Array:
        """(3,) [m/s²] that weighs the fingers; zero unless that was asked for."""
        return self.given_gravity if self.finger_weight else read_only(np.zeros(3))

    @property
    def given_gravity(self) -> Array:
        """(3,) gravity [m/s²] that was passed, whether or not it weighs the fingers, too."""
        return self.mechanism.gravity

    @property
    def joint_offset(self) -> Array:
        """(nv,) δq [rad, m], how far beyond the posture the joints are commanded."""
        command = self._find_effect(JointOffset)
        return read_only(np.zeros(self.state.hand.nv)) if command is None else command.command

    @property
    def out_of_reach(self) -> tuple[CommandReach, ...]:
        """What was asked of the fingers and no command of their joints makes, one `CommandReach` for each kind: an
        overlap in the posture, a preload or an offset along it, a squeeze or a grip force. () where all is within
        reach. Links that the object begins inside are warned of by verdicts (`link_inside`), and not listed here.
        """
        from handlcp.hand.squeeze import find_unreachable

        return find_unreachable(self.spec)

    @property
    def tip_offset(self) -> Array:
        """(n, 3) the offset without what effects add to it: gaps, preloads and `offset` [m]."""
        return self.spec.offset

    @check_call(joint_stiffness="it is the hand's: hand.replace(joint_stiffness=...)", faces="grasp.solve(faces=...)",
            solver="grasp.solve(solver=...)", order="grasp.check(order=...)",
            torque_limits="they are the hand's: hand.replace(torque_limits=...)",
            pad_flexibility="it is the hand's: hand.replace(pad_flexibility=...)",
            motors="they are the hand's: hand.replace(motors=...)")  # fmt: skip
    def replace(
        self, *, wrench: Any = None, flexibility: Any = None, offset: Any = None, preload: Any = None,
        friction: Any = None, effects: Any = None, environment: Any = None, gravity: Any = None, mass: Any = None,
        object: Any = None, squeeze: Any = None, grip_force: Any = None, joint_offset: Any = None,
        finger_weight: Any = None, fingers: Any = None, max_gap: Any = None, load: Any = None,
        links: Any = None, closing_torque: Any = None, hold_object: Any = None,
    ) -> Self:  # fmt: skip
        """The grasp made again with other arguments, each as in `state.grasp`, in the same posture; None: as it was.

        object, links : is looked for anew, and so are tables under it. mass, gravity, object : change the weight; what
        was given beside it stays. load : (6,) force [N] and torque [N·m] besides the weight, as `wrench` of
        `state.grasp`.
        wrench : the whole load, in place of the weight and of what was given beside it: the object then weighs nothing
        unless its weight is part of this wrench, and the verdict says so. To keep the weight, pass `load` instead.
        friction : a coefficient, a law, or a mapping by fingertip, where the others keep theirs (in a squeeze or a grip
        force by fingertip the others have 0). flexibility : in place
        of the hand's own; 0, or at least what the joints have where they also turn soft fingertips or bend under
        forces. squeeze, grip_force, joint_offset : at most one, in place of the earlier command. effects, environment :
        () takes them away, {} a joint_offset, 0 a preload or a mass, False finger_weight.
        Raises NotReached, UnknownName, InputError.
        """
        given = dict(locals())
        del given["self"]
        made = type(self)(rebuild(self.spec, given, GraspRequest))
        if isinstance(asked := made.spec.asked, GraspRequest) and asked.flexibility is not None:
            E, bent = made.spec.flexibility, is_force_dependent(made.spec)
            if bent or (made.scene.soft and E[: 3 * made.spec.of_hand].any()):
                # Joints turn soft fingertips and bend under forces: E has to have their share
                pads = np.linalg.eigvalsh(E - made.mechanism.contact_compliance(made.jacobian))
                if pads[0] < -SEMIDEFINITE_TOLERANCE * float(abs(E).max(initial=0.0)):
                    beside = "GeometricStiffness" if bent else "soft fingers"
                    expected = f"that of the hand's joints, and what else gives way, beside {beside}"
                    raise InputError("flexibility", expected, f"less than its joints have by up to {-pads[0]:.3g} m/N")
        return made

    @check_call("start")  # which may be of a stream
    def solve(
        self, faces: int | str | Pyramid = "cone", solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True, accuracy: float | None = None, start: GraspSolution | None = None, proof: bool = True,
    ) -> HandGraspSolution:  # fmt: skip
        """As `Grasp.solve`, with torques. Raises InputError for an accuracy beside `GeometricStiffness`, too."""
        if accuracy is not None and is_force_dependent(self.spec):
            raise InputError("accuracy", "None beside GeometricStiffness: no estimate counts it", accuracy)
        return cast(HandGraspSolution, super().solve(faces, solver, throw, accuracy, start, proof))

    def explain(self, faces: int | str | Pyramid = "cone", measure: bool = False) -> Explanation:
        """As `Grasp.explain`; what is out of the joints' reach of preloads and overlaps stands beside them, and beside
        the object's balance its weight, where the load leaves that out.
        """
        found, own = super().explain(faces, measure), self.mechanism.weight_of_object(self.reference)
        begins = [reason.sentence for reason in self.mechanism.report.start_inside_reasons(self.spec)]
        carried = [*begins, *(str(reach) for reach in self.out_of_reach if reach.carried)]
        more = {
            UnilateralContact.title: "".join([f"; {text}" for text in carried]),
            ObjectBalance.title: f"; {text}" if (text := describe_missing_weight(self.spec, own)) else "",
        }
        lines = [replace(line, why=line.why + more.get(line.title, "")) for line in found.effects]
        return replace(found, effects=tuple(lines))

    def required_torque(
        self, loads: Any = None, safety: float = 1.5, faces: int | str | Pyramid = "cone", tolerance: float = 0.01,
        *, most_force: Any = None, progress: bool | Callable[[int], object] | None = None,
    ) -> RequiredTorque:  # fmt: skip
        """The torque of each joint, and the grip of each finger, with which every load of a brief holds.

        loads : what the hand has to hold, one load at a time: (6,) force [N] and torque [N·m] beside the object's
            weight, about the reference; (m, 6) several; or a mapping of names to loads, each a (6,) or a mapping of
            "load" (6,), "mass" [kg] and "gravity" (3,) [m/s²], where what is left out is as the grasp has it. None: the
            grasp's own load.
        safety : every load is multiplied by it, and so is the object's weight; the fingers' own weight is not.
        tolerance : of the grip: to that share the least is found. faces : as in `solve`.
        most_force : the largest normal force [N] that the object bears, on the way to each load times safety, such as
            3 N for an egg: a number for every contact, one for each, or a mapping by name; None: any.
        progress : None: a line on the terminal once it takes long; False: none; True: a line on stderr that stays; a
            function: called with the number of grips tried so far.

        The hand closes by a grip force at each fingertip, in place of the grasp's own command, then the load comes, as
        in `check`. Many grips hold every load. The one is looked for that keeps the torque of the joint that is loaded
        most as small as possible, from the first touch to the whole load: as a share of the joints' limits where all of
        them have one, in N·m otherwise. The search starts from the grip that is best where nothing slips (a linear
        program); every grip that it tries is followed. Before it is given, `check()` judges every load with the answer
        as torque limits (`verdicts`); the answer is confirmed where all of them are HELD.
        Raises InputError, UnknownName, Unsupported (known forces).
        """
        from handlcp.hand.required_torque import find_required_torque

        def by_count(tried: int, _: int) -> None:
            if tried and callable(progress):
                progress(tried)

        with track_progress("grips tried", None, by_count if callable(progress) else progress) as say:
            section = self._section(faces)
            return find_required_torque(self.spec, section, loads, safety, tolerance, lambda _: say(1), most_force)

    def required_grip(
        self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3, *, most_force: Any = None
    ) -> Required:  # fmt: skip
        """The smallest grip force [N], common to all fingertips and in place of the grasp's own command, with which
        the grasp holds when it closes and is loaded then, to a relative tolerance, and no contact presses harder on the
        way than `most_force`, as of `required_torque`, which finds a grip for each finger. Raises InputError,
        UnknownName, Unsupported.
        """
        from handlcp.hand.required_torque import find_required_grip

        return find_required_grip(self.spec, self._section(faces), tolerance, most_force)

    def required_squeeze(
        self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3, *, most_force: Any = None
    ) -> Required:  # fmt: skip
        """The smallest squeeze [m], common to all fingertips and in place of the grasp's own command, with which the
        grasp holds, as `required_grip`. Raises InputError, UnknownName, Unsupported.
        """
        from handlcp.hand.required_torque import find_required_squeeze

        return find_required_squeeze(self.spec, self._section(faces), tolerance, most_force)

    def equilibria(self, faces: int | str | Pyramid = "cone", seconds: float = 2.0) -> Equilibria:
        """Search all equilibria of the grasp, as `Grasp.equilibria`. Raises Unsupported beside `GeometricStiffness`."""
        if is_force_dependent(self.spec):
            raise Unsupported("no search covers equilibria of fingers that their own forces bend (GeometricStiffness)")
        return super().equilibria(faces, seconds)

    def geometric_change(self, solution: GraspSolution, faces: int | str | Pyramid = "cone") -> Array:
        """(n,) by how much `GeometricStiffness` would change each finger's force, as a share of the largest force: from
        one correction, E under the solution's own forces. Infinite where a finger buckles under them or the corrected
        grasp has no answer; 0 to rounding where the grasp has the effect already.

        solution : of this grasp, an answer. faces : those that it was solved with. It costs one solve and the second
        derivatives. Raises InputError.
        """
        from handlcp.grasp.analysis.suggestions import force_change

        if not getattr(solution, "held", False):
            got = "one without forces" if solution else repr(solution)
            raise InputError("solution", "an answer of this grasp", got)
        GeometricStiffness().check("grasp", self.spec, self.spec.effects)
        section = as_section(faces, planar=self.scene.kind.planar)
        return read_only(force_change(self.spec, section, solution, GeometricStiffness()))

    def _find_effect(self, kind: Any) -> Any:
        """The effect of this kind among those asked for; None: there is none."""
        return next((e for e in self.spec.effects if isinstance(e, kind)), None)


def make_grasp(spec: GraspSpec) -> Grasp:
    """The grasp of a specification, a hand's where it has one."""
    return Grasp(spec) if spec.mechanism is None else HandGrasp(spec)
