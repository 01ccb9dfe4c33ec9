"""The robot hand: a URDF, its fingertips, and what a URDF does not say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.hand.elasticity.pads import read_pads
from handlcp.hand.elasticity.stiffness import read_stiffness
from handlcp.hand.objects.close import close_on as _close_on
from handlcp.hand.robot.audit import Audit, Doubt, doubts_of
from handlcp.hand.robot.joint_limits import read_torque_limits
from handlcp.hand.robot.joints import joint_facts, model_facts
from handlcp.hand.robot.kinematics import Kinematics, find_tips
from handlcp.hand.robot.model import HandModel
from handlcp.hand.robot.tip_geometry import TipGeometry, read_radii
from handlcp.hand.robot.urdf import build_model, package_folders, read_urdf
from handlcp.hand.state import HandState

__all__ = ["Hand"]


class Hand(HandModel):
    """A hand with elastic joints and fingertips, made by `Hand.from_urdf`; what it promises is said at `HandModel`.

    Data: name, joint_names, nv, fingertips, lower, upper, neutral, torque_limits, and the parts kinematics, tips,
    stiffness, pads, torques.
    """

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
            model = build_model(root, str(path))
        kinematics = Kinematics(model, facts)
        joints, tips = kinematics.joint_names, find_tips(model, fingertips)
        stiffness, pads = read_stiffness(joint_stiffness, joints), read_pads(pad_flexibility, tips.names)
        torques = read_torque_limits(torque_limits, joints, {f.name: f for f in facts})
        radii, folders = read_radii(tip_radius, tips.names), package_folders(package_dirs, path)
        geometry, name = TipGeometry(model, root, tips, radii, folders), path.name if path else str(model.name)
        return cls(kinematics, tips, stiffness, pads, torques, geometry, name)

    @property
    def joint_stiffness(self) -> Array:
        """(nv, nv) K of the joints [N·m/rad]; inf: rigid. Raises Unsupported where `Synergies` leave C singular."""
        return self.stiffness.matrix

    @property
    def joint_compliance(self) -> Array:
        """(nv, nv) compliance C = K⁻¹ of the independent joints [rad/(N·m)], positive semidefinite."""
        return read_only(self.stiffness.compliance(np.eye(self.nv)))

    @property
    def pad_flexibility(self) -> Array:
        """(n, 3, 3) flexibility of the pads [m/N], tip axes."""
        return self.pads.blocks

    def audit(self) -> Audit:
        """Every doubt about the numbers that this hand is made of, and what to pass instead."""
        doubts = doubts_of(self.kinematics.facts, self.torques.given)
        if self.stiffness.uniform:
            k = self.stiffness.matrix[0, 0]
            what = f"a URDF has no place for joint stiffness: {k:g} N·m/rad was passed for every joint"
            doubts += (Doubt("hand", what, "joint_stiffness as measured, by joint name or as a matrix"),)
        return Audit(self.source, doubts)

    def at(self, q: Any) -> HandState:
        """The hand in a posture: q (nv,) [rad, m] in the order of `joint_names`, or a mapping that names all of them.

        Positions outside the joint ranges are allowed. Raises InputError, UnknownName.
        """
        return HandState(self, self.kinematics.posture("q", q))

    close_on = _close_on
