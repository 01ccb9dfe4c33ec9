"""`GraspStream`: a grasp followed in real time, each answer (`GraspUpdate`) from the last one on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import Effort, tip_flexibility
from handlcp.check import Array, check_array, check_init_call, check_integer, check_method_calls, read_only
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.grasp.assembly.scene_builder import add_flexibility, add_offset
from handlcp.grasp.effects.joint_offset import replace_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Placement, cross_rows, shift_twist
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.request import wrench_about
from handlcp.grasp.model.status import UNKNOWN, contact_words
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.compiled_answer import CompiledAnswer, get_compiled_kind, scene_views, start_values, write_row
from handlcp.grasp.solve.compiled_solve import NEWTON_STEPS, solve_scenes
from handlcp.grasp.verify.certifier import Residuals, forces_in_world
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.squeeze import read_joint_offset
from handlcp.hand.torque_check import TorqueCheck, compare_with_limits
from handlcp.kinematics.joint_tree import contact_jacobian
from handlcp.lcp import Status
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.robot.hand_model import HandModel
from handlcp.robot.kinematics import jacobian_columns


class GraspUpdate:
    """Arrays as in `GraspSolution`, read-only; NaN throughout where there is no answer.

    What a stream has no time for is left out: uniqueness, the smallest of several motions (this is the one nearest to
    the last answer), proofs. `stream.grasp.solve()` has them.
    """

    __slots__ = ("_found", "_frames", "_grasp", "_torques", "held")

    def __init__(self, grasp: Grasp, found: CompiledAnswer, held: bool, frames: Array, torques: Array | None) -> None:
        self._grasp, self._found, self.held, self._frames, self._torques = grasp, found, held, frames, torques

    @property
    def status(self) -> Status:
        """SOLVED, the certifier's word, or UNDECIDED."""
        return Status.SOLVED if self.held else Status.UNDECIDED

    @property
    def residuals(self) -> Residuals:
        """How far each law is missed."""
        return self._found.residuals

    @property
    def steps(self) -> int:
        """Newton steps taken; 0: the last answer's contact states hold still, or all contacts stick."""
        return int(self._found.rows[NEWTON_STEPS])

    @property
    def forces(self) -> Array:
        """(n, 3) N, of each finger on the object, contact axes."""
        return self._or_nan(self._found.components.reshape(-1, 3))

    @property
    def forces_world(self) -> Array:
        """The contact forces (n, 3) in world axes [N]."""
        return self._or_nan(read_only(forces_in_world(self._frames, self._found.components)))

    @property
    def gap(self) -> Array:
        """The gap (n,) between object and fingertip at each contact [m]."""
        return self._or_nan(self._found.motion[2::3])

    @property
    def slip(self) -> Array:
        """The slip (n, 2) of the object past each fingertip, in contact axes [m]."""
        return self._or_nan(self._found.motion.reshape(-1, 3)[:, :2])

    @property
    def object_displacement(self) -> Array:
        """(6,) m and rad, about the grasp's reference."""
        return self._or_nan(read_only(shift_twist(self._found.twist, self._grasp.reference - self._found.centre)))

    @property
    def reference(self) -> Array:
        """(3,) point that the object's motion refers to [m]."""
        return self._grasp.reference

    @property
    def contact_state(self) -> tuple[str, ...]:
        """(n,) "separated", "sticking", "sliding"; "unknown" where there is no answer."""
        return contact_words(self._found.states.tolist() if self.held else (UNKNOWN,) * self._grasp.spec.n)

    @property
    def torques(self) -> Array:
        """(nv,) N·m that the actuators hold. Raises AttributeError for a grasp without a hand."""
        if self._torques is None:
            raise AttributeError("a grasp without a hand has no torques")
        return self._or_nan(read_only(self._torques))

    @property
    def torque_check(self) -> TorqueCheck:
        """Joint by joint, as in `HandGraspSolution`. Raises AttributeError for a grasp without a hand."""
        torques = self.torques
        assert isinstance(self._grasp, HandGrasp)
        return compare_with_limits(self._grasp.state.hand, torques)

    @property
    def effort(self) -> Effort | None:
        """What tendons or synergies do, as in `HandGraspSolution`. Raises AttributeError for a grasp without a hand."""
        torques = self.torques
        assert isinstance(self._grasp, HandGrasp)
        return self._grasp.state.hand.stiffness.effort(torques, self._grasp.joint_offset)

    def _or_nan(self, values: Array) -> Array:
        return values if self.held else read_only(np.full(values.shape, np.nan))

    def __repr__(self) -> str:
        return f"GraspUpdate({self.status.name}, {', '.join(self.contact_state)})"


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
        self.effects = self.copy_effects(effects)
        self._weights = [e for e in self.effects if isinstance(e, FingerWeight)]  # one, or none
        self._model, self._data = kinematics.model, kinematics.model.createData()
        self._tips = mechanism.tips
        self._support = np.ascontiguousarray(hand.tips.support[list(self._tips), 0])
        self._coupling = np.empty((0, 0)) if kinematics.coupling is None else np.array(kinematics.coupling)

    def move(self, q: Array | None, positions: Array, frames: Array) -> Array:
        """Take the hand to q (None: it stays); returns E (3k, 3k) at its contacts, k of them, in contact axes."""
        self.q = self.q if q is None else q
        pin.computeJointJacobians(self._model, self._data, self.hand.kinematics.configuration(self.q))
        J = contact_jacobian(jacobian_columns(self._data.J).T, self._support, self._coupling, positions, frames)
        self.mechanism.jacobian[: len(J)] = J
        if q is not None:
            for weight in self._weights:
                weight.torque[:] = self.hand.kinematics.gravity_torque(q, self.mechanism.gravity)

        def to_contact_axes() -> Array:
            pin.updateFramePlacements(self._model, self._data)
            tips = np.array([self._data.oMf[self.hand.tips.frames[t]].rotation for t in self._tips])
            return np.asarray(frames.transpose(0, 2, 1) @ tips)

        pads = self.hand.pads.rotate_blocks(to_contact_axes, self._tips)
        return tip_flexibility(J, self.mechanism.compliance_factor, pads)

    def copy_effects(self, effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
        """The effects as they are now, with arrays of their own."""
        return tuple([replace(e, torque=e.torque.copy()) if isinstance(e, FingerWeight) else e for e in effects])


# ----------------------------------------------------------------
# A grasp followed in real time: posture, load and contacts move a little, and each answer starts at the last.


@check_init_call()
@check_method_calls
class GraspStream:
    """A grasp that is followed in real time: `update` takes what moved and returns certified forces, slips, motion and
    joint torques.

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
        self, grasp: Grasp, faces: int | str | Pyramid = "cone", seed: int = 0,
        start: GraspSolution | GraspUpdate | None = None,
    ) -> None:  # fmt: skip
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
        self._first, self._given_start, self._seed = grasp, start, check_integer("seed", seed, 0)
        self._section = as_section(faces, planar=spec.planar)
        self._kind, self._start = get_compiled_kind(scene, self._section), start_values(start, scene)
        self._anew = self._start
        self._numbers = np.empty((1, self._kind.width))
        write_row(scene, self._section, None, self._numbers[0])
        self._scene = read_only(self._numbers.view())
        k = spec.of_hand
        g = scene_views(self._numbers[0], self._kind.pattern)  # views: what is written there is what is solved
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
        self._lift = validate.height_above(scene.positions, grasp.reference, spec.plane)
        self._compile()

    def update(
        self, q: Any = None, *, wrench: Any = None, offset: Any = None, positions: Any = None, frames: Any = None,
        joint_offset: Any = None,
    ) -> GraspUpdate:  # fmt: skip
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
        posture = None if q is None else self._hand_moved("q", q).kinematics.read_posture("q", q)
        command = None
        if joint_offset is not None:
            command = read_joint_offset(joint_offset, self._hand_moved("joint_offset", joint_offset).joint_names)
        load = None if wrench is None else validate.wrench(wrench, self._at.plane, self._lift)
        shift = None if offset is None else check_array("offset", offset, *self._shapes(3))
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
            if self._hand is not None:
                E = self._hand.move(posture, self._tips, self._axes)
                self._own[: len(E), : len(E)] = E
            self._flexibility[:] = add_flexibility(self._effects, self._at, (), self._own)
        if command is not None:
            self._effects = replace_command(self._effects, command)
        if shift is not None or command is not None or (moved and self._effects):
            self._offset[:] = add_offset(self._effects, self._at, (), self._given.reshape(-1))
        return self._solve_update()

    @compile_now()
    def _compile(self) -> None:
        """Compile, or load, all that updates call: none of them should wait for it."""
        found = self._find_answer()
        add_flexibility(self._effects, self._at, (), self._own)
        add_offset(self._effects, self._at, (), self._given.reshape(-1))
        if self._hand is not None:
            before = self._hand.mechanism.jacobian.copy()
            self._hand.move(None, self._tips, self._axes)
            self._hand.mechanism.jacobian[:] = before  # the same to rounding, and updates start at the very same
        _ = GraspUpdate(self._first, found, True, self._frames.copy(), None).forces_world

    def _find_answer(self) -> CompiledAnswer:
        rows = solve_scenes(self._scene, self._kind.pattern, self._start, self._seed)
        return CompiledAnswer(self._kind, rows[0])

    def _solve_update(self) -> GraspUpdate:
        found = self._find_answer()
        passes = bool(found.passes)
        self._start = found.next_start if passes else self._anew
        torques = None
        if self._hand is not None:
            torques = found.components @ self._hand.mechanism.jacobian
            for e in self._effects:
                if (held := e.added_torque()) is not None:
                    torques = torques + held
            if (springs := self._hand.hand.stiffness.parallel_spring_torque(self._hand.q)) is not None:
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
            effects = self._hand.copy_effects(effects)
            posture = type(mechanism.posture)(self._hand.hand, self._hand.q)
            k = len(self._tips)
            jacobian = read_only(self._hand.mechanism.jacobian.copy())
            stand_off = read_only(np.zeros((k, 3))) if self._moved_off else mechanism.stand_off
            mechanism = replace(
                mechanism, posture=posture, rest_posture=posture.q, jacobian=jacobian, positions=positions[:k],
                frames=frames[:k], stand_off=stand_off,
            )  # fmt: skip
        now = spec.replace(
            contacts=validate.move_contacts(at.contacts, positions, frames), positions=positions, frames=frames,
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

    def _hand_moved(self, argument: str, value: Any) -> HandModel:
        if self._hand is None:
            raise InputError(argument, "None for a grasp without a hand", repr(value)[:80])
        return self._hand.hand

    def _spatial(self, argument: str, value: Any, *rest: int) -> Array | None:
        given = None if value is None else check_array(argument, value, *self._shapes(*rest))
        if given is not None and self._at.planar:
            raise InputError(argument, "None in a planar scene, whose contacts stay", f"shape {given.shape}")
        return given
