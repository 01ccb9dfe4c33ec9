"""A grasp followed in real time: posture, load and contacts move a little, and each answer starts at the last."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp import arguments
from handlcp.grasp.answer import answers
from handlcp.grasp.changed import changed, wrench_about
from handlcp.grasp.effects import softened
from handlcp.grasp.first import Found, kind_of, pack
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.pyramid import Pyramid, as_section
from handlcp.grasp.scene import cross_rows
from handlcp.grasp.solution import GraspSolution
from handlcp.hand.command import read_command
from handlcp.hand.grasp import HandGrasp
from handlcp.hand.posture import contact_jacobian
from handlcp.hand.update import GraspUpdate
from handlcp.hand.weight import tip_motion

__all__ = ["GraspStream"]


class GraspStream:
    """Follows one grasp: `update` takes what moved and returns certified forces, slips, motion and joint torques.

    grasp : where it begins; of a `HandGrasp` the posture may move, too: Jacobian and flexibility follow it, while the
    contacts stay where they are on the object until others are passed. faces : as in `Grasp.solve`. seed : of the
    solver. start : a solution of the grasp, or of a nearby one, to begin at, and to begin afresh at; None: nowhere. The
    first stage alone often fails from nowhere where soft fingers and a stiff environment meet, and seldom from there.

    Buffers, the layout of the problem and Pinocchio's data are made once; the flexibility is computed anew only when
    posture or contacts move; every answer starts at the last, and begins afresh where that leads nowhere. The time of
    an update is bounded: it takes the solver's first stage and no later one, and is UNDECIDED where that fails;
    `stream.grasp.solve()` asks all of them. A stream belongs to one thread.

    Raises InputError for a grasp with effects asked for by name other than compliances, or with soft fingers or
    anisotropic friction; `grasp.solve(start=...)` follows it.
    """

    def __init__(
        self, grasp: Grasp, faces: int | str | Pyramid = 8, seed: int = 0, start: GraspSolution | None = None
    ) -> None:
        if not isinstance(grasp, Grasp):
            raise InputError("grasp", "a Grasp", repr(grasp)[:80])
        if grasp.stamped:
            named = ", ".join(type(e).__name__ for e in grasp.stamped)
            expected = "one whose effects asked for are compliances; grasp.solve(start=...) follows any"
            raise InputError("grasp", expected, named)
        scene, n = grasp.scene, grasp.scene.n
        if scene.scale is not None:
            laws = ", ".join(dict.fromkeys(type(c.friction).__name__ for c in grasp.contacts))
            raise InputError("grasp", "one with Coulomb's friction; grasp.solve(start=...) follows any", laws)
        self._fingers = k = n - scene.environment  # contacts that the hand moves
        section = as_section(faces, planar=scene.plane is not None)
        self._kind, self._section = kind_of(scene, section), section
        self._seed = integer("seed", seed, 0)
        self._first, self._numbers, self._given_start = grasp, np.empty((1, self._kind.scene_width)), start
        self._start = self._anew = arguments.start(start, n)
        pack(scene, section, self._numbers[0])
        self._scene = read_only(self._numbers.view())
        ends = np.cumsum([3 * n, 9 * n, 9 * n * n, 3 * n, 3, 3]).tolist()
        p, R, E, d, f, m = np.split(self._numbers[0], ends)[:6]  # views: what is written there is what is solved
        self._positions, self._frames = p.reshape(n, 3), R.reshape(n, 3, 3)
        self._flexibility, self._offset, self._force, self._moment = E.reshape(3 * n, 3 * n), d.reshape(n, 3), f, m
        # The fingers' own E; where nothing is added to it, what is solved itself
        self._own = grasp.flexibility.copy() if grasp.effects else self._flexibility
        self._tips, self._axes = self._positions[:k], self._frames[:k]
        # Where the environment has a share of E, the hand's is made apart
        self._share = np.empty((3 * k, 3 * k)) if k < n else self._own
        self._posture = _Posture(grasp) if isinstance(grasp, HandGrasp) else None
        # The offset without what the hand adds to it: fingers that sag under their weight, joints commanded elsewhere
        self._adds = self._posture is not None and self._posture.adds
        self._given = np.array(grasp.tip_offset if isinstance(grasp, HandGrasp) else scene.offset)
        self._lift = arguments.lift(scene.positions, grasp.reference, scene.plane)

    def update(
        self,
        q: Any = None,
        *,
        wrench: Any = None,
        offset: Any = None,
        positions: Any = None,
        frames: Any = None,
        joint_offset: Any = None,
    ) -> GraspUpdate:
        """The answer after a change; what is None stays as it was.

        q : (nv,) joint positions [rad, m], or a mapping by joint name. The contact points stay where they are, and so
        do gaps and preloads, unless they are passed, too; fingers whose weight is in the elastic balance sag anew.
        wrench : (6,) the whole load about the grasp's reference, weight included [N, N·m]. offset : (n, 3) [m] as in
        `Grasp`. positions (n, 3) [m], frames (n, 3, 3) : of the contacts, world axes; x and y tangents, z into the
        object. joint_offset : (nv,) or a mapping by joint name [rad, m], how far beyond q the joints are commanded, as
        in `state.grasp`; it comes on top of offset, and follows the posture.
        With an environment offset, positions and frames may also be those of the fingers alone: its contacts stay.
        Raises InputError for wrong shapes and numbers not finite; the stream is then as it was.
        """
        first, planar = self._first, self._first.scene.plane is not None
        # All is checked before any of it is taken over
        posture = None if q is None else self._checked(q)
        command = None if joint_offset is None else self._hand("joint_offset", joint_offset).read(joint_offset)
        load = None if wrench is None else arguments.wrench(wrench, first.scene.plane, self._lift)
        shift = None if offset is None else array("offset", offset, *self._shapes(3))
        points = None if positions is None else array("positions", positions, *self._shapes(3))
        points = None if points is None else self._spatial("positions", points)
        axes = None if frames is None else array("frames", frames, *self._shapes(3, 3))
        axes = None if axes is None else self._spatial("frames", arguments.frames(axes, len(axes)))
        if load is not None:
            self._force[:] = load[:3]
            self._moment[:] = load[3:] + cross_rows(first.reference, load[:3])
        if shift is not None:
            self._given[: len(shift)] = self._offset[: len(shift)] = shift
        if points is not None:
            self._positions[: len(points)] = points
        if axes is not None:
            self._frames[: len(axes)] = axes
        if posture is not None or points is not None or axes is not None:
            if self._posture is not None:
                self._posture.move(posture, self._tips, self._axes, self._share)
                if self._share is not self._own:
                    self._own[: len(self._share), : len(self._share)] = self._share
            if first.effects:
                self._flexibility[:] = softened(self._own, first.effects, self._positions, self._frames, planar)
        if command is not None or self._adds:
            assert self._posture is not None  # nothing else has joints
            self._posture.command = self._posture.command if command is None else command
            self._adds = self._posture.adds
            self._offset[:] = self._posture.shifted(self._given, planar)
        rows = np.empty((1, self._kind.answer_width))
        answers(self._scene, self._kind.pattern, self._start, self._seed, rows)
        found = Found(self._kind, rows[0])
        passes = found.passes
        self._start = found.start if passes else self._anew
        joints = None if self._posture is None else self._posture.torques(found.forces)
        return GraspUpdate(first, found, passes, joints)

    @property
    def grasp(self) -> Grasp:
        """The grasp as it is now, for all that a `Grasp` can do."""
        now = changed(
            self._first,
            contacts=arguments.moved(self._first.contacts, self._positions, self._frames),
            positions=read_only(self._positions.copy()),
            frames=read_only(self._frames.copy()),
            flexibility=read_only(self._own.copy()),
            offset=read_only(self._offset.copy()),
            wrench=wrench_about(self._first.reference, self._force, self._moment),
        )
        if self._posture is not None:
            self._posture.describe(now)
        return now

    def __reduce__(self) -> tuple[Any, ...]:
        """Copied and pickled as the grasp as it is now: buffers are not shared."""
        return (GraspStream, (self.grasp, self._section, self._seed, self._given_start))

    def _shapes(self, *rest: int) -> list[tuple[int, ...]]:
        """Of arrays for all contacts, or for the fingers alone."""
        shapes = [(self._kind.n, *rest)]
        return shapes if self._fingers == self._kind.n else [*shapes, (self._fingers, *rest)]

    def _checked(self, q: Any) -> Array:
        return self._hand("q", q).hand.kinematics.posture("q", q)

    def _hand(self, argument: str, value: Any) -> _Posture:
        if self._posture is None:
            raise InputError(argument, "None for a grasp without a hand", repr(value)[:80])
        return self._posture

    def _spatial(self, argument: str, value: Array) -> Array:
        if self._first.scene.plane is not None:
            raise InputError(argument, "None in a planar scene, whose contacts stay", f"shape {value.shape}")
        return value


class _Posture:
    """The hand's part: Jacobian and flexibility at the contacts, weight of the fingers."""

    def __init__(self, grasp: HandGrasp) -> None:
        hand = self.hand = grasp.state.hand
        self.q, self.jacobian, self.gravity = grasp.state.q, grasp.jacobian, grasp.gravity
        self.weight, self.sag, self._sags = grasp.gravity_torque, grasp.sag, grasp.finger_weight is True
        self.command = grasp.joint_offset
        kinematics = hand.kinematics
        self._model, self._data = kinematics.model, kinematics.model.createData()
        self._tips = hand.tip_numbers("fingers", grasp.fingertips)
        self._support = np.ascontiguousarray(hand.tips.support[list(self._tips), 0])
        self._coupling = np.empty((0, 0)) if kinematics.coupling is None else np.array(kinematics.coupling)
        self._soften = hand.stiffness.softener()
        self._still = np.zeros((3 * grasp.scene.environment, hand.nv))  # the environment's rows

    def read(self, command: Any) -> Array:
        """(nv,) joint offsets from what users pass."""
        return read_command(command, self.hand.joint_names)

    @property
    def adds(self) -> bool:
        """Whether the scene's offset is another than the one given."""
        return self._sags or bool(self.command.any())

    def shifted(self, offset: Array, planar: bool) -> Array:
        """(n, 3) the scene's offset from the one given."""
        return offset + tip_motion(self.jacobian, self.sag - self.command, planar) if self.adds else offset

    def move(self, q: Array | None, positions: Array, frames: Array, E: Array) -> None:
        """Take the hand to q (None: it stays) and write the flexibility at its contacts (k, 3) into E (3k, 3k)."""
        model, data, hand = self._model, self._data, self.hand
        if q is not None:
            self.q = q
            if self.gravity.any():
                self.weight = hand.kinematics.gravity_torque(q, self.gravity)
                if self._sags:
                    self.sag = hand.stiffness.deflection(self.weight)
        pin.computeJointJacobians(model, data, hand.kinematics.configuration(self.q))
        if hand.pads.isotropic:
            pads = hand.pads.blocks[list(self._tips)]
        else:
            pin.updateFramePlacements(model, data)
            turn = np.array([frames[i].T @ data.oMf[hand.tips.frames[t]].rotation for i, t in enumerate(self._tips)])
            pads = turn @ hand.pads.blocks[list(self._tips)] @ turn.transpose(0, 2, 1)
        self.jacobian = contact_jacobian(data.J.T, self._support, self._coupling, positions, frames)
        self._soften(self.jacobian, pads, E)
        if len(self._still):
            self.jacobian = np.concatenate([self.jacobian, self._still])

    def torques(self, forces: Array) -> Array:
        """(nv,) τ = Jᵀ f, and g(q) where the fingers' weight counts [N·m]."""
        return np.asarray(forces.reshape(-1) @ self.jacobian + self.weight)

    def describe(self, grasp: Grasp) -> None:
        """Tell a copy of the grasp where the hand is now."""
        assert isinstance(grasp, HandGrasp)
        grasp.state = self.hand.at(self.q)
        grasp.jacobian, grasp.gravity_torque = read_only(self.jacobian), read_only(self.weight)
        grasp.sag, grasp.joint_offset = read_only(self.sag), self.command
