"""A posture of a hand from which it grasps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from handlcp.hand.robot.posture import GRAVITY, Posture
from handlcp.keywords import helped_methods

if TYPE_CHECKING:
    from handlcp.hand.hand_grasp import HandGrasp

WeightGiven: TypeAlias = bool | Literal["torques"]


@helped_methods
class HandState(Posture):
    """A hand in one posture, made by `hand.at(q)`; `grasp` makes its grasps. Immutable.

    Data as in `Posture`: hand, q, tip_positions, tip_rotations, jacobian, flexibility.
    """

    def grasp(
        self,
        target: Any,
        friction: Any = None,
        wrench: Any = None,
        gravity: Any = GRAVITY,
        preload: Any = 0.0,
        *,
        offset: Any = None,
        reference: Any = None,
        fingers: Sequence[str] | None = None,
        max_gap: Any = None,
        effects: Iterable[Any] = (),
        finger_weight: WeightGiven = False,
        plane: Any = None,
        squeeze: Any = None,
        grip_force: Any = None,
        joint_offset: Any = None,
        environment: Any = None,
        links: Any = "tips",
        closing_torque: Any = None,
        hold_object: bool = False,
    ) -> HandGrasp:
        """The grasp of an object from this posture.

        target : an object (Box, Sphere, Cylinder, Ellipsoid, Mesh): contacts, normals and gaps are detected. A
            fingertip that overlaps the object counts as squeezed by as much from a posture that touches. Or contacts, a
            sequence with one for each finger, or a mapping by fingertip name: each moves rigidly with its fingertip,
            and is taken as touching.
        friction : of all contacts with an object: a coefficient, a law, or a mapping by fingertip of these (others:
            0.6); None: 0.6. Contacts bring their own.
        wrench : (6,) force [N] and torque [N·m] about `reference` on the object, besides its weight; None: none.
            (In `grasp.replace` that is `load`; `wrench` is the whole load there, weight included.)
        gravity : (3,) [m/s²], world axes; weighs the object at its centre of mass, and the fingers when asked to.
        preload : [m] a number or (n,), squeeze of the normals whether or not the joints can make it: `out_of_reach` of
            the grasp says what they cannot. offset : (n, 3) [m], contact axes, as in `Grasp`. Both come beside a
            command.
        reference : (3,) [m], of wrench and object motion; None: the object's centre of mass, the origin for contacts.
        fingers : the fingertips that take part, in this order; None: all (those a mapping of contacts names).
        max_gap : [m] the farthest a fingertip or a link may be from the object and still count as touching; None: 1 mm,
            but 10 mm for links with closing_torque or joint_offset: they may come to touch on the way.
        effects, plane : as in `Grasp`; `TorqueSaturation()` lets joints at their limit yield, `GeometricStiffness()`
            lets the forces turn their own levers.
        finger_weight : True: the fingers' own weight is in the torques and in the elastic balance. The posture is then
            the one commanded: the joints sag from it by K⁻¹ g(q), and the tips with them, before the object is loaded.
            "torques": in the torques alone, for a posture that is measured: it has sagged already, and no offset
            applies.
        squeeze, grip_force, joint_offset, closing_torque : how hard the hand closes, at most one of them. Each commands
            the joints beyond the posture, by δq, which adds -J δq to the offsets; `out_of_reach` of the grasp says what
            joints cannot make.
            squeeze : [m] how much deeper than touching the tips are commanded along the normals, by the smallest δq, a
            gap or an overlap included: as `close_on` with that squeeze, the posture staying. A number ≥ 0, (n,), or a
            mapping by fingertip name (others: 0).
            grip_force : [N] normal force with which each tip would press on an object that stays where it is, and where
            it does not slip; otherwise likewise.
            joint_offset : (nv,) or a mapping by joint name (others: 0) [rad, m], δq itself.
            closing_torque : [N·m] with which the joints that bend fingers pull, less the dry friction of motors of
            joints and of tendons, and then hold where they stand. The closing is followed: the motors of each finger
            turn on together, in proportion to K⁻¹ τ, until the first of them pulls with its torque; its others pull
            with what that leaves them. What holds springs of the file in this posture comes beside it. No finger goes
            on where that drives another one more than a tenth beyond its torque. A number or (nv,); or a mapping by
            joint name (others: 0), also of joints that bend no finger.
            Beside links, this posture and the one of a joint_offset may be open: the hand closes until links touch,
            from the palm outwards (as `hand.close_on(obj, wrap=True)`); the grasp is that of the posture where they do,
            and a loading that is followed begins in this one.
        hold_object : whether the object is kept in place, by something else, until the hand has closed; it matters to a
            loading that is followed.
        environment : a `Table`, an `Environment`, or several: what the object touches besides the fingers. Those
            contacts come last; friction, preload and offset above are the fingers', n of them.
        links : which parts of the hand may touch an object: "tips", the fingertips, all of which have to; "all", every
            link with collision geometry, palm and base included; or names of links and fingertips. Of links, those
            within max_gap touch, at a point, at both ends of a line, or at up to four corners of a patch. What is said
            by fingertip above is then said by link (of all its contacts) or by contact, such as "palm 2".

        Raises NotReached (naming each finger and its gap, or a table), UnknownName, InputError.
        """
        from handlcp.hand.asked.asked import HandAsked
        from handlcp.hand.hand_grasp import HandGrasp

        asked = HandAsked(
            self, target, friction, wrench, gravity, preload, offset, reference, fingers, max_gap, effects,
            finger_weight, plane, squeeze, grip_force, joint_offset, environment, links, closing_torque, hold_object,
        )  # fmt: skip
        return HandGrasp(asked.spec())
