"""The robot hand: a URDF, its fingertips, and what a URDF does not say."""

from __future__ import annotations

import pickle
import threading
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, UnknownName, URDFError
from handlcp.hand.audit import Audit, Doubt, doubts_of
from handlcp.hand.joints import JointFacts, couple, joint_facts, model_facts, movable_joints
from handlcp.hand.limits import read_ranges, read_torque_limits
from handlcp.hand.state import HandState
from handlcp.hand.stiffness import JointStiffness, per_name, read_pads, read_stiffness
from handlcp.hand.tips import TipShape, read_radii, sphere_tip, urdf_tip
from handlcp.hand.urdf import build_model, package_folders, read_urdf

if TYPE_CHECKING:
    from handlcp.hand.objects import Object

__all__ = ["Hand"]


class Hand:
    """A hand with elastic joints and fingertips. Immutable; safe to share between threads; picklable. Made by `Hand.from_urdf`.

    name : the robot's. fingertips : n frame names. joint_names : the nv independent joints, in Pinocchio's order.
    lower, upper : (nv,) joint ranges [rad, m]. torque_limits : (nv,) [N·m], inf where unknown; limits_known : nv booleans.
    joint_stiffness : (nv, nv) [N·m/rad], inf on the diagonal for rigid joints. pad_flexibility : (n, 3, 3) [m/N], tip axes.
    neutral : (nv,) the posture nearest to zero inside the ranges.

    A mimic joint is no joint of its own: positions, Jacobians, stiffness and torques are those of the joint it follows.
    """

    name: str
    fingertips: tuple[str, ...]
    joint_names: tuple[str, ...]
    nv: int
    lower: Array
    upper: Array
    torque_limits: Array
    limits_known: tuple[bool, ...]
    pad_flexibility: Array
    stiffness: JointStiffness
    support: Array
    coupling: Array | None
    every_tip: tuple[int, ...]

    @classmethod
    def from_urdf(cls, source: Any, fingertips: Sequence[str] | None = None, *, joint_stiffness: Any, pad_flexibility: Any = 0.0,
                  torque_limits: Any = None, base: str | None = None, tip_radius: Any = None, package_dirs: Any = None) -> Hand:
        """Read a hand.

        source : path of a URDF file, or a pinocchio.Model (which knows no mimic joints and no collision geometry).
        fingertips : frame names; None: the leaf frames whose names end in "tip".
        joint_stiffness : [N·m/rad] a number, a mapping by joint name, (nv,), or an SPD matrix (nv, nv) for tendons; None or inf: rigid.
        pad_flexibility : [m/N] a number, (3,) along the tip frame's axes, (3, 3) PSD in tip axes, (n, 3, 3), or a mapping by tip name.
        torque_limits : [N·m] None: the URDF's efforts; a number, (nv,), or a mapping by joint name over the URDF's.
        base : only the links below this one are the hand, and its frame is the world frame.
        tip_radius : [m] a number, or a mapping by tip name: a sphere about the tip frame; None: the URDF's collision geometry of the
            link that is the tip frame, or, if that has none, of the links fixed to it. Needed for contact detection only.
        package_dirs : folders for package:// addresses of meshes.

        Raises URDFError, UnknownName (listing the valid names), InputError.
        """
        root = None
        if isinstance(source, pin.Model):
            if base is not None:
                raise InputError("base", "None for a pinocchio.Model (only a URDF file can be cut)", repr(base))
            model, path = pin.Model(source), None
            facts = model_facts(model)
        else:
            root, path = read_urdf("source", source, base)
            facts = joint_facts(root)
            model = build_model("source", root, str(path))
        hand = cls.__new__(cls)
        hand._read(model, root, facts)
        hand._set_tips(fingertips)
        hand.stiffness = read_stiffness(joint_stiffness, hand.joint_names)
        hand._set_pads(read_pads(pad_flexibility, hand.fingertips))
        by_name = {f.name: f for f in facts}
        hand.torque_limits, hand.limits_known, hand._limits_given = read_torque_limits(torque_limits, hand.joint_names, by_name)
        hand._folders = package_folders(package_dirs, path)
        hand._radii = read_radii(tip_radius, hand.fingertips)
        hand.label = str(path.name) if path else hand.name
        return hand

    # -- reading ---------------------------------------------------------------------------------------------------------------

    def _read(self, model: Any, root: ET.Element | None, facts: tuple[JointFacts, ...]) -> None:
        self.model, self._root, self._facts, self.name = model, root, facts, str(model.name)
        movable = movable_joints("source", model)
        for f in facts:
            if f.axis is not None and not 0 < sum(a * a for a in f.axis) < np.inf:
                raise URDFError("source", f"an axis that is a direction for joint {f.name!r}", f"{f.axis}")
        coupling = couple("source", movable, facts)
        self.joint_names = tuple(movable[i] for i in coupling.independent)
        self.nv = len(self.joint_names)
        self.coupling = None if coupling.identity else coupling.C
        self._offset = coupling.offset
        self.lower, self.upper = read_ranges(movable, {f.name: f for f in facts}, coupling)
        self.neutral = read_only(np.clip(np.zeros(self.nv), self.lower, self.upper))
        joints = sorted((model.joints[i] for i in range(1, model.njoints)), key=lambda joint: joint.idx_v)  # joint 0 is no joint
        self._direct = np.array([j.idx_q for j in joints if j.nv])
        self._wraps = tuple((j.idx_q, j.idx_v) for j in joints if j.nv and j.nq == 2)
        self._local = threading.local()

    def _set_tips(self, fingertips: Sequence[str] | None) -> None:
        model = self.model
        frames = [f.name for f in model.frames if f.name != "universe"]
        if fingertips is None:
            parents = {model.frames[i].parentFrame for i in range(model.nframes)}
            names = [f.name for i, f in enumerate(model.frames) if i not in parents and f.name.lower().endswith("tip")]
            if not names:
                raise UnknownName("fingertips", "frame names (no leaf frame ends in 'tip')", ["None"], frames)
        elif isinstance(fingertips, str) or not isinstance(fingertips, Sequence) or not all(isinstance(name, str) for name in fingertips):
            raise InputError("fingertips", "a sequence of frame names", repr(fingertips))
        else:
            names = list(fingertips)
        unknown = [name for name in names if name not in frames]
        if unknown:
            raise UnknownName("fingertips", "a frame", unknown, frames)
        if len(set(names)) != len(names) or not names:
            raise InputError("fingertips", "different frame names, at least one", repr(names))
        self.fingertips, self.every_tip = tuple(names), tuple(range(len(names)))
        self._frames = tuple(model.getFrameId(name) for name in names)
        support = np.zeros((len(names), 1, model.nv))
        for i, frame in enumerate(self._frames):
            for joint in model.supports[model.frames[frame].parentJoint]:
                if joint and model.joints[joint].nv:
                    support[i, 0, model.joints[joint].idx_v] = 1.0
        for name, moved in zip(names, support, strict=True):
            if not moved.any():
                raise InputError("fingertips", "frames that a joint moves", f"{name!r}, which is fixed to the base")
        self.support = read_only(support)

    def _set_pads(self, pads: Array) -> None:
        self.pad_flexibility = pads
        first = pads[:, 0, 0].copy()
        self._pads_isotropic = bool((pads == first[:, None, None] * np.eye(3)).all())
        self._pads_repeated = np.repeat(first, 3)

    # -- postures --------------------------------------------------------------------------------------------------------------

    def at(self, q: Any) -> HandState:
        """The hand in a posture: q (nv,) [rad, m] in the order of `joint_names`, or a mapping that names every one of them.

        Positions outside the joint ranges are allowed. Raises InputError (wrong size, not finite, joints left out), UnknownName.
        """
        q = self.posture("q", q)
        model, data = self._data()
        pin.computeJointJacobians(model, data, self.configuration(q))
        pin.updateFramePlacements(model, data)
        placements = np.empty((len(self._frames), 4, 4))
        oMf = data.oMf
        for i, frame in enumerate(self._frames):
            placements[i] = oMf[frame].homogeneous
        return HandState(self, q, placements, data.J)

    def posture(self, argument: str, q: Any) -> Array:
        """(nv,) positions from a vector or a mapping by joint name; read-only. Raises InputError, UnknownName."""
        if isinstance(q, Mapping):
            values = per_name(argument, q, self.joint_names, "a joint")
            missing = [name for name in self.joint_names if name not in values]
            if missing:
                raise InputError(argument, f"a position for every joint, {', '.join(missing)} included", f"only {sorted(values)}")
            q = [values[name] for name in self.joint_names]
        return array(argument, q, (self.nv,), what=f"finite positions of the {self.nv} joints [{', '.join(self.joint_names)}],")

    def configuration(self, q: Array) -> Array:
        """(nq,) Pinocchio's configuration: mimic joints added, continuous joints as (cos, sin)."""
        full = q if self.coupling is None else self.coupling @ q + self._offset
        if not self._wraps:
            return full
        configuration = np.empty(self.model.nq)
        configuration[self._direct] = full
        for at, i in self._wraps:
            configuration[at], configuration[at + 1] = np.cos(full[i]), np.sin(full[i])
        return configuration

    def gravity_torque(self, q: Array, gravity: Array) -> Array:
        """(nv,) torque g(q) that holds the fingers' weight [N·m]; q (nv,), gravity (3,) [m/s²] in world axes."""
        model, data = self._data()
        if getattr(self._local, "weighed", None) is None:
            self._local.weighed = pin.Model(model)  # gravity is a field of the model: every thread weighs with its own
        weighed = self._local.weighed
        weighed.gravity.linear = np.array(gravity)
        g = np.array(pin.computeGeneralizedGravity(weighed, data, self.configuration(q))).reshape(-1)
        return g if self.coupling is None else np.asarray(self.coupling.T @ g)

    def add_pads(self, E: Array, rotations: Array, tips: Sequence[int]) -> None:
        """Add the pads of the tips numbered `tips` to the diagonal blocks of E; rotations (m, 3, 3) turn tip axes into E's."""
        m = len(tips)
        if self._pads_isotropic:
            pads = self._pads_repeated if tips is self.every_tip else self.pad_flexibility[list(tips), 0, 0].repeat(3)
            E.reshape(-1)[:: 3 * m + 1] += pads
            return
        turned = rotations @ self.pad_flexibility[list(tips)] @ rotations.transpose(0, 2, 1)
        turned = (turned + turned.transpose(0, 2, 1)) / 2
        for i in range(m):
            E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] += turned[i]

    # -- fingers ---------------------------------------------------------------------------------------------------------------

    @property
    def joint_stiffness(self) -> Array:
        """(nv, nv) stiffness of the independent joints [N·m/rad]; inf on the diagonal: rigid."""
        return self.stiffness.matrix

    def tip_numbers(self, argument: str, fingers: Sequence[str] | None) -> tuple[int, ...]:
        """Positions of the named fingertips; None: all. Raises UnknownName, InputError."""
        if fingers is None:
            return self.every_tip
        if isinstance(fingers, str) or not isinstance(fingers, Sequence):
            raise InputError(argument, "a sequence of fingertip names", repr(fingers))
        unknown = [str(name) for name in fingers if name not in self.fingertips]
        if unknown:
            raise UnknownName(argument, "a fingertip", unknown, self.fingertips)
        if not fingers or len(set(fingers)) != len(fingers):
            raise InputError(argument, "different fingertip names, at least one", repr(list(fingers)))
        return tuple(self.fingertips.index(name) for name in fingers)

    def finger_joints(self, fingertip: str) -> tuple[str, ...]:
        """The independent joints that move this fingertip and no other. Raises UnknownName."""
        moved = self.moves
        (i,) = self.tip_numbers("fingertip", [fingertip])
        return tuple(name for name, column in zip(self.joint_names, moved.T, strict=True) if column[i] and column.sum() == 1)

    @property
    def moves(self) -> Any:
        """(n, nv) bool: which independent joint moves which fingertip."""
        support = self.support[:, 0, :]
        return (support if self.coupling is None else support @ abs(self.coupling)) > 0

    def tip_shapes(self, tip: int) -> tuple[TipShape, ...]:
        """The collision geometry of a fingertip, loaded when first asked for. Raises URDFError if the hand has none there."""
        shapes: dict[int, tuple[TipShape, ...]] = self.__dict__.setdefault("_shapes", {})
        if tip not in shapes:
            name = self.fingertips[tip]
            if name in self._radii:
                shapes[tip] = sphere_tip(self._radii[name])
            elif self._root is None:
                raise URDFError("tip_radius", f"a radius for {name!r}: a pinocchio.Model carries no collision geometry", "None")
            else:
                shapes[tip] = urdf_tip(self.model, self._root, name, self._folders)
        return shapes[tip]

    def close_on(self, obj: Object, q0: Any = None, *, fingers: Sequence[str] | None = None, squeeze: float = 0.0,
                 tolerance: float = 1e-6) -> Array:
        """Flex each finger until it touches; see `handlcp.hand.close.close_on`. Returns q (nv,). Raises NotReached."""
        from handlcp.hand.close import close_on

        return close_on(self, obj, self.neutral if q0 is None else q0, fingers=fingers, squeeze=squeeze, tolerance=tolerance)

    def audit(self) -> Audit:
        """Every doubt about the numbers this hand rests on, and what to pass instead."""
        given = [name for name, by_user in zip(self.joint_names, self._limits_given, strict=True) if by_user]
        doubts = doubts_of(self._facts, given)
        if self.stiffness.uniform:
            k = self.joint_stiffness[0, 0]
            doubts += (Doubt("hand", f"a URDF has no place for joint stiffness: every joint has the one that was passed, {k:g} N·m/rad",
                             "joint_stiffness as measured, by joint name or as a matrix"),)
        return Audit(self.label, doubts)

    # -- copies ----------------------------------------------------------------------------------------------------------------

    def _data(self) -> tuple[Any, Any]:
        data = getattr(self._local, "data", None)
        if data is None:
            data = self._local.data = self.model.createData()  # a Data of its own for each thread
        return self.model, data

    def __getstate__(self) -> dict[str, Any]:
        """All but what belongs to a thread."""
        state = {k: v for k, v in self.__dict__.items() if k not in ("_local", "_shapes", "model", "_root")}
        state["model"] = pickle.dumps(self.model)
        state["_root"] = None if self._root is None else ET.tostring(self._root, encoding="unicode")
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Rebuild what belongs to a thread."""
        self.__dict__.update(state)
        self.model = pickle.loads(state["model"])
        self._root = None if state["_root"] is None else ET.fromstring(state["_root"])
        self.every_tip = tuple(range(len(self.fingertips)))
        self._local = threading.local()

    def __repr__(self) -> str:
        """Name, fingertips and joints."""
        return f"Hand({self.name!r}, fingertips={list(self.fingertips)}, joints={list(self.joint_names)})"


