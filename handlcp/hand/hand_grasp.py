"""A hand's grasp: a grasp whose mechanism is a hand in a posture."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, Unsupported, WrongCall
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset, Reach
from handlcp.grasp.effects.object_balance import ObjectBalance
from handlcp.grasp.effects.unilateral_contact import UnilateralContact
from handlcp.grasp.friction import Pyramid, as_section
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.solve_spec import force_dependent
from handlcp.hand.asked.asked import HandAsked
from handlcp.hand.asked.load import weight_left_out, weight_of
from handlcp.hand.design.questions import HandQuestions
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.posture import Posture
from handlcp.hand.solution import HandGraspSolution
from handlcp.keywords import helped, helped_init, helped_methods
from handlcp.lcp import Auto, ContactSolver, Solver
from handlcp.tolerances import SEMIDEFINITE

if TYPE_CHECKING:
    from handlcp.grasp.analysis.equilibria import Equilibria
    from handlcp.grasp.analysis.explanation import Explanation


@helped_init()
@helped_methods
class HandGrasp(HandQuestions):
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
    def state(self) -> Posture:
        """The posture."""
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
        return self.mechanism.turning(self.scene.soft)

    @property
    def finger_weight(self) -> bool | str:
        """What was asked for, as in `HandState.grasp`."""
        weight = self._of_kind(FingerWeight)
        return False if weight is None else True if weight.sags else "torques"

    @property
    def gravity_torque(self) -> Array:
        """(nv,) g(q) that adds to the torques [N·m]; zero unless the fingers' weight was asked for."""
        return read_only(self.scene.held_torque)

    @property
    def sag(self) -> Array:
        """(nv,) K⁻¹ g(q) [rad], how far the joints give way to the fingers' weight; zero unless it is in the elastic
        balance. The scene's offset has what that does to the tips, `tip_sag`, added.
        """
        weight = self._of_kind(FingerWeight)
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
        """(3,) [m/s²] as given."""
        return self.mechanism.gravity

    @property
    def joint_offset(self) -> Array:
        """(nv,) δq [rad, m], how far beyond the posture the joints are commanded."""
        command = self._of_kind(JointOffset)
        return read_only(np.zeros(self.state.hand.nv)) if command is None else command.command

    @property
    def out_of_reach(self) -> tuple[Reach, ...]:
        """What was asked of the fingers and no command of their joints makes, one `Reach` for each kind: an overlap in
        the posture, a preload or an offset along it, a squeeze or a grip force. () where all is within reach. Links
        that the object begins inside are warned of by verdicts (`link_inside`), and not listed here.
        """
        from handlcp.hand.squeeze import out_of_reach

        return out_of_reach(self.spec)

    @property
    def tip_offset(self) -> Array:
        """(n, 3) the offset without what effects add to it: gaps, preloads and `offset` [m]."""
        return self.spec.offset

    @helped(joint_stiffness="it is the hand's: hand.replace(joint_stiffness=...)", faces="grasp.solve(faces=...)",
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
        from handlcp.hand.asked.change import hand_remade

        given = dict(
            wrench=wrench, flexibility=flexibility, offset=offset, preload=preload, friction=friction, effects=effects,
            environment=environment, gravity=gravity, mass=mass, object=object, squeeze=squeeze, grip_force=grip_force,
            joint_offset=joint_offset, finger_weight=finger_weight, fingers=fingers, max_gap=max_gap, load=load,
            links=links, closing_torque=closing_torque, hold_object=hold_object,
        )  # fmt: skip
        made = type(self)(hand_remade(self.spec, given))
        if isinstance(asked := made.spec.asked, HandAsked) and asked.flexibility is not None:
            bent = force_dependent(made.spec)
            if bent or (made.scene.soft and made.spec.flexibility[: 3 * made.spec.of_hand].any()):
                _of_the_joints(made.spec, "GeometricStiffness" if bent else "soft fingers")
        return made

    @helped("start")  # which may be of a stream
    def solve(
        self, faces: int | str | Pyramid = "cone", solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True, accuracy: float | None = None, start: GraspSolution | None = None, proof: bool = True,
    ) -> HandGraspSolution:  # fmt: skip
        """As `Grasp.solve`, with torques. Raises InputError for an accuracy beside `GeometricStiffness`, too."""
        if accuracy is not None and force_dependent(self.spec):
            raise InputError("accuracy", "None beside GeometricStiffness: no estimate counts it", accuracy)
        return cast(HandGraspSolution, super().solve(faces, solver, throw, accuracy, start, proof))

    def explain(self, faces: int | str | Pyramid = "cone", measure: bool = False) -> Explanation:
        """As `Grasp.explain`; what is out of the joints' reach of preloads and overlaps stands beside them, and beside
        the object's balance its weight, where the load leaves that out.
        """
        found, own = super().explain(faces, measure), weight_of(self.target, self.given_gravity, self.reference)
        begins = [reason.sentence for reason in self.mechanism.begins_reasons(self.spec)]
        carried = [*begins, *(str(reach) for reach in self.out_of_reach if reach.carried)]
        more = {
            UnilateralContact.title: "".join([f"; {text}" for text in carried]),
            ObjectBalance.title: f"; {text}" if (text := weight_left_out(self.spec, own)) else "",
        }
        lines = [replace(line, why=line.why + more.get(line.title, "")) for line in found.effects]
        return replace(found, effects=tuple(lines))

    def equilibria(self, faces: int | str | Pyramid = "cone", seconds: float = 2.0) -> Equilibria:
        """As `Grasp.equilibria`. Raises Unsupported beside `GeometricStiffness`."""
        if force_dependent(self.spec):
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

    def _of_kind(self, kind: Any) -> Any:
        """The effect of this kind among those asked for; None: there is none."""
        return next((e for e in self.spec.effects if isinstance(e, kind)), None)


def grasp_of(spec: GraspSpec) -> Grasp:
    """The grasp of a specification, a hand's where it has one."""
    return Grasp(spec) if spec.mechanism is None else HandGrasp(spec)


def _of_the_joints(spec: GraspSpec, beside: str) -> None:
    """Raises InputError unless E has the joints' share, which turns soft fingertips and bends under forces."""
    assert spec.mechanism is not None  # a hand's
    pads = np.linalg.eigvalsh(spec.flexibility - spec.mechanism.compliance(spec.mechanism.jacobian))
    if pads[0] < -SEMIDEFINITE * float(abs(spec.flexibility).max(initial=0.0)):
        expected = f"that of the hand's joints, and what else gives way, beside {beside}"
        raise InputError("flexibility", expected, f"less than its joints have by up to {-pads[0]:.3g} m/N")
