"""What users pass to say how hard a hand closes, and the joint offset that it becomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, per_name, read_only
from handlcp.errors import InputError
from handlcp.grasp.effects.joint_offset import JointOffset, command_of
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.sites.sited import by_site
from handlcp.hand.squeeze import by_tip, gripping, motions_of, squeezing


def read_joint_offset(value: Any, joints: Sequence[str]) -> Array:
    """(nv,) δq [rad, m] from numbers or a mapping by joint name (others 0); None: 0. Raises InputError, UnknownName."""
    if value is None:
        return read_only(np.zeros(len(joints)))
    if isinstance(value, Mapping):
        named = per_name("joint_offset", value, joints, "a joint")
        given = {joint: number(f"joint_offset[{joint!r}]", v) for joint, v in named.items()}
        return read_only(np.array([given.get(joint, 0.0) for joint in joints]))
    return array("joint_offset", value, (len(joints),))


COMMANDS = ("squeeze", "grip_force", "joint_offset", "closing_torque")


def one_command(**said: Any) -> None:
    """Raises InputError for more than one."""
    given = [name for name, value in said.items() if value is not None]
    if len(given) > 1:
        expected = f"at most one of {', '.join(COMMANDS[:-1])} and {COMMANDS[-1]}"
        raise InputError(given[1], expected, f"{' and '.join(given)}")


def commanded(spec: GraspSpec, squeeze: Any, grip_force: Any, joint_offset: Any) -> GraspSpec:
    """The grasp of a hand with the command that one of the three says, in place of an earlier one; None of them: as it
    is. Raises InputError, UnknownName.
    """
    if squeeze is None and grip_force is None and joint_offset is None:
        return spec
    mechanism: Any = spec.mechanism  # a hand's
    old = command_of(spec.effects)
    spec = spec.replace(effects=tuple([e for e in spec.effects if not isinstance(e, JointOffset)]))
    if joint_offset is not None:
        effect = JointOffset(read_joint_offset(joint_offset, mechanism.names))
    elif squeeze is not None:
        depth = by_tip("squeeze", by_site("squeeze", squeeze, mechanism.posture.hand), mechanism.fingertips)
        command, reach = squeezing(motions_of(mechanism, spec.planar), depth, mechanism.stand_off[:, 2])
        effect = JointOffset(read_only(command), reach if depth.any() else None)
    else:
        force = by_tip("grip_force", by_site("grip_force", grip_force, mechanism.posture.hand), mechanism.fingertips)
        E, stand_off = _of_fingers(spec, mechanism)
        command, reach = gripping(motions_of(mechanism, spec.planar), force, E, mechanism.root, stand_off)
        effect = JointOffset(read_only(command), reach if force.any() else None)
    if old is not None:  # another command in the same closing
        effect = replace(effect, opened=old.opened, keeps=old.keeps)
    says_something = effect.command.any() or effect.reach is not None
    return spec.replace(effects=(*spec.effects, effect)) if says_something else spec


def gripped(spec: GraspSpec, force: Array) -> GraspSpec:
    """The grasp with normal forces (k,) [N] commanded at the fingertips, in place of its own command."""
    return commanded(spec, None, np.asarray(force), None)


def _of_fingers(spec: GraspSpec, mechanism: Any) -> tuple[Array, Array]:
    """(3k, 3k) flexibility of the fingers with what effects add to it, as far as forces don't change that; and (3k,)
    how far they stand off, gaps and the sag under their weight together.
    """
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
