"""What is known of a hand before it takes a posture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, integer, number, read_only, sealed
from handlcp.errors import InputError, UnknownName
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.stiffness import Pads
from handlcp.hand.robot.fingertips import TipFrames
from handlcp.hand.robot.joints import Doubt, TorqueLimits
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.source.description import Description
from handlcp.hand.robot.tip_geometry import TipGeometry, TipShape
from handlcp.keywords import helped_methods
from handlcp.lazy import lazy

if TYPE_CHECKING:
    from handlcp.hand.robot.link_surface import LinkSurface


@helped_methods
class HandModel:
    """The parts of a hand with elastic joints and fingertips. Immutable, safe to share between threads, picklable.

    A mimic joint is not a joint of its own here: positions, Jacobians, stiffness, limits and torques are those of the
    nv independent joints, and `kinematics` moves the mimic joints with the joints that they follow.

    name : the robot's own. source : name of the file; that of the robot for an XML string or a pinocchio.Model.
    joint_names : nv of them, in the order of every vector over joints (Pinocchio's, not the file's).
    fingertips : n names of frames.
    lower, upper : (nv,) ends of the joint ranges [rad, m], narrowed by the limits of mimic joints; ±inf: none.
    neutral : (nv,) the posture nearest to zero inside the joint ranges [rad, m].
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
    pads: Pads
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
        pads: Pads,
        torques: TorqueLimits,
        geometry: TipGeometry,
    ) -> None:
        self.__dict__.update(
            kinematics=kinematics, tips=tips, stiffness=stiffness, pads=pads, torques=torques, _geometry=geometry,
            name=str(kinematics.model.name), source=geometry.description.source, joint_names=kinematics.joint_names,
            nv=kinematics.nv, fingertips=tips.names, lower=kinematics.lower, upper=kinematics.upper,
            neutral=kinematics.neutral, torque_limits=torques.limits, links_of_sites=None, may_touch=None,
            in_parts_of=frozenset(), own_tips=(), joint_friction=read_only(np.zeros(kinematics.nv)),
        )  # fmt: skip

    @property
    def model(self) -> Any:
        """The pinocchio.Model (a copy)."""
        return pin.Model(self.kinematics.model)

    @property
    def moves(self) -> Any:
        """(n, nv) bool: which independent joint moves which fingertip."""
        return self.kinematics.moved_by(self.tips.support[:, 0, :])

    @lazy
    def mass(self) -> float:
        """[kg] of all its links; 0 where the file says none."""
        return sum(float(inertia.mass) for inertia in self.kinematics.model.inertias)

    @lazy
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
    def description(self) -> Description:
        """The robot as it was read."""
        return self._geometry.description

    def tip_numbers(self, argument: str, fingers: Any) -> tuple[int, ...]:
        """Positions of the named fingertips in `fingertips`; None: all. Raises UnknownName, InputError."""
        if fingers is None:
            return self.tips.every
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
        moves = self.moves
        return tuple(name for k, name in enumerate(self.joint_names) if moves[i, k] and moves[:, k].sum() == 1)

    def tip_kind(self, tip: int) -> str:
        """What contacts of the tip numbered `tip` are found on: "radius", "collision", "visual", or "" for nothing."""
        return self._geometry.kind(self._tip(tip))

    def tip_shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The geometry of the fingertip numbered `tip`, loaded when first asked for. Raises URDFError for none."""
        return self._geometry.shapes(self._tip(tip))

    def tip_links(self, tip: int) -> set[str]:
        """The links whose collision geometry is that of the tip numbered `tip`."""
        return self._geometry.covers(self._tip(tip))

    def _tip(self, tip: int) -> int:
        """The number of a fingertip. Raises InputError."""
        return integer("tip", tip, 0, len(self.fingertips) - 1)

    @lazy
    def doubts(self) -> tuple[Doubt, ...]:
        """About the robot as it was read and its fingertips; those about torque limits that were passed left out."""
        from handlcp.hand.robot.audit import doubts_of, tip_doubts
        from handlcp.hand.robot.audit_joints import tendon_doubts
        from handlcp.hand.robot.source.servos import ServoStiffness

        servos = self.stiffness if isinstance(self.stiffness, ServoStiffness) else None
        pull = bool(self.stiffness.law[1])  # tendons, as they do
        settled = {"route": pull, "tendon": pull or (servos is not None and not servos.widened)}
        own = *tip_doubts(self), *tendon_doubts(self)
        every = (*doubts_of(self.description, self.torques.given, self.kinematics), *own)
        return tuple(d for d in every if not settled.get(d.about))

    @lazy
    def link_surfaces(self) -> tuple[LinkSurface, ...]:
        """The links' collision geometry, loaded when first asked for. Raises URDFError."""
        from handlcp.hand.robot.link_surface import link_surfaces

        return link_surfaces(self.description)

    def posed(self, q: Array) -> Self:
        """The same hand with springs as they are with joints at q (nv,), where tendons that run along routes have arms
        of their own.
        """
        stiffness = self.stiffness.at(self.kinematics, array("q", q, (self.nv,)))
        return self if stiffness is self.stiffness else self.with_parts(stiffness=stiffness)

    def stiffer(self, factor: float) -> Self:
        """The same hand with springs that are so many times as stiff."""
        return self.with_parts(stiffness=self.stiffness.stiffer(number("factor", factor, above=0.0)))

    def with_parts(self, **parts: Any) -> Self:
        """The same hand with other parts, such as `stiffness` or `pads`."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, **parts)
        return made

    def limited(self, torques: TorqueLimits) -> Self:
        """The same hand with other torque limits, in place of motors, whose dry friction stays."""
        made = object.__new__(type(self))
        rubs = self.dry_friction
        made.__dict__.update(self.__dict__, torques=torques, torque_limits=torques.limits, joint_friction=rubs)
        made.__dict__.pop("doubts", None)
        return made

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a {type(self).__name__} is immutable: {name} cannot be set")

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays stay read-only when pickled."""
        self.__dict__.update(sealed(state))

    def __repr__(self) -> str:
        named = f"fingertips={list(self.fingertips)}, joints={list(self.joint_names)}"
        return f"{type(self).__name__}({self.name!r}, {named})"
