"""Fingertips brought to an object, and whether they can hold it there."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import scipy

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.geometry.contact_detection import Proximity, nearest_proximity
from handlcp.geometry.object import Object
from handlcp.grasp.model.contact import cross_rows
from handlcp.hand.find.clear import Links, Place, free_ranges, size_of_object
from handlcp.robot.fingertip import TipShape
from handlcp.robot.hand_model import HandModel, HandPosture

# ----------------------------------------------------------------
# Whether fingertips that touch can hold the object, and with which normal forces they should press.
#
# the smallest f with  w + G f = 0,   |f_t| ≤ s μ f_n,   f_n ≥ f_least
#
# at every contact, s < 1 so that friction keeps something in reserve. Cones become pyramids of eight edges, and the
# problem one of non-negative least squares (Lawson and Hanson, 1974).

RESERVE = 0.6  # s, the share of friction that is planned with
_EDGES = 2 * np.pi * np.arange(8) / 8
_HEAVY = 1e3  # of balance beside the size of the forces
_MISSED = 0.02  # of the forces: what may be missing from balance


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What the contacts are to hold. load (6,): the wrench on the object about its centre of mass, without turning with
    it [N, N·m]; mu (k,): coefficients of friction; levers (k,) [m]: of soft fingers, moment about
    the normal for each newton of friction; size [m] of the object; least [N] of the normal forces.
    """

    load: Array
    mu: Array
    levers: Array
    size: float
    least: float


def normal_forces(touch: Touch, centre: Array, asked: Asked) -> Array | None:
    """(k,) [N], one for each fingertip; None where none hold the object. centre (3,): its centre of mass [m]."""
    n = touch.normals
    x = np.eye(3)[np.argmin(abs(n), axis=1)]
    x = x - n * (n * x).sum(axis=1)[:, None]
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(n, x)
    turn = np.cos(_EDGES)[:, None, None] * x + np.sin(_EDGES)[:, None, None] * y
    edges = (n + RESERVE * asked.mu[:, None] * turn).transpose(1, 0, 2)  # (k, 8, 3)
    arms = (touch.positions - centre)[:, None, :]
    moments, pressed = np.cross(arms, edges), np.cross(arms[:, 0], n)
    torsion = RESERVE * (asked.mu * asked.levers)[:, None] * n
    edges = np.concatenate([edges, n[:, None], n[:, None]], axis=1)  # the last two bear moments about the normal
    moments = np.concatenate([moments, (pressed + torsion)[:, None], (pressed - torsion)[:, None]], axis=1)
    W = np.concatenate([edges, moments / asked.size], axis=2).reshape(-1, 6).T
    load = asked.load / np.repeat([1.0, asked.size], 3)
    base = np.full(W.shape[1], asked.least / edges.shape[1])
    A = np.vstack([_HEAVY * W, np.eye(W.shape[1])])
    try:
        more, _ = scipy.optimize.nnls(A, np.append(-_HEAVY * (load + W @ base), -base))
    except RuntimeError:
        return None  # too many iterations
    forces = base + more
    if float(np.linalg.norm(load + W @ forces)) > _MISSED * float(forces.sum()):
        return None
    return np.asarray(forces.reshape(len(n), -1).sum(axis=1))


# ----------------------------------------------------------------
# Fingertips brought to touch: joints and object move together, by the smallest steps that close all gaps.
#
# With the normal n from a fingertip into the object, at the point x of its surface, a step (δq, v, ω) changes the gap
# by
#
# δg = n · (v + ω × (x - o)) - n · J δq
#
# o the origin of the object's frame. Newton's steps solve g + δg = 0 for all fingers, and for the deepest point of each
# link that is inside the object. Each step is the smallest in units of 1 rad and of the object's size; joints that
# would leave their range stay at its end.

CLOSE = 5e-7  # [m] gaps that count as closed; distances between some shapes are no better
_STEPS, _LONGEST = 30, 0.3  # at most; of a step [rad], and as a share of the object's size
_IDLE = 5  # steps without progress after which it is given up
_DAMPING, _MUCH = 3e-3, 5e-3  # of the steps, where more than so much is left [m]
_NEAR = 1e-4  # [m] below this, distances are confirmed ones
_REQUEST = coal.DistanceRequest()
_REQUEST.enable_signed_distance = True


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """A place where all fingertips touch. positions, normals (k, 3): of the contacts, world axes, normals into the
    object. levers (k, nv): n · J, by how much the joints press the fingertips along them [m/rad].
    """

    place: Place
    positions: Array
    normals: Array
    levers: Array


def brought_together(
    hand: HandModel, tips: tuple[int, ...], links: Links, home: Object, place: Place, close: float = CLOSE
) -> Touch | None:  # fmt: skip
    """The nearest place at which the fingertips numbered `tips` touch and no link is inside; None: none is reached.

    home : the object with its frame at the origin. close : gaps [m] that count as closed.
    """
    lower, upper = free_ranges(hand)
    size = size_of_object(home)
    scale = np.append(np.minimum(1.0, upper - lower), [size, size, size, 1.0, 1.0, 1.0])
    exact, least, idle = False, np.inf, 0
    for _ in range(_STEPS):
        posture = HandPosture(hand, place.q.copy())
        try:
            near = [_near(posture, tip, home, place, exact) for tip in tips]
        except Unsupported:
            return None  # a distance that nobody can compute
        gaps = np.array([p.gap for p in near])
        if not (abs(gaps) < 10 * size).all():
            return None
        inside, deep, into, pushed = links.pushes(home, place)
        normals, points = np.array([p.normal for p in near]), np.array([p.tip_point for p in near])
        J = posture.jacobian_at(points, tips)
        levers = np.einsum("ix,ixj->ij", normals, J)
        if exact and abs(gaps).max() <= close and not len(inside):
            return Touch(place, np.array([p.position for p in near]), normals, levers)
        worst = float(abs(wanted := -np.append(gaps, inside)).max())
        least, idle = (worst, 0) if worst < 0.9 * least else (least, idle + 1)
        if idle > _IDLE:
            return None
        arms = np.array([p.position for p in near]) - place.position
        rows = np.hstack([-levers, normals, cross_rows(arms, normals)])
        more = np.hstack([-pushed, into, cross_rows(deep - place.position, into)])
        step = _smallest(np.vstack([rows, more]), wanted, scale, lower - place.q, upper - place.q)
        largest = float(abs(step / scale).max())
        place = place.moved(*np.split(step * min(1.0, _LONGEST / max(largest, 1e-300)), [hand.nv]))
        exact = bool(abs(gaps).max() < _NEAR)
    return None


def _smallest(rows: Array, wanted: Array, scale: Array, least: Array, most: Array) -> Array:
    """The smallest step x / scale with rows x = wanted, its first entries within least and most, or nearest to that.

    Wishes that cannot all be met make long steps. They are damped (Levenberg and Marquardt), less where little is left.
    """
    damping = _DAMPING * min(1.0, float(abs(wanted).max()) / _MUCH) + 1e-10
    x, free = np.zeros(len(scale)), np.ones(len(scale), dtype=bool)
    joints = len(least)
    x[:joints] = np.clip(0.0, least, most)  # a joint outside its range comes back
    for _ in range(joints):
        A = rows * np.where(free, scale, 0.0)
        square = A @ A.T
        square[np.diag_indices(len(square))] += damping * float(np.trace(square)) / len(square)
        y = A.T @ np.linalg.solve(square, wanted - rows[:, ~free] @ x[~free])
        x = np.where(free, scale * y, x)
        out = free[:joints] & ((x[:joints] < least) | (x[:joints] > most))
        if not out.any():
            break
        free[:joints] &= ~out
        x[:joints] = np.clip(x[:joints], least, most)
    return x


def _near(posture: HandPosture, tip: int, home: Object, place: Place, exact: bool) -> Proximity:
    """Of a fingertip and the object at its place, world axes; measured with the object at home."""
    R, o = place.rotation, place.position
    p, Q = (posture.tip_positions[tip] - o) @ R, R.T @ posture.tip_rotations[tip]
    shapes = posture.hand.tip_shapes(tip)
    if exact or (len(shapes) == 1 and shapes[0].radius is not None):
        found = nearest_proximity(shapes, p, Q, home)
    else:
        found = min((_by_coal(shape, p, Q, home) for shape in shapes), key=lambda one: one.gap)
    return Proximity(found.gap, R @ found.position + o, R @ found.tip_point + o, R @ found.normal)


def _by_coal(shape: TipShape, p: Array, Q: Array, home: Object) -> Proximity:
    """Fast, and seldom wrong by much: the last steps are confirmed."""
    result = coal.DistanceResult()
    at = coal.Transform3s(Q @ shape.rotation, p + Q @ shape.translation)
    gap = float(coal.distance(shape.geometry, at, home.geometry, home.transform, _REQUEST, result))
    on_tip, on_object = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
    return Proximity(gap, on_object, on_tip, np.array(result.normal))
