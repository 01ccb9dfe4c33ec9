"""`SamplePlacer`: the grasps of samples, as rows that are solved many at once, or as grasps.

What was commanded stays, in metres and radians of the joints: softer springs press less. Contacts stay where they are
on the object unless their positions vary. A joint that is off by δq carries its fingertip along, by J δq, and its
command with it: the object lies -J δq off the tip, as a gap or as more squeeze, and J is that of the posture q + δq.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import FingertipPads, JointStiffness
from handlcp.check import Array, Bools, read_only
from handlcp.contact.closest_point import BOX, CYLINDER
from handlcp.errors import NoGraspFound
from handlcp.geometry.object import Object
from handlcp.grasp.derivatives.parameter.parameter import Samples
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solve.compiled_answer import CompiledKind, write_rows
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.mechanism import HandMechanism
from handlcp.robot.hand_model import HandPosture
from handlcp.studies.perturbation import vary_grasp
from handlcp.studies.reliability.spread import HAND_NUMBER, Dimension, varying_parameters

# Which arrays of `Samples` change what of a specification
_CHANGE_FLEXIBILITY = {"slides", "joints", "springs", "pads"}
_CHANGE_ARRAYS = {
    "positions": {"slides"},
    "frames": {"slides"},
    "wrench": {"mass", "load"},
    "offset": {"joints", "squeeze"},
    "flexibility": _CHANGE_FLEXIBILITY,
}


@dataclass(frozen=True, slots=True)
class SampleJoints:
    """The joints of the hand in m samples.

    postures (m,) : of the hand.
    jacobian (m, 3n, nv) : of the contacts, contact axes [m/rad].
    compliance_factor (m, nv, a) : as in `Mechanism`.
    stand_off (m, k, 3) : gaps and overlaps of the fingers [m], contact axes.
    weight (m, nv) : torque that holds the fingers [N·m], 0 where it does not count.
    springs (m, nv), pads (m, k) : factors; None: nominal.
    """

    postures: Sequence[HandPosture]
    jacobian: Array
    compliance_factor: Array
    stand_off: Array
    weight: Array
    springs: Array | None
    pads: Array | None


@dataclass(frozen=True, slots=True)
class SampleArrays:
    """m samples with n contacts, k of them fingers', SI, contact axes; what does not vary is broadcast.

    samples : what they are made of.
    positions (m, n, 3) : of the contacts [m], world axes.
    frames (m, n, 3, 3) : contact axes in columns, world axes.
    unplaceable (m, k) : which fingers have no contact, such as one past an edge of the object.
    mu (m, n) : coefficients of friction.
    wrench (m, 6) : on the object [N, N·m] about the reference, world axes.
    flexibility (m, 3n, 3n) : [m/N], without what effects add.
    offset (m, n, 3) : [m], without what effects add.
    squeeze (m,), mass (m,) : factors.
    """

    samples: Samples
    positions: Array
    frames: Array
    unplaceable: Bools
    mu: Array
    wrench: Array
    flexibility: Array
    offset: Array
    squeeze: Array
    mass: Array
    joints: SampleJoints | None


class PlacedSample(NamedTuple):
    """The grasp of a sample. why_not : why it is none that could be judged, in words; None: it is one."""

    grasp: Grasp
    why_not: str | None


class SamplePlacer:
    """Makes samples of a grasp from values (m, d) of the dimensions that vary."""

    def __init__(self, grasp: Grasp, dimensions: Sequence[Dimension]) -> None:
        self.grasp, self.spec, self.dimensions = grasp, grasp.spec, tuple(dimensions)
        hand, c = self.spec.mechanism, 3 * self.spec.of_hand
        self._hand = hand if isinstance(hand, HandMechanism) else None
        self._springs_are_joints, self._weight = False, np.zeros(6)
        if self._hand is not None:  # a flexibility that was given is not that of the joints: a factor is one on all
            made = replace(self._hand, jacobian=self._hand.jacobian[:c]).flexibility()
            self._springs_are_joints = bool(np.allclose(self.spec.flexibility[:c, :c], made, rtol=1e-12, atol=0.0))
            self._weight = self._hand.weight_of_object(self.spec.reference)

    # ---- as arrays
    def make_sample_arrays(self, values: Array) -> SampleArrays:
        """What the parameters write, and all that the scenes of samples are made of."""
        spec, m, k, known = self.spec, len(values), self.spec.of_hand, varying_parameters()
        samples = Samples(spec, m)
        for d, column in zip(self.dimensions, values.T, strict=True):
            known[d.parameter].write(samples, d.index, column)
        written = samples.written
        mass, load, squeeze = (written.get(name, np.ones((m, 1)))[:, 0] for name in ("mass", "load", "squeeze"))
        mu = written.get("friction", np.tile([c.mu for c in spec.contacts], (m, 1)))
        positions, frames = (np.broadcast_to(a, (m, *a.shape)) for a in (spec.positions, spec.frames))
        past = np.zeros((m, k), bool)
        if "slides" in written:
            target = None if self._hand is None or spec.planar else self._hand.target
            positions, frames = positions.copy(), frames.copy()
            own = slide_contacts(spec.positions[:k], spec.frames[:k], written["slides"], target)
            positions[:, :k], frames[:, :k], past = own
        joints = None if self._hand is None else self._make_joints(self._hand, samples, positions, frames)
        offset = np.tile(spec.offset, (m, 1, 1))
        if joints is not None and self._hand is not None and "joints" in written:
            offset[:, :k] += joints.stand_off - self._hand.stand_off
        offset[:, :k] *= np.where(offset[:, :k, 2:] < 0.0, squeeze[:, None, None], 1.0)
        E = np.broadcast_to(spec.flexibility, (m, 3 * spec.n, 3 * spec.n))
        if not self._springs_are_joints and "springs" in written:
            E = E.copy()
            E[:, : 3 * k, : 3 * k] /= written["springs"][:, :1, None]
        elif self._springs_are_joints and joints is not None and written.keys() & _CHANGE_FLEXIBILITY:
            E = E.copy()
            E[:, : 3 * k, : 3 * k] = self._contact_flexibilities(joints, frames[:, :k])
        wrench = mass[:, None] * self._weight + load[:, None] * (spec.wrench - self._weight)
        return SampleArrays(samples, positions, frames, past, mu, wrench, E, offset, squeeze, mass, joints)

    def _make_joints(self, hand: HandMechanism, samples: Samples, positions: Array, frames: Array) -> SampleJoints:
        """Postures with their Jacobians, springs, and gaps and overlaps of the fingers."""
        spec, m, k, nv, written = self.spec, samples.count, self.spec.of_hand, len(hand.names), samples.written
        away, springs = written.get("joints"), written.get("springs") if self._springs_are_joints else None
        points, axes = positions[:, :k], frames[:, :k].swapaxes(2, 3)
        postures: Sequence[HandPosture] = [hand.posture] * m
        stand_off = np.broadcast_to(hand.stand_off, (m, k, 3))
        torque = next((e.torque for e in spec.effects if isinstance(e, FingerWeight)), np.zeros(nv))
        weight = np.broadcast_to(torque, (m, nv))
        J = np.broadcast_to(hand.jacobian, (m, *hand.jacobian.shape))
        if away is not None or "slides" in written:
            J = np.zeros((m, 3 * spec.n, nv))
            if away is None:
                moved = hand.posture.jacobian_at(points, hand.tips)
            else:
                postures = [type(hand.posture)(hand.posture.hand, hand.posture.q + off) for off in away]
                moved = np.array([p.jacobian_at(x, hand.tips) for p, x in zip(postures, points, strict=True)])
            J[:, : 3 * k] = (axes @ moved).reshape(m, 3 * k, nv)
        if away is not None:
            carried = (J[:, : 3 * k] @ away[:, :, None]).reshape(m, k, 3)
            if spec.planar:
                carried[:, :, 1] = 0.0
            stand_off = stand_off - carried
            if torque.any():
                weight = np.array([p.gravity_torque(hand.gravity) for p in postures])
        compliance_factor = np.broadcast_to(hand.compliance_factor, (m, *hand.compliance_factor.shape))
        if springs is not None:
            compliance_factor = compliance_factor / np.sqrt(springs)[:, :, None]
        return SampleJoints(postures, J, compliance_factor, stand_off, weight, springs, written.get("pads"))

    def _contact_flexibilities(self, joints: SampleJoints, frames: Array) -> Array:
        """(m, 3k, 3k) E = J K⁻¹ Jᵀ + pads."""
        assert self._hand is not None
        m, k, tips, pads = *frames.shape[:2], list(self._hand.tips), self._hand.posture.hand.pads
        through = joints.jacobian[:, : 3 * k] @ joints.compliance_factor
        E, blocks = through @ through.swapaxes(1, 2), np.broadcast_to(pads.blocks[tips], (m, k, 3, 3))
        if not pads.isotropic:
            turned = frames.swapaxes(2, 3) @ np.array([p.tip_rotations[tips] for p in joints.postures])
            blocks = turned @ blocks @ turned.swapaxes(2, 3)
        if joints.pads is not None:
            blocks = blocks * joints.pads[:, :, None, None]
        for i in range(k):
            own = slice(3 * i, 3 * i + 3)
            E[:, own, own] += blocks[:, i]
        return np.asarray(0.5 * (E + E.swapaxes(1, 2)))

    # ---- as rows
    @property
    def has_row_form(self) -> bool:
        """Whether scenes follow from arrays alone: Coulomb's friction, and no effect but a command and a weight."""
        plain = self.grasp.scene.scale is None and all(c.plain for c in self.spec.contacts)
        return plain and all(isinstance(e, (JointOffset, FingerWeight)) for e in self.spec.effects)

    def make_rows(self, arrays: SampleArrays, kind: CompiledKind, share: float) -> Array:
        """(m, width) the scenes of samples whose kind is that of the grasp; share : of `Section`."""
        scene, m, force = self.grasp.scene, len(arrays.mu), arrays.wrench[:, :3]
        return write_rows(
            m,
            kind.width,
            positions=arrays.positions,
            frames=arrays.frames,
            flexibility=arrays.flexibility,
            offset=self.total_offsets(arrays),
            prescribed=[scene.arrays.prescribed] * m,
            force=force,
            moment=arrays.wrench[:, 3:] + np.cross(self.spec.reference, force),
            freedom=[scene.freedom] * m,
            friction=arrays.mu * share,
        )

    def total_offsets(self, arrays: SampleArrays) -> Array:
        """(m, 3n) with what commands and the fingers' weight add, -J δq and J K⁻¹ g [m]."""
        offset, joints = arrays.offset.reshape(len(arrays.mu), -1), arrays.joints
        if joints is None or not self.spec.effects:
            return offset
        moved = np.zeros(joints.weight.shape)
        for e in self.spec.effects:
            if isinstance(e, JointOffset):
                moved -= arrays.squeeze[:, None] * e.command
            elif isinstance(e, FingerWeight) and e.sags:
                factor = joints.compliance_factor
                moved += (factor @ (factor.swapaxes(1, 2) @ joints.weight[:, :, None]))[:, :, 0]
        added = (joints.jacobian @ moved[:, :, None])[:, :, 0]
        if self.spec.planar:  # nothing opens across the plane
            added[:, 1::3] = 0.0
        return np.asarray(offset + added)

    # ---- as grasps
    def place_samples(self, values: Array) -> list[PlacedSample]:
        """The grasp of each sample with values (m, d), SI units."""
        arrays = self.make_sample_arrays(values)
        reasons = [self.why_unplaced(fingers) for fingers in arrays.unplaceable]
        return [PlacedSample(self.make_grasp(arrays, k), why) for k, why in enumerate(reasons)]

    def why_unplaced(self, fingers: Bools) -> str | None:
        """What is wrong with a sample, from which of its fingers (k,) are unplaceable: here, past an edge."""
        if not fingers.any():
            return None
        names = [self.spec.names[i] for i in np.flatnonzero(fingers)]
        return f"{words.list_names(names)} would be past an edge of the object, where a contact has no normal"

    def make_grasp(self, arrays: SampleArrays, k: int) -> Grasp:
        """That of sample k; a contact past an edge has its nominal axes."""
        spec, written = self.spec, arrays.samples.written.keys()
        changes: dict[str, Any] = {
            name: read_only(getattr(arrays, name)[k].copy()) for name, by in _CHANGE_ARRAYS.items() if written & by
        }
        if written & {"joints", "squeeze"}:
            changes["effects"] = self._sample_effects(arrays, k)
        if written & {"friction", "slides"}:
            changes["contacts"] = self._sample_contacts(arrays, k, "slides" in written)
        if arrays.joints is not None and written & {*_CHANGE_FLEXIBILITY, "mass"}:
            changes["mechanism"] = self._sample_mechanism(arrays, arrays.joints, k)
        spec = spec.replace(**changes)
        for remade, factors in arrays.samples.remade:
            spec = remade(spec, float(factors[k]))
        return type(self.grasp)(spec)

    def _sample_effects(self, arrays: SampleArrays, k: int) -> tuple[Any, ...]:
        """With commands eased, and the fingers' weight of the sample's posture."""
        found = list[Any]()
        for e in self.spec.effects:
            if isinstance(e, JointOffset) and arrays.squeeze[k] != 1.0:
                e = replace(e, command=read_only(arrays.squeeze[k] * e.command), reach=None)
            elif isinstance(e, FingerWeight) and arrays.joints is not None:
                e = replace(e, torque=read_only(arrays.joints.weight[k].copy()))
            found.append(e)
        return tuple(found)

    def _sample_contacts(self, arrays: SampleArrays, k: int, slid: bool) -> tuple[Contact, ...]:
        found, laws = [], dict[tuple[int, float], Any]()
        for i, c in enumerate(self.spec.contacts):
            mu, law, p, R = float(arrays.mu[k, i]), c.friction, c.position, c.rotation
            if mu != c.mu:  # one law for all contacts that share it
                law = laws.setdefault((id(law), mu), law.with_mu(mu))
            if slid:
                p, R = read_only(arrays.positions[k, i].copy()), read_only(arrays.frames[k, i].copy())
            found.append(Contact.from_arrays(p, R, law, c.planar, c.name))
        return tuple(found)

    def _sample_mechanism(self, arrays: SampleArrays, joints: SampleJoints, k: int) -> HandMechanism:
        """The hand's mechanism in sample k, with its springs, pads and posture."""
        hand = self._hand
        assert hand is not None
        model, posture, few, parts = hand.posture.hand, joints.postures[k], len(hand.tips), dict[str, Any]()
        if joints.springs is not None:
            springs, factors = model.stiffness, joints.springs[k]  # all alike for tendons and synergies
            if isinstance(springs, JointStiffness) and not springs.is_transmission:
                parts["stiffness"] = springs.scale_by_joint(factors)
            else:
                parts["stiffness"] = springs.scale_stiffness(float(factors[0]))
        if joints.pads is not None:
            blocks = model.pads.blocks.copy()
            blocks[list(hand.tips)] *= joints.pads[k][:, None, None]
            parts["pads"] = FingertipPads(blocks)
        if parts:
            posture = copy(posture)  # where joints and links are does not change with springs and pads
            posture.__dict__["hand"] = model.with_parts(**parts)
            posture.__dict__.pop("flexibility", None)
        return replace(
            hand,
            posture=posture,
            jacobian=read_only(joints.jacobian[k].copy()),
            compliance_factor=posture.hand.stiffness.compliance_factor,
            positions=read_only(arrays.positions[k, :few].copy()),
            frames=read_only(arrays.frames[k, :few].copy()),
            target=None if hand.target is None else hand.target.weighing(float(arrays.mass[k]) * hand.target.mass),
            stand_off=read_only(joints.stand_off[k].copy()),
        )


class HandNumberPlacer(SamplePlacer):
    """Makes samples of a hand's grasp where some dimensions are numbers of the hand, by their names for `Hand.vary`:
    each is made anew, and all else varied after it.
    """

    def make_sample_arrays(self, values: Array) -> SampleArrays:
        """What others write, for what is read off arrays; the grasps themselves are made one by one."""
        is_number = np.array([d.parameter == HAND_NUMBER for d in self.dimensions])
        others = [d for d in self.dimensions if d.parameter != HAND_NUMBER]
        found = SamplePlacer(self.grasp, others).make_sample_arrays(values[:, ~is_number])
        made = [self._vary_sample(row[is_number], others, row[~is_number]) for row in values]

        def spec_of_sample(_: GraspSpec, k: float) -> GraspSpec:
            return made[int(k)] or self.spec

        found.samples.remade.append((spec_of_sample, np.arange(len(values), dtype=float)))
        lost = np.array([spec is None for spec in made])
        return replace(found, unplaceable=found.unplaceable | lost[:, None])

    def _vary_sample(self, numbers: Array, others: Sequence[Dimension], rest: Array) -> GraspSpec | None:
        """The grasp of one sample with these numbers of the hand, and the rest (d,) of the others' values; None where
        the fingertips do not come to touch.
        """
        assert isinstance(self.grasp, HandGrasp)
        names = [d.name for d in self.dimensions if d.parameter == HAND_NUMBER]
        try:
            grasp = vary_grasp(self.grasp, dict(zip(names, numbers.tolist(), strict=True)))
        except NoGraspFound:
            return None
        placer = SamplePlacer(grasp, others)
        return placer.make_grasp(placer.make_sample_arrays(rest[None]), 0).spec

    def why_unplaced(self, fingers: Bools) -> str | None:
        """What is wrong with a sample; here it has no fingertips that touch."""
        return "the fingertips of such a hand do not come to touch the object again" if fingers.any() else None


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
    found = None if obj is None else obj.closest_all(np.concatenate([positions, goal.reshape(-1, 3)]))
    if obj is None or obj.known is None or found is None:
        return goal, np.broadcast_to(frames, (m, k, 3, 3)), np.zeros((m, k), bool)
    _, on, out = found
    moved = positions + (on[k:].reshape(m, k, 3) - on[:k])
    turned = out[:k] - out[k:].reshape(m, k, 3)  # of the normals into the object
    past: Bools = np.zeros((m, k), bool)
    if obj.known[0] == BOX:  # on which no normal turns; on a cylinder none towards its axis
        past = np.asarray((abs(turned) > _NEW_FACE_TOLERANCE).any(axis=-1))
    elif obj.known[0] == CYLINDER:
        past = np.asarray(abs(turned @ obj.frame[0][:, 2]) > _NEW_FACE_TOLERANCE)
    z = frames[:, :, 2] + np.where(past[..., None], 0.0, turned)
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    x = frames[:, :, 0] - z * (z * frames[:, :, 0]).sum(axis=-1, keepdims=True)
    x = x / np.sqrt((x * x).sum(axis=-1, keepdims=True))
    made = np.stack([x, np.cross(z, x), z], axis=-1)
    stays = (turned == 0.0).all(axis=-1) | past
    return moved, np.where(stays[..., None, None], frames, made), past
