"""`Joints`: the joints of a grasp in the steps of a path, for callers in Python; what they do is in `joint_system`."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.model.mechanism import Cables
from handlcp.grasp.path.joint_system import (
    JOINT_ROUNDING,
    MAX_MODE_TRIALS,
    JointStep,
    JointSystem,
    JointTask,
    JointTrial,
    begin_trial,
    commanded_draw,
    joint_springs,
    move_free_joints,
    pack_joints,
    read_joint_state,
    spring_target,
    system_in_posture,
)
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.kinematics.cable_kinematics import TendonArms

_NONE, _NO_NUMBERS, _NO_LAYOUT = np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, 4), dtype=np.int64)
NO_JOINTS = _NONE, _NO_LAYOUT  # as `pack_joints` has them, where joints do nothing but give way
NO_TASK = JointTask(False, *NO_JOINTS, _NONE, _NONE, _NONE, _NONE, False, _NO_NUMBERS, _NONE, _NONE)


class Joints:
    """Joints of a grasp with springs of compliance C = A Aᵀ, dry friction and tendons, in one posture.

    factor : (nv, k) A. friction : (nv,) [N·m]. cables : None without tendons. posture : (nv,) from which the rest of
    the joints' own springs is counted.
    """

    def __init__(self, factor: Array, friction: Array, cables: Cables | None, posture: Array) -> None:
        cables = Cables.without_tendons(len(friction)) if cables is None else cables
        rest = posture + cables.rest
        at_rest = cables if cables.elasticity_at is None else cables.elasticity_at(rest)[0]
        self.cables = cables
        self.system = _system_of(factor, friction, cables, rest, at_rest.arms.T @ cables.initial_tension)
        self._whole, self._near = self, (b"", self)
        self._drawn_lately = b"", np.zeros(0)

    @property
    def C(self) -> Array:
        """(nv, nv) the joints' compliance."""
        return self.system.compliance

    def at(self, q: Array) -> Joints:
        """With the arms of tendons where joints are at q (nv,)."""
        if self.cables.elasticity_at is None:
            return self
        if self._near[0] != q.tobytes():
            there, made = self.cables.elasticity_at(q)[0], object.__new__(Joints)
            made.__dict__.update(self.__dict__)
            laid = TendonArms(there.arms, there.shift, there.wrap_friction, there.arms_beyond)
            rates = self.system.arm_rates if there.arm_rates is None else there.arm_rates()
            made.cables, made.system = there, system_in_posture(self._whole.system, laid, rates)
            self._near = q.tobytes(), made
        return self._near[1]

    def _step(self, task: Task) -> JointStep:
        """What kernels are asked."""
        driven, routed = task.drawn is None, self._whole is not self
        drawn = np.zeros(len(self.system.springs)) if task.drawn is None else task.drawn
        if driven and routed:
            drawn = self._whole._drawn_to(task.commanded)
        target = spring_target(self.system, task.commanded, drawn) if routed else task.commanded
        return JointStep(task.begun, task.commanded, target, drawn, driven)

    def _drawn_to(self, commanded: Array) -> Array:
        """(t,) d of tendons that hold joints free of contacts where they are commanded to be (nv,)."""
        if self._drawn_lately[0] != commanded.tobytes():
            self._drawn_lately = commanded.tobytes(), commanded_draw(self.at(commanded).system, commanded)
        return self._drawn_lately[1]

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of posts and tendons."""
        return len(self.system.wrap_friction), len(self.system.springs)

    @property
    def still(self) -> Pull:
        """Everything sticks, and all tendons are taut."""
        s = self.system
        modes = np.zeros(len(s.friction_rows) + len(s.springs), dtype=np.int64)
        return NO_PULL._replace(modes=modes, post_friction=np.zeros(len(s.wrap_friction)))

    def task(self, begun: Pull, task: Task, at: Array) -> JointTask:
        """What solves of an iterate, in which joints stand at (nv,), ask of the joints there. begun : modes that are
        assumed first.
        """
        here = self.at(at)
        step, (numbers, layout) = here._step(task), pack_joints(here.system, None, None)
        return JointTask(
            True, numbers, layout, task.begun, task.commanded, step.target, step.drawn, step.driven, begun.modes,
            begun.post_friction, at,
        )  # fmt: skip

    def ends(self, begun: Pull, task: Task) -> tuple[Array, Pull]:
        """Where joints come to that meet nothing, and what they do."""
        q = task.begun
        for _ in range(MAX_MODE_TRIALS):
            here, last = self.at(q), q
            trial = begin_trial(here.system, begun.modes, begun.post_friction)
            q, settled = move_free_joints(here.system, here._step(task), trial, last)
            if not settled:
                break
            if here is self or abs(q - last).max() <= JOINT_ROUNDING:
                return q, _pull_of(trial)
        still = self.still
        return task.commanded, self.at(task.commanded).pull(still.modes, still.post_friction, task, task.commanded)

    def pull(self, modes: Ints, post_friction: Array, task: Task, q: Array) -> Pull:
        """What tendons do where joints have come to q (nv,), in modes (nv + m + t,)."""
        return _pull_of(self._read(modes, post_friction, task, q, np.zeros(len(q))))._replace(
            modes=modes, post_friction=post_friction
        )

    def rubbing(self, pull: Pull, task: Task, q: Array, torque: Array) -> Array:
        """(nv + m,) f of joints [N·m] and posts [N] where joints have come to q (nv,), with torques (nv,) left for the
        contacts.
        """
        return self._read(pull.modes, pull.post_friction, task, q, torque).friction

    def _read(self, modes: Ints, post_friction: Array, task: Task, q: Array, torque: Array) -> JointTrial:
        s, step = self.system, self._step(task)
        trial = begin_trial(s, modes, post_friction)
        read_joint_state(s, joint_springs(s, trial), step, trial, q, torque)
        return trial

    def taken(self, f: Array) -> Array:
        """(nv,) what friction f (nv + m,) takes of the torques [N·m]."""
        return read_only(np.asarray(self.system.friction_rows.T @ f))


def _pull_of(trial: JointTrial) -> Pull:
    parts = (trial.post_friction, trial.drawn, trial.tension, trial.taut)
    return Pull(trial.modes, *[read_only(part) for part in parts])


def _system_of(factor: Array, friction: Array, cables: Cables, rest: Array, preload: Array) -> JointSystem:
    """As kernels read it, in the posture of the cables."""
    C, nv = factor @ factor.T, len(friction)
    gives, K = C.diagonal() > 0.0, np.zeros_like(C)
    on = np.ix_(gives, gives)
    K[on] = np.linalg.solve(C[on], np.eye(int(gives.sum())))
    rows, dry = np.concatenate([np.eye(nv), cables.arms_beyond]), np.where(gives, friction, 0.0)  # rigid joints stick
    rubs = np.append(dry > 0.0, (cables.wrap_friction > 0.0) & cables.arms_beyond.any(axis=1))
    parts = (
        K, factor, C, gives, rows, dry, rubs, cables.post_tendon, cables.wrap_friction, rest,
        cables.passive, preload, cables.springs, cables.initial_tension, np.isfinite(cables.pretension), cables.arms,
        cables.shift, cables.springs @ cables.arms, np.zeros((0, nv, nv)),
    )  # fmt: skip
    return JointSystem(*map(np.ascontiguousarray, parts))
