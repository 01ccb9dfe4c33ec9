"""The numbers of a step, and where its answer leads, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.lcp.kernels.dense import kernel


class Laws(NamedTuple):
    """What stays the same in all steps. soft (k,) : contacts that bear a moment. scale (c,) : as in `Scene`, or ones.
    torsion (k,) : how far the pads of soft contacts turn [rad/(N·m)]. freedom (dof, 6) : as in `Scene`.
    joined : whether joints turn soft fingertips. sags : 1 where joints give way to the fingers' weight, or 0.
    """

    soft: Ints
    scale: Array
    torsion: Array
    freedom: Array
    joined: bool
    sags: float


class Elastic(NamedTuple):
    """What gives way at the contacts of an iterate, contact axes: P (3n, 3n) all but the joints, J (3n, nv), turning
    (n, nv) of the fingertips about the normals, root (nv, m) of the joints' compliance, gravity (nv,) torque that holds
    the fingers' weight.
    """

    P: Array
    J: Array
    turning: Array
    root: Array
    gravity: Array


class Loads(NamedTuple):
    """Of a step. base (n, 3) : slip since the step began and gap, with what preloads put between. spin (n,) : turns of
    the object on the fingertips since the step began. give (n, 3) : of pads, world axes; turn (n,) : of soft pads.
    command (nv,) : from where the joints stand to where they are commanded. load (6,) : about the reference (3,), which
    moves with the object; weight (3,) [N] at the centre of mass (3,).
    """

    base: Array
    spin: Array
    give: Array
    turn: Array
    command: Array
    load: Array
    reference: Array
    weight: Array
    mass_at: Array

    @property
    def force(self) -> Array:
        """(3,) on the object."""
        return np.asarray(self.load[:3] + self.weight)

    @property
    def moment(self) -> Array:
        """(3,) about the world's origin."""
        about: Array = cross_rows(self.reference, self.load[:3]) + cross_rows(self.mass_at, self.weight)
        return self.load[3:] + about


class Read(NamedTuple):
    """An answer in contact axes: forces, motion (n, 3), torsion, spin (n,); torque and deflection (nv,) of joints."""

    forces: Array
    motion: Array
    torsion: Array
    spin: Array
    torque: Array
    deflection: Array


def flexibility_of(el: Elastic) -> Array:
    """(3n, 3n) E = J K⁻¹ Jᵀ + P."""
    return np.asarray(joint_flexibility(el.J, el.root) + el.P)


@kernel
def end_of_step(
    motion: Array, spin: Array, change: Array, twist: Array, centre: Array, positions: Array, frames: Array, J: Array,
    turning: Array, base: Array, give: Array, turn: Array, slipped: Array, soft: Ints, radius: Array,
) -> tuple[Array, Array, Array, float]:  # fmt: skip
    """(give, turn, slip_memory, miss): how far pads are pushed away (n, 3) [m], world axes, and turned (n,) [rad] at
    the end; the slip between the iterate and the end (n, 3); and how far the end is from the iterate, as a share of
    radius (n,) and in radians.

    motion, spin : of the answer, as in `Read`. change (nv,) : of the joints from the iterate to the end. twist (6,) :
    of the object about centre (3,). positions, frames, J, turning, give, turn : of the iterate. base, slipped : of the
    step.
    """
    n, nv = len(positions), len(change)
    give, turn, slip_memory = give.copy(), turn.copy(), np.zeros((n, 3))
    omega = twist[3:]
    miss = np.sqrt(omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2)
    u, tip, own = np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        x, y, z = positions[i, 0] - centre[0], positions[i, 1] - centre[1], positions[i, 2] - centre[2]
        u[0] = twist[0] + omega[1] * z - omega[2] * y
        u[1] = twist[1] + omega[2] * x - omega[0] * z
        u[2] = twist[2] + omega[0] * y - omega[1] * x
        far, near = 0.0, 0.0
        for a in range(3):
            moves, tip[a] = 0.0, 0.0
            for b in range(3):
                moves += frames[i, b, a] * u[b]
            for j in range(nv):
                tip[a] += J[3 * i + a, j] * change[j]
            relative = motion[i, a] - base[i, a]
            own[a] = moves - tip[a] - relative  # the pad's share
            if a < 2:
                slip_memory[i, a] = relative
            far += moves * moves
            near += (tip[a] + own[a]) ** 2
        miss = max(miss, np.sqrt(max(far, near)) / radius[i])
        for b in range(3):
            for a in range(3):
                give[i, b] += frames[i, b, a] * own[a]
    for a in range(len(soft)):
        i = soft[a]
        slip_memory[i, 2] = spin[i] - slipped[i, 2]
        turn[i] -= slip_memory[i, 2]
        for b in range(3):
            turn[i] += frames[i, b, 2] * omega[b]
        for j in range(nv):
            turn[i] -= turning[i, j] * change[j]
    return give, turn, slip_memory, miss
