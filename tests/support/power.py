"""Random power grasps of a hand with 16 joints.

Four fingers with four joints each close around a cylinder, a ball or a box; contacts lie on all phalanges and on the
palm, which no joint moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import handlcp as hl
from handlcp.check import Array

FINGERS, JOINTS = 4, 4
_FLEXION = np.deg2rad((-60.0, 5.0, 60.0, 110.0))  # where around the object phalanges begin, and the last one ends
WEAK, STRONG = 0.15, 0.6  # friction


@dataclass(frozen=True)
class PowerGrasp:
    """Arrays of a grasp with n contacts, SI: jacobian (3n, 16) in contact axes, stiffness (16,), pads (n,) [m/N],
    command (16,) of the joints beyond their posture, wrench (6,) about the world's origin.
    """

    contacts: tuple[hl.Contact, ...]
    jacobian: Array
    stiffness: Array
    pads: Array
    command: Array
    wrench: Array

    @property
    def offset(self):
        """(n, 3) of the object relative to the hand: the closing command."""
        return -(self.jacobian @ self.command).reshape(-1, 3)

    @property
    def flexibility(self):
        """(3n, 3n) E as one matrix."""
        return (self.jacobian / self.stiffness) @ self.jacobian.T + np.diag(np.repeat(self.pads, 3))

    def dense(self):
        """The grasp, with E as one matrix."""
        return hl.Grasp(self.contacts, self.wrench, flexibility=self.flexibility, offset=self.offset)

    def as_matrix(self):
        """The same, solved with the matrix even where a factor could be found in it."""
        grasp = self.dense()
        grasp.scene.__dict__["factor"] = None
        return grasp

    def factored(self):
        """The same grasp, with E as a factor."""
        pads = self.pads[:, None, None] * np.eye(3)
        E = hl.Flexibility(self.jacobian, np.diag(1.0 / np.sqrt(self.stiffness)), pads)
        return hl.Grasp(self.contacts, self.wrench, flexibility=E, offset=self.offset)


def factor_of(E):
    """(J, A, P) that a grasp with this E (3n, 3n) finds in it; None: none."""
    n = len(E) // 3
    ring = [(np.cos(t), np.sin(t), 0.0) for t in np.linspace(0.0, 6.0, n)]
    grasp = hl.Grasp([hl.Contact(p, (-p[0], -p[1], 0.0), 0.5) for p in ring], flexibility=E)
    return None if grasp.scene.factor is None else grasp.scene.factor.factor


def power_grasp(n, seed, friction=None, loaded=True):
    """A random one with n contacts; friction None: 0.15 or 0.6. loaded : by more than its weight."""
    rng = np.random.default_rng((n, seed))
    shape, size = rng.integers(3), rng.uniform(0.028, 0.045)
    mu = float(rng.choice((WEAK, STRONG))) if friction is None else friction
    palm = max(1, int(rng.binomial(n - FINGERS, 0.15)))
    fingers = (*np.arange(FINGERS), *rng.integers(0, FINGERS, n - palm - FINGERS), *[-1] * palm)
    contacts, rows = [], []
    places = np.array([-0.026, 0.0, 0.026, -0.01])  # of the fingers along the object; the last is the thumb
    for finger in fingers:
        side = -1.0 if finger == FINGERS - 1 else 1.0
        if finger < 0:
            phalanx, angle, along = -1, rng.uniform(-2.2, -0.95), rng.uniform(-0.03, 0.03)
        else:
            # One contact a finger of a grasp with few is on its last phalanx
            phalanx = 2 if n <= 2 * FINGERS else int(rng.integers(3))
            angle = rng.uniform(_FLEXION[phalanx] + 0.15, _FLEXION[phalanx + 1] - 0.1)
            along = places[finger] + rng.uniform(-0.006, 0.006)
        point, inward = _surface(int(shape), size, angle, along)
        if side < 0.0:
            point, inward = point * (-1, 1, 1), inward * (-1, 1, 1)
        contact = hl.Contact(tuple(point), tuple(inward), mu)
        contacts.append(contact)
        rows.append(contact.rotation.T @ _velocity(int(finger), phalanx, point, size, side, places))
    torque = np.zeros((FINGERS, JOINTS))
    torque[:, 1:] = rng.uniform(0.15, 0.5, (FINGERS, 1)) * np.array((1.0, 0.7, 0.4)) * rng.uniform(0.8, 1.2, (4, 3))
    torque[-1] *= 1.5
    stiffness = 2.0 * np.exp(0.3 * rng.normal(size=FINGERS * JOINTS))
    down = rng.normal(size=3)
    weight = 9.81 * rng.uniform(0.1, 0.6) * down / np.linalg.norm(down)
    load = rng.normal(size=6) * (1.0, 1.0, 1.0, 0.03, 0.03, 0.03)
    load *= 10.0 ** rng.uniform(-0.5, 1.3) if loaded else 0.0
    return PowerGrasp(
        tuple(contacts), np.concatenate(rows), stiffness, 10.0 ** rng.uniform(-5.0, -4.0, n),
        torque.ravel() / stiffness, np.append(weight, np.zeros(3)) + load,
    )  # fmt: skip


def _surface(shape, size, angle, along):
    """(point, normal into the object) at an angle about its axis y: of a cylinder, a ball or a box."""
    x, z = np.cos(angle), np.sin(angle)
    if shape == 0:
        return np.array((size * x, along, size * z)), np.array((-x, 0.0, -z))
    if shape == 1:
        ball = 1.25 * size
        point = np.array((x * np.sqrt(ball**2 - along**2), along, z * np.sqrt(ball**2 - along**2)))
        return point, -point / ball
    far = size / max(abs(x), abs(z))
    normal = (-np.sign(x), 0.0, 0.0) if abs(x) > abs(z) else (0.0, 0.0, -np.sign(z))
    return np.array((far * x, along, far * z)), np.array(normal)


def _velocity(finger, phalanx, point, size, side, places):
    """(3, 16) of a point on a phalanx, world axes: joint 0 swings the finger sideways, 1 to 3 bend it."""
    J = np.zeros((3, FINGERS * JOINTS))
    for k in range(1 + phalanx + 1 if finger >= 0 else 0):
        angle = _FLEXION[max(k - 1, 0)]
        radius = 1.2 * size + 0.01
        joint = np.array((side * radius * np.cos(angle), places[finger], radius * np.sin(angle)))
        axis = np.array((0.0, 0.0, 1.0)) if k == 0 else np.array((0.0, -side, 0.0))
        J[:, JOINTS * finger + k] = np.cross(axis, point - joint)
    return J
