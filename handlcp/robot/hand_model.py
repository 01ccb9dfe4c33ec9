"""`HandModel`: what is known of a hand before it takes a posture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import Elasticity, FingertipPads, tip_flexibility
from handlcp.check import (
    Array,
    check_array,
    check_integer,
    check_method_calls,
    check_number,
    check_sequence,
    freeze_arrays,
    read_only,
)
from handlcp.errors import InputError, UnknownName
from handlcp.lazy_property import lazy_property
from handlcp.robot.description import RobotDescription
from handlcp.robot.fingertip import TipFrames, TipGeometry, TipShape
from handlcp.robot.joint import Doubt, TorqueLimits
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_surface import LinkSurface, link_surfaces
from handlcp.robot.servo_stiffness import ServoStiffness
from handlcp.tolerances import MAX_NUMBER


@check_method_calls
class HandModel:
    """The parts of a hand with elastic joints and fingertips. Immutable, safe to share between threads, picklable.

    A mimic joint is not a joint of its own here: positions, Jacobians, stiffness, limits and torques are those of the
    nv independent joints, and `kinematics` moves the mimic joints with the joints that they follow.

    name : the robot's own. source : name of the file; that of the robot for an XML string or a pinocchio.Model.
    joint_names : nv of them, in the order of every vector over joints (Pinocchio's, not the file's).
    fingertips : n names of frames.
    lower, upper : (nv,) ends of the joint ranges [rad, m], narrowed by the limits of mimic joints; ±inf: none.
    neutral : (nv,) the posture nearest to zero inside the joint ranges [rad, m].
    torques : motors and limits, with which limits are known (`TorqueLimits`).
    torque_limits : (nv,) [N·m] (N for prismatic joints); inf where there is none or none is known.
    joint_friction : (nv,) dry friction at the joints, beside their springs [N·m] (N for prismatic joints).
    in_parts_of : links whose meshes touch in convex parts, not as their hulls.
    links_of_sites : (n,) of a hand whose fingertips are contacts on its links, the link of each; else None. own_tips :
    names of the fingertips that such a hand has otherwise; else (). may_touch : the links that may be among those
    contacts; None: all.
    """

    kinematics: Kinematics
    tips: TipFrames
    stiffness: Elasticity
    pads: FingertipPads
    torques: TorqueLimits
    name: str
    source: str
    joint_names: tuple[str, ...]
    nv: int
    fingertips: tuple[str, ...]
    lower: Array
    upper: Array
    neutral: Array
    torque_limits: Array
    joint_friction: Array
    in_parts_of: frozenset[str]
    links_of_sites: tuple[str, ...] | None
    may_touch: frozenset[str] | None
    own_tips: tuple[str, ...]
    _geometry: TipGeometry

    def __init__(
        self,
        kinematics: Kinematics,
        tips: TipFrames,
        stiffness: Elasticity,
        pads: FingertipPads,
        torques: TorqueLimits,
        geometry: TipGeometry,
    ) -> None:
        derived = {name: getattr(kinematics, name) for name in ("joint_names", "nv", "lower", "upper", "neutral")}
        self.__dict__.update(derived, name=str(kinematics.model.name), fingertips=tips.names)
        self.__dict__.update(kinematics=kinematics, tips=tips, stiffness=stiffness, pads=pads, torques=torques)
        self.__dict__.update(_geometry=geometry, source=geometry.description.source, torque_limits=torques.limits)
        self.__dict__.update(links_of_sites=None, may_touch=None, in_parts_of=frozenset(), own_tips=())
        self.__dict__.update(joint_friction=read_only(np.zeros(kinematics.nv)))

    @property
    def model(self) -> Any:
        """A copy of the hand's pinocchio.Model."""
        return pin.Model(self.kinematics.model)

    @property
    def moving_joints(self) -> Any:
        """Which independent joint moves which fingertip, (n, nv) bool."""
        return self.kinematics.find_moving_joints(self.tips.support[:, 0, :])

    @lazy_property
    def mass(self) -> float:
        """[kg] of all its links; 0 where the file says none."""
        return sum(float(inertia.mass) for inertia in self.kinematics.model.inertias)

    @lazy_property
    def sliding(self) -> tuple[str, ...]:
        """Names of prismatic joints, whose torques are forces [N]."""
        return tuple([fact.name for fact in self.kinematics.facts if fact.kind == "prismatic"])

    @property
    def dry_friction(self) -> Array:
        """(nv,) at the joints, their own and that of their drives [N·m] (N for prismatic joints)."""
        drives = self.torques.drives
        return self.joint_friction if drives is None else read_only(self.joint_friction + drives.friction)

    @property
    def urdf_tree(self) -> tuple[Any, tuple[Path, ...]]:
        """The URDF as read, or written for an MJCF file, an xml.etree Element not to be changed (None for a
        pinocchio.Model), and mesh folders.
        """
        return self.description.root, self.description.folders

    @property
    def description(self) -> RobotDescription:
        """The robot as it was read."""
        return self._geometry.description

    def tip_numbers(self, argument: str, fingers: Any) -> tuple[int, ...]:
        """Positions of the named fingertips in `fingertips`; None: all. Raises UnknownName, InputError."""
        if fingers is None:
            return self.tips.numbers
        if isinstance(fingers, str) or not isinstance(fingers, Sequence):
            raise InputError(argument, "a sequence of fingertip names", repr(fingers))
        if unknown := [str(name) for name in fingers if name not in self.fingertips]:
            raise UnknownName(argument, "a fingertip", unknown, self.fingertips)
        if not fingers or len(set(fingers)) != len(fingers):
            raise InputError(argument, "different fingertip names, at least one", repr(list(fingers)))
        return tuple(self.fingertips.index(name) for name in fingers)

    def finger_joints(self, fingertip: str) -> tuple[str, ...]:
        """The independent joints that move this fingertip and no other. Raises UnknownName."""
        (i,) = self.tip_numbers("fingertip", [fingertip])
        moves = self.moving_joints
        return tuple(name for k, name in enumerate(self.joint_names) if moves[i, k] and moves[:, k].sum() == 1)

    def tip_kind(self, tip: int) -> str:
        """What contacts of the tip numbered `tip` are found on: "radius", "collision", "visual", or "" for nothing."""
        return self._geometry.kind(self._tip_number(tip))

    def tip_shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The geometry of the fingertip numbered `tip`, loaded when first asked for. Raises URDFError for none."""
        return self._geometry.shapes(self._tip_number(tip))

    def tip_links(self, tip: int) -> set[str]:
        """The links whose collision geometry is that of the tip numbered `tip`."""
        return self._geometry.covered_links(self._tip_number(tip))

    def _tip_number(self, tip: int) -> int:
        """The number of a fingertip. Raises InputError."""
        return check_integer("tip", tip, 0, len(self.fingertips) - 1)

    @lazy_property
    def doubts(self) -> tuple[Doubt, ...]:
        """About the robot as it was read and its fingertips; those about torque limits that were passed left out."""
        from handlcp.robot.audit import description_doubts, tip_doubts  # 20 ms that no other question pays
        from handlcp.robot.joint_audit import tendon_doubts

        servos = self.stiffness if isinstance(self.stiffness, ServoStiffness) else None
        pull = self.stiffness.is_transmission  # tendons, as they do
        settled = {"route": pull, "tendon": pull or (servos is not None and not servos.widened)}
        own = *tip_doubts(self), *tendon_doubts(self)
        every = (*description_doubts(self.description, self.torques.given, self.kinematics), *own)
        return tuple(d for d in every if not settled.get(d.about))

    @lazy_property
    def link_surfaces(self) -> tuple[LinkSurface, ...]:
        """The links' collision geometry, loaded when first asked for. Raises URDFError."""
        return link_surfaces(self.description)

    def posed(self, q: Array) -> Self:
        """The same hand with springs as they are with joints at q (nv,), where tendons that run along routes have arms
        of their own.
        """
        stiffness = self.stiffness.in_posture(self.kinematics, check_array("q", q, (self.nv,)))
        return self if stiffness is self.stiffness else self.with_parts(stiffness=stiffness)

    def scale_stiffness(self, factor: float) -> Self:
        """The same hand with springs that are so many times as stiff."""
        return self.with_parts(stiffness=self.stiffness.scale_stiffness(check_number("factor", factor, above=0.0)))

    def with_parts(self, **parts: Any) -> Self:
        """The same hand with other parts, such as `stiffness` or `pads`."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, **parts)
        return made

    def limited(self, torques: TorqueLimits) -> Self:
        """The same hand with other torque limits, in place of motors, whose dry friction stays."""
        made = self.with_parts(torques=torques, torque_limits=torques.limits, joint_friction=self.dry_friction)
        made.__dict__.pop("doubts", None)
        return made

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set")

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays stay read-only when pickled."""
        self.__dict__.update(freeze_arrays(state))

    def __repr__(self) -> str:
        named = f"fingertips={list(self.fingertips)}, joints={list(self.joint_names)}"
        return f"{type(self).__name__}({self.name!r}, {named})"


# ----------------------------------------------------------------
# A hand in one posture: where its fingertips are, how its joints move them, and how they give way under forces.

DEFAULT_GRAVITY = (0.0, 0.0, -9.81)  # m/s², world axes
_GRAVITY_EXPECTED = "an acceleration [m/s²], such as (0, 0, -9.81) or (0, 0, 0): finite numbers"


def read_gravity(value: Any) -> Array:
    """(3,) [m/s²] as a user gives it, world axes. Raises InputError, which offers a vector for a size alone."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < abs(value) <= MAX_NUMBER:
        came = f"{value:g} (is (0, 0, {-abs(value):g}) meant?)"
        raise InputError("gravity", f"{_GRAVITY_EXPECTED} of shape (3,)", came)
    return check_array("gravity", value, (3,), what=_GRAVITY_EXPECTED)


# A joint moves a point p = (x, y, z) of its finger by v + ω × p = v + x a + y b + z c. `_TWIST_BASIS` maps (v; ω) to
# (v; a; b; c).
_TWIST_BASIS = np.zeros((12, 6))
_TWIST_BASIS[:3, :3] = np.eye(3)
_TWIST_BASIS[[4, 5], [5, 4]] = 1.0, -1.0  # a = (0, ω_z, -ω_y)
_TWIST_BASIS[[6, 8], [5, 3]] = -1.0, 1.0  # b = (-ω_z, 0, ω_x)
_TWIST_BASIS[[9, 10], [4, 3]] = 1.0, -1.0  # c = (ω_y, -ω_x, 0)


@check_method_calls
class HandPosture:
    """Immutable; all arrays read-only, world axes, metres and radians.

    q : (nv,) positions of the independent joints.
    tip_positions : (n, 3). tip_rotations : (n, 3, 3), columns the tip frame's axes.
    jacobian : (3n, nv) velocity of the tip origins in world axes (Pinocchio's LOCAL_WORLD_ALIGNED), tip by tip.
    flexibility : (3n, 3n) E = J K⁻¹ Jᵀ + pads [m/N], the displacement of the tips in world axes under forces on them.
    """

    hand: HandModel
    q: Array
    tip_positions: Array
    tip_rotations: Array
    _spread: Array

    def __init__(self, hand: HandModel, q: Array) -> None:
        hand = hand.posed(q)
        placements, columns = hand.kinematics.frames_at(q, hand.tips.frames)
        placements.flags.writeable = False
        self.__dict__.update(hand=hand, q=read_only(q), _spread=np.dot(_TWIST_BASIS, columns).reshape(4, -1))
        self.__dict__.update(tip_positions=placements[:, :3, 3], tip_rotations=placements[:, :3, :3])

    @lazy_property
    def jacobian(self) -> Array:
        """(3n, nv) translational Jacobian of the tip origins, world axes."""
        J = self.jacobian_at(self.tip_positions, self.hand.tips.numbers)
        return read_only(J.reshape(-1, self.hand.nv))

    @lazy_property
    def flexibility(self) -> Array:
        """(3n, 3n) symmetric positive semidefinite flexibility at the tips [m/N], world axes, the pads included."""
        pads = self.hand.pads.rotate_blocks(lambda: self.tip_rotations, self.hand.tips.numbers)
        return read_only(tip_flexibility(self.jacobian, self.hand.stiffness.compliance_factor, pads))

    def jacobian_at(self, points: Array, tips: tuple[int, ...]) -> Array:
        """(…, m, 3, nv) Jacobian v + ω × p of points (…, m, 3) that move with the tips numbered `tips`, world axes."""
        tips, at = self._tip_numbers(tips), check_array("points", points)
        if at.ndim < 2 or at.shape[-2:] != (len(tips), 3):
            raise InputError("points", f"finite numbers of shape (…, {len(tips)}, 3)", f"shape {at.shape}")
        J = np.dot(at, self._spread[1:]) + self._spread[0]
        return self._reduce_to_independent(J.reshape(*at.shape[:-1], 3, -1), tips)

    def angular_jacobian(self, tips: tuple[int, ...]) -> Array:
        """(m, 3, nv) angular Jacobian of the tips numbered `tips`, world axes [rad/rad]. Raises InputError."""
        tips = self._tip_numbers(tips)
        _, a, b, _ = self._spread.reshape(4, 3, -1)
        omega = np.stack([b[2], -a[2], a[1]])
        return self._reduce_to_independent(np.tile(omega, (len(tips), 1, 1)), tips)

    def gravity_torque(self, gravity: Any = (0.0, 0.0, -9.81)) -> Array:
        """(nv,) torque g(q) that holds the fingers' own weight [N·m]; gravity (3,) [m/s²], world axes."""
        return self.hand.kinematics.gravity_torque(self.q, read_gravity(gravity))

    def _tip_numbers(self, tips: Any) -> tuple[int, ...]:
        """Check the numbers of fingertips and return them. Raises InputError."""
        every = self.hand.tips.numbers
        if isinstance(tips, tuple) and tips == every:
            return every
        given = check_sequence("tips", tips, "numbers of fingertips")
        return tuple([check_integer(f"tips[{k}]", tip, 0, len(every) - 1) for k, tip in enumerate(given)])

    def _reduce_to_independent(self, J: Array, tips: tuple[int, ...]) -> Array:
        """Reduce columns (m, 3, joints) to those of independent joints (m, 3, nv).

        They are 0 where a joint moves no tip, and mimic joints are added to their masters.
        """
        support, coupling = self.hand.tips.support, self.hand.kinematics.coupling
        J *= support if tips == self.hand.tips.numbers else support[list(tips)]
        return J if coupling is None else np.asarray(J @ coupling)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.hand, self.q))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.hand.name!r}, q={np.round(self.q, 4).tolist()})"


# ----------------------------------------------------------------
# How the Jacobian of contact points changes with the joints.
#
# ∂J_j/∂q_i = ω_i × J_j  where joint i carries joint j or is it,  J_j = v_j + ω_j × p;  symmetric in i and j
#
# J_j is the motion of a point p of the finger under joint j; turning joint i turns all of it, point, axis and motion. A
# slide (ω_i = 0) turns nothing. The columns (v_j; ω_j) are Pinocchio's, in the world frame: a joint is carried by those
# of its finger with smaller numbers. Mimic joints q_full = C q + offset give Cᵀ (…) C. Source: Featherstone, Rigid Body
# Dynamics Algorithms (2008), chapter 2, derivatives of vectors that move with a body.


def contact_hessian(state: HandPosture, tips: Sequence[int], positions: Array, frames: Array) -> Array:
    """(3n, nv, nv) ∂J/∂q [m/rad²] of points (n, 3) [m] on the tips numbered `tips`, in frames (n, 3, 3) that stay."""
    hand = state.hand
    _, columns = hand.kinematics.frames_at(state.q, ())
    v, w = columns[:3].T, columns[3:].T  # (joints, 3)
    motion = (v + np.cross(w, positions[:, None])) * hand.tips.support[list(tips)].transpose(0, 2, 1)
    first, last = np.triu_indices(len(w))  # pairs of which the first, on one finger, carries the last
    turned = np.cross(w[first], motion[:, last]) * hand.tips.support[list(tips), 0][:, first, None]
    world = np.zeros((len(positions), len(w), len(w), 3))
    world[:, first, last] = world[:, last, first] = turned
    H = np.einsum("nxc,njkx->ncjk", frames, world)
    C = hand.kinematics.coupling
    if C is not None:
        H = C.T @ H @ C
    return np.asarray(H.reshape(-1, *H.shape[2:]))
