"""The robot hand: a URDF, its fingertips, and what a URDF does not say."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.hand.audit import Audit, Doubt, doubts_of
from handlcp.hand.elasticity import Elasticity
from handlcp.hand.joints import joint_facts, model_facts
from handlcp.hand.kinematics import Kinematics, TipFrames, find_tips
from handlcp.hand.limits import TorqueLimits, read_torque_limits
from handlcp.hand.pads import Pads, read_pads
from handlcp.hand.state import HandState
from handlcp.hand.stiffness import read_stiffness
from handlcp.hand.tips import TipGeometry, TipShape, read_radii
from handlcp.hand.urdf import build_model, package_folders, read_urdf

if TYPE_CHECKING:
    from handlcp.hand.objects import Object

__all__ = ["Hand"]


class Hand:
    """A hand with elastic joints and fingertips. Immutable, safe to share between threads, picklable.

    Made by `Hand.from_urdf`. A mimic joint is no joint of its own here: positions, Jacobians, stiffness, limits and
    torques are those of the nv independent joints, and the joint that follows is built into them.
    """

    __slots__ = ("_geometry", "kinematics", "pads", "source", "stiffness", "tips", "torques")

    kinematics: Kinematics
    tips: TipFrames
    stiffness: Elasticity
    pads: Pads
    torques: TorqueLimits
    source: str
    _geometry: TipGeometry

    def __init__(
        self,
        kinematics: Kinematics,
        tips: TipFrames,
        stiffness: Elasticity,
        pads: Pads,
        torques: TorqueLimits,
        geometry: TipGeometry,
        source: str,
    ) -> None:
        """From parts; `Hand.from_urdf` is the door."""
        parts = {
            "kinematics": kinematics,
            "tips": tips,
            "stiffness": stiffness,
            "pads": pads,
            "torques": torques,
            "_geometry": geometry,
            "source": source,
        }
        for name, part in parts.items():
            object.__setattr__(self, name, part)

    @classmethod
    def from_urdf(
        cls,
        source: Any,
        fingertips: Sequence[str] | None = None,
        *,
        joint_stiffness: Any,
        pad_flexibility: Any = 0.0,
        torque_limits: Any = None,
        base: str | None = None,
        tip_radius: Any = None,
        package_dirs: Any = None,
    ) -> Hand:
        """Read a hand.

        source : path of a URDF file, or a pinocchio.Model (which knows no mimic joints and no collision geometry).
        fingertips : frame names; None: the leaf frames whose names end in "tip".
        joint_stiffness : [N·m/rad] a number, a mapping by joint name, (nv,), or an SPD matrix (nv, nv); None or inf:
            rigid. Or a transmission: `Tendons`, `Synergies`.
        pad_flexibility : [m/N] a number, (3,) along the tip frame's axes, (3, 3) PSD in tip axes, (n, 3, 3), or a
            mapping by tip name.
        torque_limits : [N·m] None: the URDF's efforts (zero, infinite or absent: unknown); a number, (nv,), or a
            mapping by joint name over the URDF's; inf: no limit.
        base : only the links below this one are the hand, and its frame is the world frame.
        tip_radius : [m] a number, or a mapping by tip name: a sphere about the tip frame. None: the URDF's collision
            geometry of the link that is the tip frame or, if it has none, of the links fixed to it. Used when
            contacts are detected, and only then.
        package_dirs : folders for package:// addresses of meshes.

        Raises URDFError, UnknownName (listing the valid names), InputError.
        """
        root, path = None, None
        if isinstance(source, pin.Model):
            if base is not None:
                raise InputError("base", "None for a pinocchio.Model (only a URDF file can be cut)", repr(base))
            model, facts = pin.Model(source), model_facts(source)
        else:
            root, path = read_urdf("source", source, base)
            facts = joint_facts(root)
            model = build_model("source", root, str(path))
        kinematics = Kinematics("source", model, facts)
        joints, tips = kinematics.joint_names, find_tips(model, fingertips)
        return cls(
            kinematics,
            tips,
            read_stiffness(joint_stiffness, joints),
            read_pads(pad_flexibility, tips.names),
            read_torque_limits(torque_limits, joints, {f.name: f for f in facts}),
            TipGeometry(
                model, root, tips.names, read_radii(tip_radius, tips.names), package_folders(package_dirs, path)
            ),
            path.name if path else str(model.name),
        )

    # -- what it is ----------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """The robot's name in the URDF."""
        return str(self.kinematics.model.name)

    @property
    def model(self) -> Any:
        """The pinocchio.Model behind it (a copy)."""
        return pin.Model(self.kinematics.model)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The nv independent joints, in the order of every vector over joints (Pinocchio's, not the file's)."""
        return self.kinematics.joint_names

    @property
    def nv(self) -> int:
        """The number of independent joints."""
        return self.kinematics.nv

    @property
    def fingertips(self) -> tuple[str, ...]:
        """The n fingertip frames."""
        return self.tips.names

    @property
    def lower(self) -> Array:
        """(nv,) lower ends of the joint ranges [rad, m], narrowed by the limits of mimic joints; -inf: none."""
        return self.kinematics.lower

    @property
    def upper(self) -> Array:
        """(nv,) upper ends of the joint ranges [rad, m], narrowed by the limits of mimic joints; inf: none."""
        return self.kinematics.upper

    @property
    def neutral(self) -> Array:
        """(nv,) the posture nearest to zero inside the joint ranges [rad, m]."""
        return self.kinematics.neutral

    @property
    def joint_stiffness(self) -> Array:
        """(nv, nv) stiffness of the independent joints [N·m/rad]; inf on the diagonal: rigid. Raises Unsupported where
        `Synergies` leave a compliance that has no inverse.
        """
        return self.stiffness.matrix

    @property
    def joint_compliance(self) -> Array:
        """(nv, nv) compliance C = K⁻¹ of the independent joints [rad/(N·m)], positive semidefinite."""
        return read_only(self.stiffness.compliance(np.eye(self.nv)))

    @property
    def pad_flexibility(self) -> Array:
        """(n, 3, 3) flexibility of the pads [m/N], tip axes."""
        return self.pads.blocks

    @property
    def torque_limits(self) -> Array:
        """(nv,) torque limits [N·m] (N for prismatic joints); inf where there is none or none is known."""
        return self.torques.limits

    def audit(self) -> Audit:
        """Every doubt about the numbers this hand rests on, and what to pass instead."""
        doubts = doubts_of(self.kinematics.facts, self.torques.given)
        if self.stiffness.uniform:
            k = self.stiffness.matrix[0, 0]
            what = f"a URDF has no place for joint stiffness: {k:g} N·m/rad was passed for every joint"
            doubts += (Doubt("hand", what, "joint_stiffness as measured, by joint name or as a matrix"),)
        return Audit(self.source, doubts)

    # -- what it does --------------------------------------------------------------------------------------------------

    def at(self, q: Any) -> HandState:
        """The hand in a posture: q (nv,) [rad, m] in the order of `joint_names`, or a mapping that names every one of
        them.

        Positions outside the joint ranges are allowed. Raises InputError (wrong size, not finite, joints left out),
        UnknownName.
        """
        q = self.kinematics.posture("q", q)
        return HandState(self, q, *self.kinematics.frames_at(q, self.tips.frames))

    def close_on(
        self,
        obj: Object,
        q0: Any = None,
        *,
        fingers: Sequence[str] | None = None,
        squeeze: float = 0.0,
        tolerance: float = 1e-6,
    ) -> Array:
        """Flex each finger from q0 (None: `neutral`) until its tip touches the object: the posture (nv,) [rad, m].

        See `handlcp.hand.close.close_on`. Raises NotReached for fingers that end elsewhere.
        """
        from handlcp.hand.close import close_on

        q0 = self.neutral if q0 is None else q0
        return close_on(self, obj, q0, fingers=fingers, squeeze=squeeze, tolerance=tolerance)

    # -- fingers -------------------------------------------------------------------------------------------------------

    def tip_numbers(self, argument: str, fingers: Any) -> tuple[int, ...]:
        """Positions of the named fingertips; None: all. Raises UnknownName, InputError."""
        if fingers is None:
            return self.tips.every
        if isinstance(fingers, str) or not isinstance(fingers, Sequence):
            raise InputError(argument, "a sequence of fingertip names", repr(fingers))
        unknown = [str(name) for name in fingers if name not in self.fingertips]
        if unknown:
            raise UnknownName(argument, "a fingertip", unknown, self.fingertips)
        if not fingers or len(set(fingers)) != len(fingers):
            raise InputError(argument, "different fingertip names, at least one", repr(list(fingers)))
        return tuple(self.fingertips.index(name) for name in fingers)

    @property
    def moves(self) -> Any:
        """(n, nv) bool: which independent joint moves which fingertip."""
        support, coupling = self.tips.support[:, 0, :], self.kinematics.coupling
        return (support if coupling is None else support @ abs(coupling)) > 0

    def finger_joints(self, fingertip: str) -> tuple[str, ...]:
        """The independent joints that move this fingertip and no other. Raises UnknownName."""
        (i,) = self.tip_numbers("fingertip", [fingertip])
        moves = self.moves
        return tuple(name for k, name in enumerate(self.joint_names) if moves[i, k] and moves[:, k].sum() == 1)

    def tip_shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The geometry of the fingertip numbered `tip`, loaded when first asked for. Raises URDFError if there is
        none.
        """
        return self._geometry.shapes(tip)

    @property
    def urdf_tree(self) -> tuple[Any, tuple[Path, ...]]:
        """The URDF as read, an xml.etree Element not to be changed (None for a pinocchio.Model), and mesh folders."""
        return self._geometry.root, tuple(self._geometry.folders)

    def __setattr__(self, name: str, value: object) -> None:
        """Nothing may change."""
        raise AttributeError(f"a Hand is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the parts it is made of."""
        parts = (self.kinematics, self.tips, self.stiffness, self.pads, self.torques, self._geometry, self.source)
        return (Hand, parts)

    def __repr__(self) -> str:
        """Name, fingertips and joints."""
        return f"Hand({self.name!r}, fingertips={list(self.fingertips)}, joints={list(self.joint_names)})"
