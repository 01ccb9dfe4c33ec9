"""A grasp followed in real time: posture, load and contacts move a little, and each answer starts at the last."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array, array, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.assembly.build import shifted_by, softened_by
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import recommanded
from handlcp.grasp.friction import Pyramid, as_section
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model import validate
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.kind import Placement, cross_rows
from handlcp.grasp.model.spec import wrench_about
from handlcp.grasp.solve.compiled_answer import CompiledAnswer, compiled_kind, start_from
from handlcp.grasp.solve.compiled_solve import solve_scenes
from handlcp.grasp.solve.scene_row import views, write_row
from handlcp.hand.command import read_joint_offset
from handlcp.hand.elasticity.stiffness import tip_flexibility
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.robot.kinematics import columns, contact_jacobian
from handlcp.hand.update import GraspUpdate
from handlcp.keywords import helped_init, helped_methods
from handlcp.lcp.compiler.when import at_once

# ----------------------------------------------------------------
# A hand that moves while it grasps: its Jacobian and flexibility at contacts that stay where they are, compiled.


class MovingHand:
    """The hand of a stream; Pinocchio's data and what does not change are made once.

    q : (nv,) its posture. mechanism, effects : of the grasp; the Jacobian, and the torques of the fingers' weight, are
    buffers that `move` writes into. `fixed` copies the effects.
    """

    def __init__(self, mechanism: HandMechanism, effects: tuple[Effect, ...]) -> None:
        hand = mechanism.posture.hand
        kinematics = hand.kinematics
        self.hand, self.q = hand, mechanism.posture.q
        self.mechanism = replace(mechanism, jacobian=mechanism.jacobian.copy())
        self.effects = self.fixed(effects)
        self._weights = [e for e in self.effects if isinstance(e, FingerWeight)]  # one, or none
        self._model, self._data = kinematics.model, kinematics.model.createData()
        self._tips = mechanism.tips
        self._support = np.ascontiguousarray(hand.tips.support[list(self._tips), 0])
        self._coupling = np.empty((0, 0)) if kinematics.coupling is None else np.array(kinematics.coupling)

    def checked(self, q: Any) -> Array:
        """(nv,) from what users pass. Raises InputError, UnknownName."""
        return self.hand.kinematics.posture("q", q)

    def move(self, q: Array | None, positions: Array, frames: Array) -> Array:
        """Take the hand to q (None: it stays); returns E (3k, 3k) at its contacts, k of them, in contact axes."""
        self.q = self.q if q is None else q
        pin.computeJointJacobians(self._model, self._data, self.hand.kinematics.configuration(self.q))
        J = contact_jacobian(columns(self._data.J).T, self._support, self._coupling, positions, frames)
        self.mechanism.jacobian[: len(J)] = J
        if q is not None:
            for weight in self._weights:
                weight.torque[:] = self.hand.kinematics.gravity_torque(q, self.mechanism.gravity)
        pads = self.hand.pads.in_axes(lambda: frames.transpose(0, 2, 1) @ self._tip_rotations(), self._tips)
        return tip_flexibility(J, self.mechanism.root, pads)

    def fixed(self, effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """The effects as they are now, with arrays of their own."""
        return tuple([replace(e, torque=e.torque.copy()) if isinstance(e, FingerWeight) else e for e in effects])

    def _tip_rotations(self) -> Array:
        """(k, 3, 3) from tip axes to world axes, where the hand is now."""
        pin.updateFramePlacements(self._model, self._data)
        return np.array([self._data.oMf[self.hand.tips.frames[t]].rotation for t in self._tips])


# ----------------------------------------------------------------


@helped_init()
@helped_methods
class GraspStream:
    """Follows one grasp: `update` takes what moved and returns certified forces, slips, motion and joint torques.

    grasp : where it begins; of a `HandGrasp` the posture may move, too: Jacobian and flexibility follow it, while the
    contacts stay where they are on the object until others are passed. faces : as in `Grasp.solve`. seed : of the
    solver. start : a solution of the grasp, or of a nearby one, to begin at, and to begin afresh at; None: nowhere.

    Buffers, the layout of the problem and Pinocchio's data are made once; the flexibility is computed anew only when
    posture or contacts move; every answer starts at the last, and begins afresh where that leads nowhere. The time of
    an update is bounded: it takes the solver's first stage and no later one, and is UNDECIDED where that fails;
    `stream.grasp.solve()` asks all of them. A stream belongs to one thread.

    Raises InputError for a grasp with effects asked for by name that bring unknowns or depend on the forces, or with
    soft fingers or anisotropic friction; `grasp.solve(start=...)` follows it.
    """

    def __init__(
        self,
        grasp: Grasp,
        faces: int | str | Pyramid = "cone",
        seed: int = 0,
        start: GraspSolution | GraspUpdate | None = None,
    ) -> None:
        if not isinstance(grasp, Grasp):
            raise InputError("grasp", "a Grasp", repr(grasp)[:80])
        if unknown := [
            type(e).__name__ for e in grasp.spec.effects if e.stamps or e.depends_on_forces or e.prescribed()
        ]:
            expected = "one whose effects asked for are compliances; grasp.solve(start=...) follows any"
            raise InputError("grasp", expected, ", ".join(unknown))
        spec, scene = grasp.spec, grasp.scene
        if scene.scale is not None:
            laws = ", ".join(dict.fromkeys(type(c.friction).__name__ for c in grasp.contacts))
            raise InputError("grasp", "one with Coulomb's friction; grasp.solve(start=...) follows any", laws)
        self._first, self._given_start, self._seed = grasp, start, integer("seed", seed, 0)
        self._section = as_section(faces, planar=spec.planar)
        self._kind, self._start = compiled_kind(scene, self._section), start_from(start, scene)
        self._anew = self._start
        self._numbers = np.empty((1, self._kind.scene_width))
        write_row(scene, self._section, self._numbers[0])
        self._scene = read_only(self._numbers.view())
        n, k = spec.n, spec.of_hand
        g, _ = views(self._numbers[0], n, 0, scene.dof)  # views: what is written there is what is solved
        self._positions, self._frames, self._flexibility, self._offset = g.positions, g.frames, g.flexibility, g.offset
        self._force, self._moment = g.force, g.moment
        self._tips, self._axes = self._positions[:k], self._frames[:k]
        # Without what the effects add
        self._own, self._given = spec.flexibility.copy(), spec.offset.copy()
        mechanism = spec.mechanism
        self._moved_off = False  # whether an offset has taken the place of the gaps that were detected
        self._hand, self._effects = None, spec.effects
        if isinstance(mechanism, HandMechanism):
            self._hand = MovingHand(mechanism, spec.effects)
            mechanism, self._effects = self._hand.mechanism, self._hand.effects
        self._at = Placement(spec.contacts, self._positions, self._frames, spec.plane, spec.fingers, mechanism)
        self._lift = validate.lift(scene.positions, grasp.reference, spec.plane)
        self._compile()

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
        # All is checked before any of it is taken over
        posture = None if q is None else self._joints("q", q).checked(q)
        command = None
        if joint_offset is not None:
            command = read_joint_offset(joint_offset, self._joints("joint_offset", joint_offset).hand.joint_names)
        load = None if wrench is None else validate.wrench(wrench, self._at.plane, self._lift)
        shift = None if offset is None else array("offset", offset, *self._shapes(3))
        points, axes = self._spatial("positions", positions, 3), self._spatial("frames", frames, 3, 3)
        if axes is not None:
            axes = validate.frames(axes, len(axes))
        if load is not None:
            self._force[:] = load[:3]
            self._moment[:] = load[3:] + cross_rows(self._first.reference, load[:3])
        if shift is not None:
            self._given[: len(shift)] = shift
            self._moved_off = True
        if points is not None:
            self._positions[: len(points)] = points
        if axes is not None:
            self._frames[: len(axes)] = axes
        moved = posture is not None or points is not None or axes is not None
        if moved:
            self._move(posture)
        if command is not None:
            self._effects = recommanded(self._effects, command)
        if shift is not None or command is not None or (moved and self._effects):
            self._offset[:] = shifted_by(self._effects, self._at, (), self._given.reshape(-1))
        return self._solved()

    def _move(self, q: Array | None) -> None:
        """The hand in a posture (None: the same), and flexibility at the contacts as they are."""
        if self._hand is not None:
            E = self._hand.move(q, self._tips, self._axes)
            self._own[: len(E), : len(E)] = E
        self._flexibility[:] = softened_by(self._effects, self._at, (), self._own)

    @at_once()
    def _compile(self) -> None:
        """Compile, or load, all that updates call: none of them should wait for it."""
        rows = np.empty((1, self._kind.answer_width))
        solve_scenes(self._scene, self._kind.pattern, self._start, self._seed, rows)
        softened_by(self._effects, self._at, (), self._own)
        shifted_by(self._effects, self._at, (), self._given.reshape(-1))
        if self._hand is not None:
            before = self._hand.mechanism.jacobian.copy()
            self._hand.move(None, self._tips, self._axes)
            self._hand.mechanism.jacobian[:] = before  # the same to rounding, and updates start at the very same
        found = CompiledAnswer(self._kind, rows[0])
        _ = GraspUpdate(self._first, found, True, self._frames.copy(), None).forces_world

    def _solved(self) -> GraspUpdate:
        rows = np.empty((1, self._kind.answer_width))
        solve_scenes(self._scene, self._kind.pattern, self._start, self._seed, rows)
        found = CompiledAnswer(self._kind, rows[0])
        passes = found.passes
        self._start = found.start if passes else self._anew
        torques = None
        if self._hand is not None:
            torques = found.components @ self._hand.mechanism.jacobian
            for e in self._effects:
                if (held := e.added_torque()) is not None:
                    torques = torques + held
            if (springs := self._hand.hand.stiffness.against_springs(self._hand.q)) is not None:
                torques = torques + springs
        return GraspUpdate(self._first, found, passes, self._frames.copy(), torques)

    @property
    def grasp(self) -> Grasp:
        """The grasp as it is now, for all that a `Grasp` can do."""
        spec, at = self._first.spec, self._at
        positions, frames = read_only(self._positions.copy()), read_only(self._frames.copy())
        mechanism, effects = spec.mechanism, self._effects
        if self._hand is not None:
            assert isinstance(mechanism, HandMechanism)
            effects = self._hand.fixed(effects)
            posture = type(mechanism.posture)(self._hand.hand, self._hand.q)
            k = len(self._tips)
            mechanism = replace(
                mechanism, posture=posture, relaxed=posture.q, jacobian=read_only(self._hand.mechanism.jacobian.copy()),
                positions=positions[:k], frames=frames[:k],
                stand_off=read_only(np.zeros((k, 3))) if self._moved_off else mechanism.stand_off,
            )  # fmt: skip
        now = spec.replace(
            contacts=validate.moved(at.contacts, positions, frames), positions=positions, frames=frames,
            mechanism=mechanism, flexibility=read_only(self._own.copy()), offset=read_only(self._given.copy()),
            wrench=wrench_about(self._first.reference, self._force, self._moment), effects=effects,
        )  # fmt: skip
        return type(self._first)(now)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copied and pickled as the grasp as it is now: buffers are not shared."""
        return (GraspStream, (self.grasp, self._section, self._seed, self._given_start))

    def _shapes(self, *rest: int) -> list[tuple[int, ...]]:
        """Of arrays for all contacts, or for the fingers alone."""
        n, k = self._at.n, len(self._tips)
        return [(n, *rest)] if k == n else [(n, *rest), (k, *rest)]

    def _joints(self, argument: str, value: Any) -> MovingHand:
        if self._hand is None:
            raise InputError(argument, "None for a grasp without a hand", repr(value)[:80])
        return self._hand

    def _spatial(self, argument: str, value: Any, *rest: int) -> Array | None:
        given = None if value is None else array(argument, value, *self._shapes(*rest))
        if given is not None and self._at.planar:
            raise InputError(argument, "None in a planar scene, whose contacts stay", f"shape {given.shape}")
        return given
