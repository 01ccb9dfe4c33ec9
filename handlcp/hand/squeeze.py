"""`TipMotions`: how far a hand is squeezed: from overlaps to joint offsets, and what of it the joints cannot make."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp.check import Array, NumbersByName, read_only
from handlcp.errors import InputError, URDFError
from handlcp.geometry.link_contacts import expand_link_values
from handlcp.geometry.link_penetration import find_penetrating_links
from handlcp.grasp.effects.joint_offset import OVERLAP_TOLERANCE, CommandReach, JointOffset, find_command
from handlcp.grasp.model.request import GraspSpec

# ----------------------------------------------------------------
# What is asked of fingertips and no command of the joints makes, and a squeeze that goes on from an earlier one.


def tip_motions(mechanism: Any, planar: bool, commands: Array | None = None) -> TipMotions:
    """What the actuators of a `HandMechanism` do to the fingers' contacts; or others, with these commands."""
    commands = mechanism.posture.hand.stiffness.command_directions if commands is None else commands
    return TipMotions.from_jacobian(mechanism.fingertips, mechanism.jacobian, commands, planar)


def tip_motions_by_joint(mechanism: Any, planar: bool) -> TipMotions:
    """As if every joint had an actuator of its own."""
    return tip_motions(mechanism, planar, np.eye(len(mechanism.names)))


def find_unreachable(spec: GraspSpec) -> tuple[CommandReach, ...]:
    """What no command makes of overlaps, preloads and commands; but for links that the object begins inside."""
    mechanism: Any = spec.mechanism  # a hand's
    k = spec.of_hand
    tips, found = tip_motions(mechanism, spec.planar), []
    inside = overlap_depths(mechanism.stand_off[:, 2])
    if (inside := np.where(start_penetration(spec) > 0.0, 0.0, inside)).any():
        found.append(tip_motions_by_joint(mechanism, spec.planar).overlap_reach(inside))
    given = mechanism.stand_off - spec.offset[:k]
    given[given[:, 2] < 0.0] = 0.0  # a gap, which nothing has to make
    if abs(given).max(initial=0.0) > OVERLAP_TOLERANCE:
        found.append(tips.preload_reach(given))
    if (command := find_command(spec.effects)) is not None and command.reach is not None:
        found.append(command.reach)
    return tuple([reach for reach in found if not reach.complete])


def start_penetration(spec: GraspSpec) -> Array:
    """(k,) how far the object begins inside the hand's links, before these close [m], at each contact; 0 where it does
    not. Fingertips that touch alone, and links that joints could have closed so far in this posture, are squeezed.
    """
    mechanism: Any = spec.mechanism  # a hand's
    inside = overlap_depths(mechanism.stand_off[:, 2])
    if not mechanism.report.links or not inside.any():
        return np.zeros(len(inside))
    command = find_command(spec.effects)
    opened = command is not None and command.opened is not None  # from where links close until they touch
    still = tip_motions_by_joint(mechanism, spec.planar).overlap_reach(inside).share > _MAX_MISSED_SHARE
    return np.where(still | (opened & (inside > _MAX_CLOSING_OVERLAP)), inside, 0.0)


def start_link_depths(spec: GraspSpec) -> dict[str, float]:
    """The links that the object begins inside, the deepest first, and how deep [m], the whole link or its contacts."""
    mechanism: Any = spec.mechanism
    depths = dict[str, float]()
    for tip, depth in zip(mechanism.fingertips, start_penetration(spec).tolist(), strict=True):
        if depth > 0.0:
            link = mechanism.report.links[tip]
            depths[link] = max(depth, depths.get(link, 0.0))
    if depths:
        with suppress(URDFError):
            for one in find_penetrating_links(mechanism.posture, mechanism.target, ()):
                if one.link in depths:
                    depths[one.link] = max(one.depth, depths[one.link])
    return dict(sorted(depths.items(), key=lambda one: -one[1]))


# ----------------------------------------------------------------
# How hard a hand closes: the joint offset δq that its actuators can command, from a depth or a force at each tip.
#
# squeeze       n·J δq = s + gap            the smallest δq
# grip force    J δq = E r + d,  r_N = f    the r nearest to f n that joints can make: without pads δq = K⁻¹ Jᵀ n f
#
# A squeeze is the motion with which `close_on` closes, continued: the tips go deeper by s along the normals, and
# sideways as their joints take them. The tip of a two-joint finger moves in a plane. Where the normal leans out of that
# plane by θ, depth and normal force are reached all the same, with s tan θ or f tan θ sideways in the plane. d are the
# offsets that the fingers stand off by: a gap that is left, and the sag under their own weight.

# Directions in which the joints move the tips less than this share of their best are out of reach
MIN_REACH_SHARE = 1e-2
_MAX_SQUEEZE = 0.1  # [m] no hand squeezes deeper: what is more was not given in metres
_MAX_MISSED_SHARE = 0.5  # of an overlap: where joints miss more of it than that, they are not what made it
_MAX_CLOSING_OVERLAP = 2e-4  # [m] links that close until they touch overlap by less


BY_TIP = NumbersByName("fingertip", minimum=0.0)  # a squeeze, or grip forces
JOINT_OFFSETS = NumbersByName("joint", has_common=False)


def read_by_tip(argument: str, value: Any, names: Sequence[str] | None = None) -> Array:
    """(k,) ≥ 0 from a number, (k,), or a mapping by fingertip (others: 0). Raises InputError, UnknownName."""
    values = BY_TIP.read(argument, value, names)
    if argument == "squeeze" and (deepest := float(values.max(initial=0.0))) > _MAX_SQUEEZE:
        raise InputError(argument, f"depths in metres, up to {_MAX_SQUEEZE:g}", f"{deepest:g}: are these millimetres?")
    return values


def overlap_depths(gaps: Array) -> Array:
    """(k,) how far fingertips with these gaps (k,) are inside the object [m]; 0 for those that just touch."""
    return read_only(np.where(gaps < -OVERLAP_TOLERANCE, -gaps, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class TipMotions:
    """What commands of the actuators do to k fingertips. names : (k,). jacobian : (3k, nv) of the contact points,
    contact axes [m/rad]. commands : (nv, m) joint motions that can be commanded, in orthonormal columns.
    """

    names: tuple[str, ...]
    jacobian: Array
    commands: Array

    @classmethod
    def from_jacobian(cls, names: tuple[str, ...], jacobian: Array, commands: Array, planar: bool) -> TipMotions:
        """Contacts after the fingers' are left out, and so are motions across the plane of a planar scene."""
        J = jacobian[: 3 * len(names)]
        if planar:
            J = J.copy()
            J[1::3] = 0.0
        return cls(names, J, commands)

    def command_for_depth(self, depth: Array) -> Array:
        """(nv,) the smallest δq that takes the tips deeper by depth (k,) along the normals, or nearest to that; for
        columns (k, m), columns.
        """
        return self._smallest_command(depth, slice(2, None, 3))

    def tip_displacements(self, command: Array) -> Array:
        """(k, 3) how far each fingertip moves [m] under a command δq (nv,): J δq."""
        return np.asarray(self.jacobian @ command).reshape(-1, 3)

    def command_for_motion(self, motions: Array) -> Array:
        """(nv,) the smallest δq with J δq = motion (3k,), or nearest to it; for columns (3k, m), columns."""
        return self._smallest_command(motions, slice(None))

    def _smallest_command(self, wanted: Array, components: slice) -> Array:
        moves = self.jacobian @ self.commands
        least = MIN_REACH_SHARE * float(np.sqrt((moves * moves).sum(axis=1).max(initial=0.0)))  # slower is out of reach
        return np.asarray(self.commands @ _least_norm_solution(moves[components], wanted, least))

    def unreachable_motion(self, motions: Array) -> Array:
        """The part of motions (3k,), or of each column (3k, m), that no command makes."""
        return np.asarray(motions - self.jacobian @ self.command_for_motion(motions))

    def preload_reach(self, motion: Array) -> CommandReach:
        """Of a motion (k, 3) of the tips that was given, not commanded."""
        beyond = self.unreachable_motion(motion.reshape(-1)).reshape(-1, 3)
        return self.reach("preload", np.linalg.norm(motion, axis=1), np.linalg.norm(beyond, axis=1))

    def overlap_reach(self, inside: Array) -> CommandReach:
        """Of tips that overlap the object by (k,) [m] in the posture."""
        left = abs(inside - self.tip_displacements(self.command_for_depth(inside))[:, 2])
        return self.reach("overlap", inside, left)

    def reach(self, what: str, asked: Array, missing: Array, sideways: Array | None = None) -> CommandReach:
        """What is out of reach, (k,) each; sideways None : of what is carried all the same, a preload or an overlap."""
        beside, carried = (np.zeros(len(asked)), True) if sideways is None else (sideways, False)
        return CommandReach(what, self.names, read_only(asked), read_only(missing), read_only(beside), carried)


def squeeze_command(tips: TipMotions, depth: Array, gaps: Array) -> tuple[Array, CommandReach]:
    """δq (nv,) that leaves the tips depth (k,) deep where they stand off by gaps (k,), both [m]; and its reach."""
    wanted = depth + gaps
    command, from_touching = tips.command_for_depth(np.column_stack([wanted, depth])).T
    missing = abs(wanted - tips.tip_displacements(command)[:, 2])
    sideways = np.linalg.norm(tips.tip_displacements(from_touching)[:, :2], axis=1)
    return command, tips.reach("squeeze", depth, missing, sideways)


class RigidFinger(InputError):
    """A finger that is asked for a force in a posture in which nothing lets it give way along its normal."""


def grip_command(
    tips: TipMotions, force: Array, flexibility: Array, root: Array, stand_off: Array
) -> tuple[Array, CommandReach]:
    """δq (nv,) with which the tips press with normal forces (k,) [N] on an object that stays where it is and does not
    slip; and its reach. flexibility : (3k, 3k) E of the fingers. root : A of the joints' compliance K⁻¹ = A Aᵀ.
    stand_off : (3k,) d. Raises RigidFinger.
    """
    E, size = flexibility, float(abs(flexibility).max(initial=0.0))
    for name, asked, give in zip(tips.names, force, np.diagonal(E)[2::3], strict=True):
        if asked > 0.0 and give <= 1e-12 * size:
            expected = "a finger that gives way along its normal, through its joints or its pad"
            raise RigidFinger("grip_force", expected, f"{name}, which is rigid there")
    pressed = np.outer(force, (0.0, 0.0, 1.0)).reshape(-1)
    # Friction takes up what E asks for beyond the joints' motions
    along = np.ones(len(E), dtype=bool)
    along[2::3] = False
    beyond = tips.unreachable_motion(E)
    bound = MIN_REACH_SHARE * float(np.linalg.norm(beyond, 2))
    r = pressed.copy()
    if bound > 1e-12 * size:
        r[along] = -_least_norm_solution(beyond[:, along], beyond @ pressed, bound)
    wanted = E @ r + stand_off
    command = tips.commands @ (tips.commands.T @ (root @ (root.T @ (tips.jacobian.T @ r))))
    command = command + tips.command_for_motion(wanted - tips.jacobian @ command)
    left = tips.jacobian @ command - wanted
    reached = (r + np.linalg.pinv(E, rcond=1e-9, hermitian=True) @ left).reshape(-1, 3)
    sideways = np.linalg.norm(reached[:, :2], axis=1)
    return command, tips.reach("grip force", force, abs(force - reached[:, 2]), sideways)


def _least_norm_solution(A: Array, b: Array, bound: float) -> Array:
    """The smallest x that makes A x nearest to b, without directions whose singular value is at most `bound`."""
    U, s, V = np.linalg.svd(A, full_matrices=False)
    kept = s > bound
    inverse = V[kept].T / s[kept]
    return np.asarray(inverse @ (U[:, kept].T @ b))


# ----------------------------------------------------------------
# What users pass to say how hard a hand closes, and the joint offset that it becomes.


def read_joint_offset(value: Any, joints: Sequence[str]) -> Array:
    """(nv,) δq [rad, m] from numbers or a mapping by joint name (others 0); None: 0. Raises InputError, UnknownName."""
    if value is None:
        return read_only(np.zeros(len(joints)))
    return JOINT_OFFSETS.read("joint_offset", value, joints)


COMMAND_ARGUMENTS = ("squeeze", "grip_force", "joint_offset", "closing_torque")


def apply_command(spec: GraspSpec, squeeze: Any, grip_force: Any, joint_offset: Any) -> GraspSpec:
    """The grasp with the command that one of the three says, in place of an earlier one. Raises InputError."""
    if squeeze is None and grip_force is None and joint_offset is None:
        return spec
    mechanism: Any = spec.mechanism  # a hand's
    old = find_command(spec.effects)
    spec = spec.replace(effects=tuple([e for e in spec.effects if not isinstance(e, JointOffset)]))
    if joint_offset is not None:
        effect = JointOffset(read_joint_offset(joint_offset, mechanism.names))
    else:
        name, value = ("grip_force", grip_force) if squeeze is None else ("squeeze", squeeze)
        sizes = read_by_tip(name, expand_link_values(name, value, mechanism.posture.hand), mechanism.fingertips)
        tips = tip_motions(mechanism, spec.planar)
        if squeeze is None:
            E, stand_off = _finger_compliance(spec, mechanism)
            command, reach = grip_command(tips, sizes, E, mechanism.compliance_factor, stand_off)
        else:
            command, reach = squeeze_command(tips, sizes, mechanism.stand_off[:, 2])
        effect = JointOffset(read_only(command), reach if sizes.any() else None)
    if old is not None:  # another command in the same closing
        effect = replace(effect, opened=old.opened, keeps=old.keeps)
    says_something = effect.command.any() or effect.reach is not None
    return spec.replace(effects=(*spec.effects, effect)) if says_something else spec


def apply_grip_force(spec: GraspSpec, force: Array) -> GraspSpec:
    """The grasp with normal forces (k,) [N] commanded at the fingertips, in place of its own command."""
    return apply_command(spec, None, np.asarray(force), None)


def _finger_compliance(spec: GraspSpec, mechanism: Any) -> tuple[Array, Array]:
    """(3k, 3k) E with what effects add whatever the forces; (3k,) how far they stand off, sag included."""
    c = 3 * spec.of_hand
    E, d = spec.flexibility[:c, :c].copy(), mechanism.stand_off.reshape(-1).copy()
    for e in spec.effects:
        if not e.depends_on_forces and (more := e.added_flexibility(spec, ())) is not None:
            E += more[:c, :c]
        if (shift := e.added_offset(spec, ())) is not None:
            d += shift[:c]
    if spec.planar:
        E[1::3] = E[:, 1::3] = d[1::3] = 0.0
    return E, d
