"""Where to begin: postures all over the joint ranges, with the object between their fingertips.

At the weighted middle c of the tips p, Σ w (p - c) = 0: forces along the lines to c, with shares w |p - c|, balance. So
a ball around c can be held from all sides. The axes of a longer object are laid along those of the tips' spread.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np

from handlcp.check import Array
from handlcp.hand.find.clear import Links, Place, box_around, end_of, free_ranges
from handlcp.hand.objects.inside import distances
from handlcp.hand.objects.object import Object
from handlcp.hand.robot.model import HandModel

SAMPLES = 4096  # postures and placements that are compared
_TILT = 0.5  # [rad] of the object's axes against those of the tips' spread, at most, about each axis
_OUTSIDE = 5e-3  # [m] how far outside the object the middles of links should be
_LEAST = 0.1  # the smallest weight of a fingertip beside the largest
_TURNS = np.array([np.eye(3)[:, list(p)] for p in permutations(range(3))])
_TURNS[:, :, 2] *= np.linalg.det(_TURNS)[:, None]  # the ways to lay one frame's axes along another's


def guesses(hand: HandModel, tips: tuple[int, ...], links: Links, obj: Object, keep: int, seed: int) -> list[Place]:
    """The `keep` samples whose fingertips come nearest to touching the object, the nearest first; alike for a seed."""
    from scipy.stats import qmc  # a second of import that only a search should pay

    count = len(tips)
    lower, upper = free_ranges(hand)
    draws = qmc.Sobol(hand.nv + count + 4, rng=seed).random(SAMPLES)
    joints, weights, rest = np.split(draws, [hand.nv, hand.nv + count], axis=1)
    qs = lower + joints * (upper - lower)
    (frames, middles), ends = links.middles, [end_of(hand, tip) for tip in tips]
    frames = [*[hand.tips.frames[tip] for tip in tips], *frames]
    every = _points(hand, qs, frames, np.concatenate([[middle for middle, _ in ends], middles]))
    points = every[:, :count]
    weights = _LEAST + (1.0 - _LEAST) * weights
    weights /= weights.sum(axis=1, keepdims=True)
    centres = np.einsum("ki,kix->kx", weights, points)
    rotations = _laid(points - centres[:, None], weights, rest)
    middle = 0.5 * np.sum(box_around(obj.geometry), axis=0)
    local = np.einsum("kix,kxy->kiy", every - centres[:, None], rotations) + middle
    gaps = distances(local.reshape(-1, 3), obj).reshape(SAMPLES, -1)
    inside = np.minimum(gaps[:, count:] - _OUTSIDE, 0.0)
    gaps = gaps[:, :count] - np.array([radius for _, radius in ends])
    cost = (gaps**2).mean(axis=1) + (inside**2).sum(axis=1) / count
    best = np.argsort(cost, kind="stable")[:keep]
    return [Place(qs[k], rotations[k], centres[k] - rotations[k] @ middle) for k in best]


def _points(hand: HandModel, qs: Array, frames: list[int], within: Array) -> Array:
    """(m, k, 3) points of frames, `within` (k, 3) of each, in postures (m, nv); world axes [m]."""
    points = np.empty((len(qs), *within.shape))
    for k, q in enumerate(qs):
        at, _ = hand.kinematics.frames_at(q, frames)
        points[k] = np.einsum("ixy,iy->ix", at[:, :3, :3], within) + at[:, :3, 3]
    return points


def _laid(arms: Array, weights: Array, draws: Array) -> Array:
    """(m, 3, 3) rotations whose axes are those of the tips' spread, in any order and tilted a little, as draws (m, 4)
    in [0, 1) say. arms (m, k, 3) of the tips, with weights (m, k).
    """
    spread = np.einsum("ki,kix,kiy->kxy", weights, arms, arms)
    axes = np.linalg.eigh(spread)[1]
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
    ways = _TURNS[np.minimum((draws[:, 0] * len(_TURNS)).astype(int), len(_TURNS) - 1)]
    return np.asarray(axes @ _turned(_TILT * (2.0 * draws[:, 1:] - 1.0)) @ ways)


def _turned(angles: Array) -> Array:
    """(m, 3, 3) rotations by vectors (m, 3) [rad] (Rodrigues)."""
    size = np.maximum(np.linalg.norm(angles, axis=1), 1e-12)[:, None, None]
    x, y, z = (angles / size[:, :, 0]).T
    zero = np.zeros_like(x)
    K = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    return np.asarray(np.eye(3) + np.sin(size) * K + (1.0 - np.cos(size)) * (K @ K))
