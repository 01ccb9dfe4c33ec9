"""The kinematics of a hand, computed by Pinocchio: independent joints, placements of frames, world Jacobian."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, Bools, check_array, check_keys, freeze_arrays, read_only
from handlcp.errors import InputError, URDFError
from handlcp.kinematics.joint_tree import WORLD, JointTree, TipPlacements
from handlcp.lazy_property import lazy_property
from handlcp.robot.joint import JointFacts, movable_joints, read_ranges, resolve_mimics


class Kinematics:
    """A Pinocchio model and its independent joints. Picklable; threads may share it, and have a copy of the model each.

    joint_names : nv of them, in Pinocchio's order. lower, upper : (nv,) ranges [rad, m], ±inf where there are none.
    neutral : (nv,) the posture nearest to zero in the ranges.
    movable : names of all movable joints. all_joints : how they follow the independent ones.
    coupling : (joints, nv) matrix C of q_full = C q + offset; None without mimic joints, where C is the identity.
    """

    def __init__(self, model: Any, facts: tuple[JointFacts, ...]) -> None:
        self.model, self.facts = model, facts
        movable = movable_joints(model)
        for f in facts:
            if f.axis is not None and not 0 < sum(a * a for a in f.axis) < np.inf:
                raise URDFError("source", f"an axis that is a direction for joint {f.name!r}", f"{f.axis}")
        coupling = resolve_mimics(movable, facts)
        self.movable, self.all_joints = movable, coupling
        self.joint_names, self.nv = coupling.names, len(coupling.names)
        self.coupling = None if self.joint_names == movable else coupling.C
        self.offset = coupling.offset
        self.lower, self.upper = read_ranges(movable, {f.name: f for f in facts}, coupling)
        self.neutral = read_only(np.clip(np.zeros(self.nv), self.lower, self.upper))
        self._zero = pin.neutral(model)
        self._local = threading.local()

    def find_moving_joints(self, support: Array) -> Bools:
        """(n, nv) whether an independent joint moves each of n things; support (n, joints) : 1 on its way."""
        return np.asarray((support if self.coupling is None else support @ abs(self.coupling)) > 0)

    def read_posture(self, argument: str, q: Any) -> Array:
        """(nv,) positions, read-only, from a vector or a mapping of all joints. Raises InputError, UnknownName."""
        if isinstance(q, Mapping):
            values = check_keys(argument, q, self.joint_names, "a joint")
            if missing := [name for name in self.joint_names if name not in values]:
                expected = f"a position for every joint, {', '.join(missing)} included"
                raise InputError(argument, expected, f"only {sorted(values)}")
            q = [values[name] for name in self.joint_names]
        try:
            return check_array(argument, q, (self.nv,))
        except InputError as error:
            expected = f"finite positions of the {self.nv} joints [{', '.join(self.joint_names)}]"
            raise InputError(argument, expected, error.got) from None

    def configuration(self, q: Array) -> Array:
        """The configuration (nq,) as Pinocchio has it, with mimic joints, and continuous joints as (cos, sin)."""
        full = q if self.coupling is None else self.coupling @ q + self.offset
        return full if len(full) == len(self._zero) else np.asarray(pin.integrate(self.model, self._zero, full))

    def frames_at(self, q: Array, frames: Sequence[int]) -> tuple[Array, Array]:
        """Placements (n, 4, 4) of frames, and the Jacobian (6, joints) of the world's origin, linear part first.

        The Jacobian is a view into this thread's Data, which the next call overwrites.
        """
        model, data = self._thread_data()
        pin.computeJointJacobians(model, data, self.configuration(q))
        pin.updateFramePlacements(model, data)
        placements = np.empty((len(frames), 4, 4))
        oMf = data.oMf
        for i, frame in enumerate(frames):
            placements[i] = oMf[frame].homogeneous
        return placements, jacobian_columns(data.J)

    def joints_at(self, q: Array, joints: Sequence[int]) -> tuple[Array, Array]:
        """Placements (n, 4, 4) of joints' frames, and the Jacobian as `frames_at`."""
        model, data = self._thread_data()
        pin.computeJointJacobians(model, data, self.configuration(q))
        oMi, placements = data.oMi, np.empty((len(joints), 4, 4))
        for i, joint in enumerate(joints):
            placements[i] = oMi[joint].homogeneous
        return placements, jacobian_columns(data.J)

    def gravity_torque(self, q: Array, gravity: Array) -> Array:
        """(nv,) torque g(q) that holds the links' weight [N·m]; q (nv,), gravity (3,) [m/s²] in world axes."""
        model, data = self._thread_data()
        model.gravity.linear = np.array(gravity)
        g = np.array(pin.computeGeneralizedGravity(model, data, self.configuration(q))).reshape(-1)
        return g if self.coupling is None else np.asarray(self.coupling.T @ g)

    @lazy_property
    def tree(self) -> JointTree | None:
        """The same joints as compiled code reads them; None: a joint is neither a hinge nor a slide."""
        return read_joint_tree(self.model, self.coupling, self.offset)

    def tip_placements(self, frames: Sequence[int]) -> TipPlacements:
        """Where frames are on the joints of `tree`."""
        found = [self.model.frames[frame] for frame in frames]
        carriers = np.array([int(f.parentJoint) - 1 for f in found], dtype=np.int64)
        rotations = np.array([f.placement.rotation for f in found], dtype=float).reshape(-1, 3, 3)
        return TipPlacements(carriers, rotations, np.array([f.placement.translation for f in found]).reshape(-1, 3))

    def _thread_data(self) -> tuple[Any, Any]:
        """A model and its Data that no other thread changes: gravity is a field of the model."""
        if not hasattr(self._local, "pair"):
            model = pin.Model(self.model)
            self._local.pair = model, model.createData()
        pair: tuple[Any, Any] = self._local.pair
        return pair

    def __getstate__(self) -> dict[str, Any]:
        """Everything that does not belong to a thread."""
        return {name: value for name, value in self.__dict__.items() if name != "_local"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(freeze_arrays(state))
        self._local = threading.local()


def jacobian_columns(J: Array) -> Array:
    """(6, joints) as Pinocchio keeps a Jacobian, which it hands out as (6,) where there is one joint."""
    return J.reshape(6, -1)


# ----------------------------------------------------------------
# The same joints as compiled code reads them.

_LETTERS = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_HINGES, _SLIDES = ("JointModelRevolute", "JointModelRUB", "JointModelR"), ("JointModelPrismatic", "JointModelP")


def read_joint_tree(model: Any, coupling: Array | None, offset: Array) -> JointTree | None:
    """The joints of a Pinocchio model, which follow the independent ones as q_full = C q + offset; C None: they are the
    same. None where a joint is neither a hinge nor a slide of one degree of freedom.
    """
    axes, slides, numbers = list[Array](), list[int](), range(1, model.njoints)
    for i in numbers:
        joint = model.joints[i]
        kind, name = joint.extract(), joint.shortname()
        word = next((w for w in (*_HINGES, *_SLIDES) if name.startswith(w)), None)
        given = getattr(kind, "axis", None)
        if given is None:
            given = None if word is None else _LETTERS.get(name.removeprefix(word))
        if word is None or given is None or joint.nv != 1 or joint.idx_v != i - 1:
            return None
        axes.append(np.array(given, dtype=float))
        slides.append(int(word in _SLIDES))
    placements, inertias = [model.jointPlacements[i] for i in numbers], [model.inertias[i] for i in numbers]
    return JointTree(
        np.array([WORLD if model.parents[i] == 0 else model.parents[i] - 1 for i in numbers], dtype=np.int64),
        np.array([at.rotation for at in placements]), np.array([at.translation for at in placements]),
        np.array(axes), np.array(slides, dtype=np.int64),
        np.empty((0, 0)) if coupling is None else np.array(coupling, dtype=float, order="C"),
        np.array(offset, dtype=float), np.array([float(body.mass) for body in inertias]),
        np.array([body.lever for body in inertias]),
    )  # fmt: skip
