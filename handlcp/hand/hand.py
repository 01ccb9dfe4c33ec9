"""`Hand`: a hand with fingertips, stiffness, limits and motors; `HandState`: a posture from which it grasps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from math import pi, radians
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import STIFFNESS_EXPECTED
from handlcp.check import Array, check_call, check_method_calls, read_only, require_keyword
from handlcp.errors import HandLCPError, InputError, UnknownName, missing_library
from handlcp.hand.hand_parts import read_hand_friction, read_hand_parts, replace_parts
from handlcp.robot.description import COLLISION, MJCF_TAG, URDF_TAG, RobotDescription, describe_model, describe_xml
from handlcp.robot.hand_model import DEFAULT_GRAVITY, HandModel, HandPosture
from handlcp.robot.link_surface import has_coacd

if TYPE_CHECKING:
    from handlcp.geometry.object import Object
    from handlcp.hand.hand_grasp import HandGrasp
    from handlcp.robot.audit import Audit
    from handlcp.robot.hand_description import HandDescription

WeightGiven: TypeAlias = bool | Literal["torques"]


@check_method_calls
class HandState(HandPosture):
    """A hand in one posture, made by `hand.at(q)`; `grasp` makes its grasps. Immutable.

    Data as in `HandPosture`: hand, q, tip_positions, tip_rotations, jacobian, flexibility.
    """

    def grasp(
        self, target: Any, friction: Any = None, wrench: Any = None, gravity: Any = DEFAULT_GRAVITY, preload: Any = 0.0,
        *, offset: Any = None, reference: Any = None, fingers: Sequence[str] | None = None, max_gap: Any = None,
        effects: Iterable[Any] = (), finger_weight: WeightGiven = False, plane: Any = None, squeeze: Any = None,
        grip_force: Any = None, joint_offset: Any = None, environment: Any = None, links: Any = "tips",
        closing_torque: Any = None, hold_object: bool = False,
    ) -> HandGrasp:  # fmt: skip
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
        given = dict(locals())
        del given["self"]
        from handlcp.hand.hand_grasp import HandGrasp  # 0.1 s that those who only read a hand do not pay
        from handlcp.hand.request import GraspRequest

        return HandGrasp(GraspRequest(self, **given).spec())


# ----------------------------------------------------------------
# The robot hand: a URDF, MJCF file or Pinocchio model, its fingertips, and what such a file does not say.


# How far past its range a joint may stand: files' neutral postures lie 0.3 rad past it, measured ones drift, and files
# narrow ranges for safety. What is farther is a mistake, mostly one of units.
_MAX_PAST_TURN, _MAX_PAST_SLIDE = pi / 2.0, 0.1  # rad, m

_STIFFNESS_EXPECTED = f"{STIFFNESS_EXPECTED} (no URDF says it)"


@check_method_calls
class Hand(HandModel):
    """A hand with elastic joints and fingertips, made by `Hand.from_urdf`, `from_mjcf` or `from_model`; what it
    promises is said at `HandModel`.

    Data: name, joint_names, nv, fingertips, lower, upper, neutral, torque_limits, joint_friction, and the parts
    kinematics, tips, stiffness, pads, torques.
    """

    _by_tip: dict[str, Any]  # what was passed fingertip by fingertip

    @classmethod
    @require_keyword("joint_stiffness", _STIFFNESS_EXPECTED, "motors")
    def from_urdf(
        cls, source: Any, fingertips: Any = None, *, joint_stiffness: Any = ..., pad_flexibility: Any = 0.0,
        torque_limits: Any = None, base: str | None = None, tip_radius: Any = None, package_dirs: Any = None,
        motors: Any = None, joint_friction: Any = None,
    ) -> Self:  # fmt: skip
        """Read a hand from a URDF, or a xacro file (pip install xacrodoc).

        source : path of the file, or of a URDF its text (a string that starts with "<").
        fingertips : names of links or frames, and points on links: ["thumb_tip", ("index_3", (0, 0, 0.03))], or with
            names of your own: {"thumb": "thumb_tip", "index": ("index_3", (0, 0, 0.03))}. Points in the link's frame
            [m]. None: the leaf frames whose names say so, such as "index_tip" or "thumb_tip_link"; without such, the
            ends of the two to five chains of joints, if what is the fingertip there is plain: a frame without geometry,
            or the far end of the last link's geometry. `hand.describe()` shows what was taken, and why.
        joint_stiffness : [N·m/rad, N/m of slides] a number, a mapping by joint name, (nv,), or an SPD matrix (nv, nv);
            None or inf: rigid. Or a transmission: `Tendons`, `Synergies`.
        pad_flexibility : [m/N] a number, of every link that touches; (3,) along the tip frame's axes, (3, 3) PSD in
            tip axes, (n, 3, 3), of the fingertips; or a mapping by name of a fingertip or link of the first three
            (others: rigid), such as {"index_tip": 1e-4, "palm": 2e-5}.
        torque_limits : [N·m, N of slides] None: the file's efforts (zero, infinite or absent: unknown); a number,
            (nv,), or a mapping by joint name over the file's; inf: no limit.
        base : only the links below this one are the hand, and its frame is the world frame.
        tip_radius : [m] a number, or a mapping by tip name: a sphere about the tip frame. None: the collision
            geometry of the link that is the tip frame or, if it has none, of the links fixed to it; if nothing there
            collides, what is drawn of them. Used when contacts are detected, and only then.
        package_dirs : folders for package:// addresses of meshes, and for what a xacro file includes. Relative ones
            are looked up beside the file, too; those of a text in the working directory.
        motors : a mapping of joints and tendons to `Motor`s (others: none); without tendons also one for all joints. It
            gives the torque limit of its joint, what it holds for good, and its stiffness where it says one.
        joint_friction : [N·m] dry friction at the joints, beside their springs: None: none; "file": what the file
            states; a number, a mapping by joint name (others: none), or (nv,). A loading that is followed has it, and
            MuJoCo; one solve in one posture has not.

        Raises URDFError, UnknownName (listing the valid names, or candidates for fingertips), InputError.
        """
        if isinstance(source, pin.Model):
            if base is not None:
                raise InputError("base", "None for a pinocchio.Model (only a URDF file can be cut)", repr(base))
            described = describe_model("source", source)
        else:
            described = describe_xml("source", source, base, package_dirs, (URDF_TAG,))
        return cls._from_description(
            described, fingertips, joint_stiffness, pad_flexibility, torque_limits, tip_radius, motors, joint_friction
        )

    @classmethod
    def from_mjcf(
        cls, source: Any, fingertips: Any = None, *, joint_stiffness: Any = "file", pad_flexibility: Any = 0.0,
        torque_limits: Any = None, base: str | None = None, tip_radius: Any = None, package_dirs: Any = None,
        motors: Any = None, joint_friction: Any = None,
    ) -> Self:  # fmt: skip
        """Read a hand from an MJCF file, MuJoCo's format; arguments as of `from_urdf`.

        Bodies and named sites are links. The world body is the base, and a free joint at the root is left out. Of a
        scene the hand alone is read; the audit says what is left out. Meshes are those that MuJoCo compiles. Efforts
        are those of the file's actuators; joints that an equality couples follow each other.
        joint_stiffness : "file": kp of the position actuators with their gear, and the joints' own springs; of one
            that pulls joints by a fixed tendon with coefficients a, kp a aᵀ, and what nothing else resists there as
            stiff as a, which is doubted. Where all of them pull tendons along paths in space: `Tendons` with the
            file's `tendon_routes`, kp, springs and forceranges. Springs are commanded by nothing; actuators of their
            joints hold them, k (q - springref) in the torques, and others are at rest in the posture of a grasp.

        Raises Unsupported without MuJoCo (pip install mujoco-core); InputError for joints to which the file gives
        neither a position actuator nor a spring, where none is passed; and what `from_urdf` raises.
        """
        described = describe_xml("source", source, base, package_dirs, (MJCF_TAG,))
        return cls._from_description(
            described, fingertips, joint_stiffness, pad_flexibility, torque_limits, tip_radius, motors, joint_friction
        )

    @classmethod
    @require_keyword("joint_stiffness", _STIFFNESS_EXPECTED, "motors")
    def from_model(
        cls, model: Any, fingertips: Any = None, *, joint_stiffness: Any = ..., pad_flexibility: Any = 0.0,
        torque_limits: Any = None, tip_radius: Any = None, motors: Any = None, joint_friction: Any = None,
    ) -> Self:  # fmt: skip
        """A hand from a pinocchio.Model, or a pinocchio.RobotWrapper with its collision and visual geometry.

        Pinocchio does not know mimic joints unless the model has them as joints of their own kind, which are refused:
        every joint is a joint of its own here. Arguments as of `from_urdf`. Raises InputError, URDFError, UnknownName.
        """
        described = describe_model("model", model)
        return cls._from_description(
            described, fingertips, joint_stiffness, pad_flexibility, torque_limits, tip_radius, motors, joint_friction
        )

    @classmethod
    def _from_description(
        cls, described: RobotDescription, fingertips: Any, stiffness: Any, pads: Any, limits: Any, radius: Any,
        motors: Any, friction: Any,
    ) -> Self:  # fmt: skip
        hand = cls(*read_hand_parts(described, fingertips, stiffness, pads, limits, radius, motors))
        hand.__dict__["_by_tip"] = deepcopy({"pads": pads, "radius": radius})
        return hand.with_parts(joint_friction=read_hand_friction(hand, friction))

    def _rebuild(self, parts: dict[str, Any]) -> Self:
        """With other parts, and without what was found out about the earlier ones."""
        made = self.with_parts(**parts)
        for found in ("doubts", "link_surfaces") if "_geometry" in parts else ("doubts",):
            made.__dict__.pop(found, None)
        return made

    @check_call()
    def replace(
        self, *, joint_stiffness: Any = ..., pad_flexibility: Any = ..., torque_limits: Any = ...,
        tip_radius: Any = ..., fingertips: Any = ..., motors: Any = ..., joint_friction: Any = ...,
    ) -> Self:  # fmt: skip
        """The same hand with other numbers, or other fingertips; arguments as of `from_urdf`, the rest stays.

        What is passed last counts: of joints that are given a torque limit the motors go, and a joint_stiffness counts
        before what motors say. motors None : without those of joints and of tendons. Motors by joint take the place of
        those of all joints, motors by tendon of those of all tendons; where joints or tendons alone are named, others
        keep theirs. Beside new fingertips, what was passed by name of the old ones is passed again. Raises InputError,
        UnknownName.
        """
        given = dict(locals())
        del given["self"]
        said = {name: value for name, value in given.items() if value is not ...}
        return self._rebuild(replace_parts(self, self._by_tip, said))

    @check_call("changes")
    def vary(self, changes: Mapping[str, Any]) -> Self:
        """The same hand with other numbers, by name; the rest stays, and no file is written.

        "<joint>.length" : [m] from this joint to the one joint or fingertip that it carries. Shapes and tendons' routes
            on the way stretch, what is beyond moves along, masses stay.
        "<joint>.position" : (3,) [m] in its parent's frame. "<joint>.axis" : (3,) a direction in its own frame.
        "<tip>.radius" : [m]. "<tip or link>.pad" : [m/N] a number, (3,) or (3, 3). "<joint>.stiffness" : [N·m/rad].
        "<joint>.torque_limit" : [N·m]. "<joint or tendon>.motor" : a `Motor`, or None. And arguments of `replace` but
        fingertips, which come before what is said by joint, fingertip or link.
        Meshes that keep their shape are among the `doubts`. Raises UnknownName, with names that are near; InputError,
        such as for the length of a joint that carries several; Unsupported for axes of a pinocchio.Model.
        """
        from handlcp.hand.vary.vary import vary_parts  # 15 ms that no other question pays

        return self._rebuild(vary_parts(self, self._by_tip, changes))

    def in_parts(self, *links: str) -> Self:
        """The same hand with the meshes of these links in convex parts, for contacts of links; else a mesh that is not
        convex touches as its hull. It takes coacd (pip install coacd), and up to minutes for a fine mesh.

        Raises UnknownName; Unsupported without coacd.
        """
        known = self.description.links_with(COLLISION)
        if unknown := [str(name) for name in links if name not in known]:
            raise UnknownName("links", "a link with collision geometry", unknown, known)
        if not has_coacd():
            raise missing_library("convex parts of a mesh that is not convex need coacd", "coacd")
        return self.with_parts(in_parts_of=self.in_parts_of | frozenset(links))

    @property
    def joint_stiffness(self) -> Array:
        """(nv, nv) K of the joints [N·m/rad]; inf: rigid. Raises Unsupported where `Synergies` leave C singular."""
        return self.stiffness.stiffness_matrix

    @property
    def joint_compliance(self) -> Array:
        """(nv, nv) compliance C = K⁻¹ of the independent joints [rad/(N·m)], positive semidefinite."""
        return read_only(self.stiffness.contact_compliance(np.eye(self.nv)))

    @property
    def pad_flexibility(self) -> Array:
        """(n, 3, 3) flexibility of the pads [m/N], tip axes."""
        return self.pads.blocks

    def audit(self) -> Audit:
        """Every doubt about the numbers that this hand is made of, the most serious first, and what to pass instead."""
        from handlcp.robot.audit import make_audit, stiffness_doubts  # 20 ms that no other question pays

        return make_audit(self.source, (*self.doubts, *stiffness_doubts(self)))

    def describe(self) -> HandDescription:
        """Joints with ranges, limits, stiffness; fingertips, and why; what may touch, its shapes and pads; couplings;
        mass; size; where each number came from, and what the file states besides. To print, or as data.
        """
        from handlcp.geometry.link_contacts import ALL_LINKS, contact_bodies  # 0.1 s that no hand needs to be read
        from handlcp.robot.hand_description import describe_hand

        try:
            touching = contact_bodies(self, ALL_LINKS)
        except HandLCPError:  # meshes are missing, or nothing collides
            touching = ()
        return describe_hand(self, touching)

    def at(self, q: Any) -> HandState:
        """The hand in a posture: q (nv,) [rad, m] in the order of `joint_names`, or a mapping that names all of them.

        Positions outside the joint ranges are allowed, up to a quarter turn, or 0.1 m of a slide. Raises InputError,
        UnknownName.
        """
        q = self.kinematics.read_posture("q", q)
        slides = np.isin(self.joint_names, self.sliding)
        lower, upper = np.minimum(self.lower, self.upper), np.maximum(self.lower, self.upper)  # of reversed ones
        past = np.maximum(lower - q, q - upper) / np.where(slides, _MAX_PAST_SLIDE, _MAX_PAST_TURN)
        k = int(past.argmax()) if len(past) else 0  # of the joint that is farthest past its range
        if not len(past) or past[k] <= 1.0:
            return HandState(self, q)
        low, high, name, at = lower[k], upper[k], self.joint_names[k], float(q[k])
        unit, (other, meant) = ("m", ("millimetres", at / 1e3)) if slides[k] else ("rad", ("degrees", radians(at)))
        guess = f" ({other}? {meant:.4g} {unit})" if low - 1e-3 <= meant <= high + 1e-3 else ""
        expected = f"a position in its range, {low:.4g} to {high:.4g} {unit}, or near it"
        raise InputError(f"q[{name!r}]", expected, f"{at:g}{guess}")

    def close_on(
        self, obj: Object, q0: Any = None, *, fingers: Sequence[str] | None = None, squeeze: Any = 0.0,
        tolerance: float = 1e-6, wrap: Any = False,
    ) -> Array:  # fmt: skip
        """Flex each finger from q0 (None: `neutral`) until its tip touches the object: the posture (nv,) [rad, m],
        read-only.

        Only joints that move one fingertip alone take part, each within its range (q0 is moved into it first). Links
        and the palm are not checked: they may pass through the object.

        fingers : names of those that close; None: all. tolerance : [m] on the gap at the end.
        squeeze : [m] how far the tips end up inside the object: a number ≥ 0, (n,), or a mapping by fingertip (others:
            0). The posture is then the one that the joints are commanded to, and a grasp from there has the forces of
            `squeeze=` of `state.grasp` from the posture that touches, to first order: contacts and levers are those of
            the posture inside the object. There, joints that several fingers share take part, too.
        wrap : True: the whole hand closes, and not the fingertips alone. Every joint that bends a finger towards the
            object turns, all as fast; where a link touches, the joints that carry it stop, and those beyond it go on
            until their own links touch or their range ends. Or how fast each joint turns, with its sign: a mapping by
            joint name (others: 0), or (nv,). What may touch is all collision geometry; it comes without fingers and
            squeeze.
        Raises NotReached for fingers that end elsewhere: `gaps` by finger [m], and the posture reached as `q`; beside
        wrap, where no link comes to touch.
        """
        from handlcp.hand.closing import close_fingertips, wrap_hand  # 0.1 s that no hand needs to be read

        if wrap is not False:
            if fingers is not None or not (isinstance(squeeze, (int, float)) and squeeze == 0.0):
                raise InputError("wrap", "False beside fingers and squeeze", repr(wrap)[:80])
            return wrap_hand(self, obj, q0, wrap)
        return close_fingertips(self, obj, q0, fingers, squeeze, tolerance)
