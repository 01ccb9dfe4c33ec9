"""`SampleArrays`: samples of a grasp as arrays: what all of them need, computed for all at once.

What was commanded stays, in metres and radians of the joints: softer springs press less. Contacts stay where they are
on the object unless their positions vary. A joint that stands off by δq carries its fingertip along, by J δq, and its
command with it: the object lies -J δq off the tip, as a gap or as more squeeze, and J is that of the posture q + δq.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.geometry.object import BOX, CYLINDER, Object
from handlcp.grasp.derivatives.parameter.parameter import Samples
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.request import GraspSpec
from handlcp.hand.mechanism import HandMechanism
from handlcp.robot.hand_model import HandPosture


class NominalGrasp(NamedTuple):
    """The grasp that samples differ from.

    hand : its mechanism; None without a hand.
    has_own_flexibility : whether the flexibility is the hand's own; where it was given, or there is no hand, a
        factor on the stiffness is one on all of it.
    weight (6,) : wrench of the object's weight [N, N·m] about the reference, world axes.
    """

    spec: GraspSpec
    hand: HandMechanism | None
    has_own_flexibility: bool
    weight: Array


def make_nominal(spec: GraspSpec) -> NominalGrasp:
    """What is asked of a grasp's specification once."""
    hand = spec.mechanism
    if not isinstance(hand, HandMechanism):
        return NominalGrasp(spec, None, False, np.zeros(6))
    c = 3 * spec.of_hand
    made = replace(hand, jacobian=hand.jacobian[:c]).flexibility()
    own = bool(np.allclose(spec.flexibility[:c, :c], made, rtol=1e-12, atol=0.0))
    return NominalGrasp(spec, hand, own, hand.weight_of_object(spec.reference))


@dataclass(frozen=True, slots=True)
class SampleArrays:
    """m samples with n contacts, k of them fingers', SI, contact axes; what does not vary is broadcast.

    samples : what they are made of.
    positions (m, n, 3) : of the contacts [m], world axes.
    frames (m, n, 3, 3) : contact axes in columns, world axes.
    past_edge (m, k) : which fingers are past an edge of the object.
    mu (m, n) : coefficients of friction.
    wrench (m, 6) : on the object [N, N·m] about the reference, world axes.
    flexibility (m, 3n, 3n) : [m/N], without what effects add.
    offset (m, n, 3) : [m], without what effects add.
    squeeze (m,), mass (m,) : factors.
    """

    samples: Samples
    positions: Array
    frames: Array
    past_edge: Bools
    mu: Array
    wrench: Array
    flexibility: Array
    offset: Array
    squeeze: Array
    mass: Array
    joints: SampleJoints | None


@dataclass(frozen=True, slots=True)
class SampleJoints:
    """The joints of the hand in m samples.

    postures (m,) : of the hand.
    jacobian (m, 3n, nv) : of the contacts, contact axes [m/rad].
    root (m, nv, a) : of the compliance, as in `Mechanism`.
    stand_off (m, k, 3) : gaps and overlaps of the fingers [m], contact axes.
    weight (m, nv) : torque that holds the fingers [N·m], 0 where it does not count.
    springs (m, nv), pads (m, k) : factors; None: nominal.
    """

    postures: Sequence[HandPosture]
    jacobian: Array
    root: Array
    stand_off: Array
    weight: Array
    springs: Array | None
    pads: Array | None


def make_arrays(nominal: NominalGrasp, samples: Samples) -> SampleArrays:
    """All that the scenes of samples are made of."""
    spec, m, n, k = nominal.spec, samples.count, nominal.spec.n, nominal.spec.of_hand
    positions, frames, past = _contact_places(nominal, samples.get("slides"), m)
    mass, load, squeeze = (_sample_factors(samples, name) for name in ("mass", "load", "squeeze"))
    mu = samples.get("friction")
    if mu is None:
        mu = np.tile([c.mu for c in spec.contacts], (m, 1))
    joints = None if nominal.hand is None else _make_joints(nominal, nominal.hand, samples, positions, frames)
    offset, away = np.tile(spec.offset, (m, 1, 1)), samples.get("joints")
    if joints is not None and away is not None:
        offset[:, :k] += joints.stand_off - _require_hand(nominal).stand_off
    offset[:, :k] *= np.where(offset[:, :k, 2:] < 0.0, squeeze[:, None, None], 1.0)
    E, stiffer = np.broadcast_to(spec.flexibility, (m, 3 * n, 3 * n)), samples.get("springs")
    if not nominal.has_own_flexibility and stiffer is not None:
        E = E.copy()
        E[:, : 3 * k, : 3 * k] /= stiffer[:, :1, None]
    elif (
        nominal.has_own_flexibility
        and joints is not None
        and samples.written.keys() & {"slides", "joints", "springs", "pads"}
    ):
        E = E.copy()
        E[:, : 3 * k, : 3 * k] = _contact_flexibilities(_require_hand(nominal), joints, frames[:, :k])
    wrench = mass[:, None] * nominal.weight + load[:, None] * (spec.wrench - nominal.weight)
    return SampleArrays(samples, positions, frames, past, mu, wrench, E, offset, squeeze, mass, joints)


def _require_hand(nominal: NominalGrasp) -> HandMechanism:
    assert nominal.hand is not None
    return nominal.hand


def _sample_factors(samples: Samples, name: str) -> Array:
    """(m,) of a parameter with one factor."""
    found = samples.get(name)
    return np.ones(samples.count) if found is None else found[:, 0]


def _contact_places(nominal: NominalGrasp, slides: Array | None, m: int) -> tuple[Array, Array, Bools]:
    """Positions and frames with the fingers' contacts slid, and which fingers (m, k) are past an edge."""
    spec, k = nominal.spec, nominal.spec.of_hand
    if slides is None:
        shapes = (m, *spec.positions.shape), (m, *spec.frames.shape)
        return (
            np.broadcast_to(spec.positions, shapes[0]),
            np.broadcast_to(spec.frames, shapes[1]),
            np.zeros((m, k), bool),
        )
    target = None if nominal.hand is None or spec.planar else nominal.hand.target
    positions, frames = np.tile(spec.positions, (m, 1, 1)), np.tile(spec.frames, (m, 1, 1, 1))
    positions[:, :k], frames[:, :k], past = slide_contacts(spec.positions[:k], spec.frames[:k], slides, target)
    return positions, frames, past


def _make_joints(
    nominal: NominalGrasp, hand: HandMechanism, samples: Samples, positions: Array, frames: Array
) -> SampleJoints:
    """Postures with their Jacobians, springs, and what the fingers stand off by."""
    spec, m, k, nv = nominal.spec, samples.count, nominal.spec.of_hand, len(hand.names)
    away, springs = samples.get("joints"), samples.get("springs") if nominal.has_own_flexibility else None
    points, axes = positions[:, :k], frames[:, :k].swapaxes(2, 3)
    postures: Sequence[HandPosture] = [hand.posture] * m
    J, stand_off = np.zeros((m, 3 * spec.n, nv)), np.broadcast_to(hand.stand_off, (m, k, 3))
    torque = next((e.torque for e in spec.effects if isinstance(e, FingerWeight)), np.zeros(nv))
    weight = np.broadcast_to(torque, (m, nv))
    if away is not None:
        postures = [type(hand.posture)(hand.posture.hand, hand.posture.q + off) for off in away]
        moved = np.array([p.jacobian_at(x, hand.tips) for p, x in zip(postures, points, strict=True)])
        J[:, : 3 * k] = (axes @ moved).reshape(m, 3 * k, nv)
        carried = (J[:, : 3 * k] @ away[:, :, None]).reshape(m, k, 3)
        if spec.planar:
            carried[:, :, 1] = 0.0
        stand_off = stand_off - carried
        if torque.any():
            weight = np.array([p.gravity_torque(hand.gravity) for p in postures])
    elif samples.get("slides") is not None:
        J[:, : 3 * k] = (axes @ hand.posture.jacobian_at(points, hand.tips)).reshape(m, 3 * k, nv)
    else:
        J = np.broadcast_to(hand.jacobian, (m, *hand.jacobian.shape))
    root = np.broadcast_to(hand.compliance_factor, (m, *hand.compliance_factor.shape))
    if springs is not None:
        root = root / np.sqrt(springs)[:, :, None]
    return SampleJoints(postures, J, root, stand_off, weight, springs, samples.get("pads"))


def _contact_flexibilities(hand: HandMechanism, joints: SampleJoints, frames: Array) -> Array:
    """(m, 3k, 3k) E = J K⁻¹ Jᵀ + pads."""
    m, k = frames.shape[:2]
    through, tips = joints.jacobian[:, : 3 * k] @ joints.root, hand.tips
    E, pads = through @ through.swapaxes(1, 2), hand.posture.hand.pads
    blocks = np.broadcast_to(pads.blocks[list(tips)], (m, k, 3, 3))
    if not pads.isotropic:
        turned = frames.swapaxes(2, 3) @ np.array([p.tip_rotations[list(tips)] for p in joints.postures])
        blocks = turned @ blocks @ turned.swapaxes(2, 3)
    if joints.pads is not None:
        blocks = blocks * joints.pads[:, :, None, None]
    for i in range(k):
        own = slice(3 * i, 3 * i + 3)
        E[:, own, own] += blocks[:, i]
    return np.asarray(0.5 * (E + E.swapaxes(1, 2)))


# ----------------------------------------------------------------
# Contacts slid along the object's surface, many at once.
#
# Past an edge of a box or a rim of a cylinder a contact has no normal: it is on two faces, and a fingertip rolls around
# the edge. Such a contact keeps its axes, and is named as one that is past an edge.

_NEW_FACE_TOLERANCE = 1e-6  # of a normal that has one direction on a whole face: more is another face


def slide_contacts(positions: Array, frames: Array, shifts: Array, obj: Object | None) -> tuple[Array, Array, Bools]:
    """Positions (m, k, 3) and frames (m, k, 3, 3) of k contacts after m shifts (m, k, 2) [m] along their tangents, and
    which of them (m, k) are past an edge.

    On a ball, a box, a cylinder or an ellipsoid a contact stays on the surface, and its normal turns with that. On
    anything else, or without an object (None), it moves in its tangent plane, and keeps its normal.
    """
    m, k = len(shifts), len(positions)
    goal = positions + np.einsum("kab,mkb->mka", frames[:, :, :2], shifts)
    every = np.concatenate([positions, goal.reshape(-1, 3)])
    known = None if obj is None or obj.known is None else obj.closest_all(every)
    if obj is None or known is None:
        return goal, np.broadcast_to(frames, (m, k, 3, 3)), np.zeros((m, k), bool)
    _, on, out = known
    moved = positions + (on[k:].reshape(m, k, 3) - on[:k])
    turned = out[:k] - out[k:].reshape(m, k, 3)  # of the normals into the object
    past = _are_past_edge(turned, obj)
    z = frames[:, :, 2] + np.where(past[..., None], 0.0, turned)
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    x = frames[:, :, 0] - z * (z * frames[:, :, 0]).sum(axis=-1, keepdims=True)
    x = x / np.sqrt((x * x).sum(axis=-1, keepdims=True))
    made = np.stack([x, np.cross(z, x), z], axis=-1)
    stays = (turned == 0.0).all(axis=-1) | past
    return moved, np.where(stays[..., None, None], frames, made), past


def _are_past_edge(turned: Array, obj: Object) -> Bools:
    """(m, k) from how normals (m, k, 3) have turned: on a box not at all; on a cylinder not towards its axis."""
    assert obj.known is not None
    kind, (R, _) = obj.known[0], obj.frame
    if kind == BOX:
        return np.asarray((abs(turned) > _NEW_FACE_TOLERANCE).any(axis=-1))
    if kind == CYLINDER:
        return np.asarray(abs(turned @ R[:, 2]) > _NEW_FACE_TOLERANCE)
    return np.zeros(turned.shape[:-1], bool)
