"""`write_joint_motions`: the kinematics of a tree of joints, compiled: placements, world Jacobian, torque of gravity.

A joint i is carried by its parent λ(i), whose number is smaller. With its placement (R°, p°) there, its axis a and its
position q_i

    R_i = R_λ R° exp(a q_i), p_i = p_λ + R_λ p°            where it turns,
    R_i = R_λ R°,            p_i = p_λ + R_λ (p° + R° a q_i)  where it slides;

its column of the world Jacobian is (p_i × R_i a; R_i a), or (R_i a; 0): the motion of the body's point at the world's
origin. Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.kinematics.rigid_motion import rotate_vector
from handlcp.lcp.kernels.dense import kernel

WORLD = -1  # the parent of a joint that no other carries


class JointTree(NamedTuple):
    """Joints of one degree of freedom, each carried by one with a smaller number.

    parents (joints,) : who carries each, or WORLD. rotations (joints, 3, 3), origins (joints, 3) : their frames in
    those of their parents at zero [m]. axes (joints, 3) : unit vectors in these frames. slides (joints,) : 1 for
    prismatic joints, 0 for others. coupling (joints, nv), offset (joints,) : q_full = C q + offset of the independent
    joints; coupling is empty where they are all of them. masses (joints,) [kg], centres (joints, 3) [m] : of the
    bodies that the joints carry, in their frames.
    """

    parents: Ints
    rotations: Array
    origins: Array
    axes: Array
    slides: Ints
    coupling: Array
    offset: Array
    masses: Array
    centres: Array


class TipPlacements(NamedTuple):
    """Frames that joints carry. carriers (k,) : which joint, or WORLD. rotations (k, 3, 3), origins (k, 3) : in the
    joint's frame [m].
    """

    carriers: Ints
    rotations: Array
    origins: Array


@kernel
def write_joint_motions(tree: JointTree, q: Array, R: Array, p: Array, columns: Array) -> None:
    """Write the placements R (joints, 3, 3), p (joints, 3) of the joints' frames with independent joints at q (nv,),
    and the rows (joints, 6) of the world Jacobian, the linear part of the world's origin first.
    """
    joints, coupled = len(tree.parents), len(tree.coupling) > 0
    turn, axis, at = np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(joints):
        value = 0.0 if coupled else q[i]
        if coupled:
            value = tree.offset[i]
            for j in range(len(q)):
                value += tree.coupling[i, j] * q[j]
        slides, carrier = tree.slides[i] != 0, tree.parents[i]
        for a in range(3):
            at[a] = tree.origins[i, a]
            if slides:
                for b in range(3):
                    at[a] += tree.rotations[i, a, b] * tree.axes[i, b] * value
        if slides:
            turn[:] = tree.rotations[i]
        else:
            _turn_about(tree.rotations[i], tree.axes[i], value, turn)
        compose_placement(R, p, carrier, turn, at, R[i], p[i])
        rotate_vector(R[i], tree.axes[i], axis)
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            columns[i, a] = axis[a] if slides else p[i, b] * axis[c] - p[i, c] * axis[b]
            columns[i, 3 + a] = 0.0 if slides else axis[a]


@kernel
def compose_placement(R: Array, p: Array, carrier: int, turn: Array, at: Array, out: Array, place: Array) -> None:
    """Write rotation (3, 3) and origin (3,) of a frame in the world; turn (3, 3), at (3,) : in the frame of a joint,
    or of the world.
    """
    if carrier < 0:
        out[:], place[:] = turn, at
        return
    for a in range(3):
        place[a] = p[carrier, a]
        for b in range(3):
            place[a] += R[carrier, a, b] * at[b]
            out[a, b] = 0.0
            for c in range(3):
                out[a, b] += R[carrier, a, c] * turn[c, b]


@kernel
def _turn_about(R: Array, axis: Array, angle: float, out: Array) -> None:
    """Write R exp(axis × angle), by Rodrigues' formula; axis (3,) : a unit vector."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z, d = axis[0], axis[1], axis[2], 1.0 - c
    for a in range(3):
        u, v, w = R[a, 0], R[a, 1], R[a, 2]
        along = d * (u * x + v * y + w * z)
        out[a, 0] = c * u + along * x + s * (v * z - w * y)
        out[a, 1] = c * v + along * y + s * (w * x - u * z)
        out[a, 2] = c * w + along * z + s * (u * y - v * x)


@kernel
def write_gravity_torque(tree: JointTree, R: Array, p: Array, columns: Array, gravity: Array, torque: Array) -> None:
    """Write the torque g(q) (nv,) of the independent joints that holds the bodies' weight [N·m]; R, p, columns as
    `write_joint_motions` wrote them. gravity (3,) [m/s²], world axes.
    """
    joints, coupled = len(tree.parents), len(tree.coupling) > 0
    centre = np.empty(3)
    torque[:] = 0.0
    for i in range(joints):
        rotate_vector(R[i], tree.centres[i], centre)
        for a in range(3):
            centre[a] += p[i, a]
        j = i
        while j >= 0:
            power = 0.0
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                moves = columns[j, a] + columns[j, 3 + b] * centre[c] - columns[j, 3 + c] * centre[b]
                power -= tree.masses[i] * gravity[a] * moves
            if coupled:
                for e in range(len(torque)):
                    torque[e] += tree.coupling[j, e] * power
            else:
                torque[j] += power
            j = tree.parents[j]


@kernel
def contact_jacobian(J: Array, support: Array, coupling: Array, positions: Array, frames: Array) -> Array:
    """(3n, nv) velocity of the contact points in contact axes: Rᵀ (v + ω × p), joint by joint.

    J (joints, 6) : rows of the world Jacobian, linear part (of the world's origin) first. support (n, joints) : 1 where
    a joint moves a finger. coupling (joints, nv) : of the independent joints; empty where they are all of them.
    positions (n, 3), frames (n, 3, 3) : of the contacts.
    """
    n, joints = support.shape
    full = np.zeros((3 * n, joints))
    v = np.empty(3)
    for i in range(n):
        x, y, z = positions[i, 0], positions[i, 1], positions[i, 2]
        for j in range(joints):
            if support[i, j] != 0.0:
                v[0] = J[j, 0] + J[j, 4] * z - J[j, 5] * y
                v[1] = J[j, 1] + J[j, 5] * x - J[j, 3] * z
                v[2] = J[j, 2] + J[j, 3] * y - J[j, 4] * x
                for k in range(3):
                    full[3 * i + k, j] = frames[i, 0, k] * v[0] + frames[i, 1, k] * v[1] + frames[i, 2, k] * v[2]
    return full if len(coupling) == 0 else np.dot(full, coupling)
