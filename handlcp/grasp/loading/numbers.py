"""The arithmetic of a step, compiled: a row of numbers for the compiled solve, what its answer says, where it leads.

The row is the one that `build` and `pack` would make of the step's grasp (`step_grasp`), without making it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.compile import kernel

__all__ = ["Elastic", "Laws", "Loads", "Read", "end_of_step", "read_answer", "write_row"]


class Laws(NamedTuple):
    """What stays the same in all steps. soft (k,) : contacts that bear a moment. scale (c,) : as in `Scene`, or ones.
    torsion (k,) : how far the pads of soft contacts turn [rad/(N·m)]. limits (n,), freedom (dof, 6) : as in `Scene`.
    joined : whether joints turn soft fingertips. sags : 1 where joints give way to the fingers' weight, or 0.
    """

    soft: Ints
    scale: Array
    torsion: Array
    limits: Array
    freedom: Array
    joined: bool
    sags: float


class Elastic(NamedTuple):
    """What gives way at the contacts of a look, contact axes: E (3n, 3n), J (3n, nv), turning (n, nv) of the fingertips
    about the normals, root (nv, m) of the joints' compliance, gravity (nv,) torque that holds the fingers' weight.
    """

    E: Array
    J: Array
    turning: Array
    root: Array
    gravity: Array


class Loads(NamedTuple):
    """Of a step. base (n, 3) : as in `StepGrasp.base`. spin (n,) : turns of the object on the fingertips since the step
    began, and of the pads. give (n, 3) : of pads, world axes. told (nv,) : from where the joints stand to where they
    are commanded. force (3,), moment (3,) : on the object, about the world's origin.
    """

    base: Array
    spin: Array
    give: Array
    told: Array
    force: Array
    moment: Array


class Read(NamedTuple):
    """An answer in contact axes: forces, motion (n, 3), torsion, spin (n,); torque and deflection (nv,) of joints."""

    forces: Array
    motion: Array
    torsion: Array
    spin: Array
    torque: Array
    deflection: Array


@kernel
def write_row(row: Array, positions: Array, frames: Array, el: Elastic, loads: Loads, laws: Laws) -> None:
    """Write the numbers of a step's scene into a row, as `solve_scenes` reads them."""
    n, k, nv = len(positions), len(laws.soft), el.J.shape[1]
    m, c, s = 3 * n, 3 * n + k, laws.scale
    at = 12 * n
    for i in range(n):
        for a in range(3):
            row[3 * i + a] = positions[i, a]
            for b in range(3):
                row[m + 9 * i + 3 * a + b] = frames[i, a, b] * s[3 * i + b]
    for i in range(m):
        for j in range(m):
            row[at + i * c + j] = el.E[i, j] * s[i] * s[j]
    _soft_rows(row, at, m, el, laws)
    at += c * c
    told = loads.told - laws.sags * np.dot(el.root, np.dot(el.gravity, el.root))
    for i in range(n):
        for a in range(3):
            d = loads.base[i, a]
            for b in range(3):
                d += frames[i, b, a] * loads.give[i, b]
            for j in range(nv):
                d -= el.J[3 * i + a, j] * told[j]
            row[at + 3 * i + a] = d * s[3 * i + a]
    for a in range(k):
        d = loads.spin[laws.soft[a]]
        for j in range(nv):
            d -= el.turning[laws.soft[a], j] * told[j]
        row[at + m + a] = d * s[m + a]
    at += c
    row[at : at + c] = 0.0
    at += c
    for b in range(3):
        for a in range(k):
            row[at + b * k + a] = frames[laws.soft[a], b, 2] * s[m + a]
    at += 3 * k
    for b in range(3):
        row[at + b] = loads.force[b]
        row[at + 3 + b] = loads.moment[b]
    at += 6
    for a in range(len(laws.freedom)):
        for b in range(6):
            row[at + 6 * a + b] = laws.freedom[a, b]
    row[at + 6 * len(laws.freedom) :] = laws.limits


@kernel
def _soft_rows(row: Array, at: int, m: int, el: Elastic, laws: Laws) -> None:
    """The flexibility between turns of soft fingertips, and between these and the contact points."""
    k, s = len(laws.soft), laws.scale
    c = m + k
    for a in range(k):
        for j in range(c):
            row[at + (m + a) * c + j] = row[at + j * c + m + a] = 0.0
    if k > 0 and laws.joined:
        C = np.dot(el.root, el.root.T)
        for a in range(k):
            turned = np.dot(el.turning[laws.soft[a]], C)
            for j in range(m):
                x = np.dot(turned, el.J[j]) * s[j] * s[m + a]
                row[at + (m + a) * c + j] = row[at + j * c + m + a] = x
            for b in range(k):
                row[at + (m + a) * c + m + b] = np.dot(turned, el.turning[laws.soft[b]]) * s[m + a] * s[m + b]
    for a in range(k):
        row[at + (m + a) * c + m + a] += laws.torsion[a] * s[m + a] * s[m + a]


@kernel
def read_answer(
    components: Array, motion: Array, el: Elastic, laws: Laws
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """The fields of `Read`, from forces and motions (c,) in the coordinates of the friction laws. (A plain tuple: to
    make a named one, compiled code loads its class anew in every call.)
    """
    n, k, nv = len(el.turning), len(laws.soft), el.J.shape[1]
    forces, moved = np.empty((n, 3)), np.empty((n, 3))
    torsion, spin, torque = np.zeros(n), np.zeros(n), np.zeros(nv)
    for i in range(n):
        for a in range(3):
            j = 3 * i + a
            forces[i, a] = components[j] * laws.scale[j]
            moved[i, a] = motion[j] / laws.scale[j]
            for b in range(nv):
                torque[b] += forces[i, a] * el.J[j, b]
    for a in range(k):
        i, j = laws.soft[a], 3 * n + a
        torsion[i] = components[j] * laws.scale[j]
        spin[i] = motion[j] / laws.scale[j]
        for b in range(nv):
            torque[b] += torsion[i] * el.turning[i, b]
    deflection = np.dot(el.root, np.dot(torque + laws.sags * el.gravity, el.root))
    return forces, moved, torsion, spin, torque + el.gravity, deflection


@kernel
def end_of_step(
    motion: Array, spin: Array, change: Array, twist: Array, centre: Array, positions: Array, frames: Array, J: Array,
    turning: Array, base: Array, give: Array, turn: Array, slipped: Array, soft: Ints, radius: Array,
) -> tuple[Array, Array, Array, float]:  # fmt: skip
    """(give, turn, carry, miss): how far pads are pushed away (n, 3) [m], world axes, and turned (n,) [rad] at the end;
    the slip between the look and the end (n, 3); and how far the end is from the look, as a share of radius (n,) and in
    radians.

    motion, spin : of the answer, as in `Read`. change (nv,) : of the joints from the look to the end. twist (6,) : of
    the object about centre (3,). positions, frames, J, turning, give, turn : of the look. base, slipped : of the step.
    """
    n, nv = len(positions), len(change)
    give, turn, carry = give.copy(), turn.copy(), np.zeros((n, 3))
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
                carry[i, a] = relative
            far += moves * moves
            near += (tip[a] + own[a]) ** 2
        miss = max(miss, np.sqrt(max(far, near)) / radius[i])
        for b in range(3):
            for a in range(3):
                give[i, b] += frames[i, b, a] * own[a]
    for a in range(len(soft)):
        i = soft[a]
        carry[i, 2] = spin[i] - slipped[i, 2]
        turn[i] -= carry[i, 2]
        for b in range(3):
            turn[i] += frames[i, b, 2] * omega[b]
        for j in range(nv):
            turn[i] -= turning[i, j] * change[j]
    return give, turn, carry, miss
