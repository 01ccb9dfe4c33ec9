"""`SamplePlacer`: the grasps of samples, as rows that are solved many at once, or as grasps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.actuation.joint_stiffness import Elasticity, FingertipPads, JointStiffness
from handlcp.check import Array, Bools, read_only
from handlcp.errors import NoGraspFound
from handlcp.grasp.derivatives.parameter.parameter import Samples
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solve.compiled_answer import CompiledKind
from handlcp.grasp.solve.compiled_solve import write_rows
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.mechanism import HandMechanism
from handlcp.robot.hand_model import HandPosture
from handlcp.studies.perturbation import vary_grasp
from handlcp.studies.reliability.sample_arrays import SampleArrays, SampleJoints, make_arrays, make_nominal
from handlcp.studies.reliability.spread import HAND_NUMBER, Dimension, varying_parameters

_ROW_EFFECTS = (JointOffset, FingerWeight)  # effects that `SamplePlacer.make_rows` adds to offsets itself


class PlacedSample(NamedTuple):
    """The grasp of a sample. why_not : why it is none that could be judged, in words; None: it is one."""

    grasp: Grasp
    why_not: str | None


class SamplePlacer:
    """Makes samples of a grasp from values (m, d) of the dimensions that vary."""

    def __init__(self, grasp: Grasp, dimensions: Sequence[Dimension]) -> None:
        self.grasp, self.spec, self.dimensions = grasp, grasp.spec, tuple(dimensions)
        self._nominal = make_nominal(self.spec)

    def make_sample_arrays(self, values: Array) -> SampleArrays:
        """What the parameters write, and all that follows from it."""
        made, known = Samples(self.spec, len(values)), varying_parameters()
        for d, column in zip(self.dimensions, values.T, strict=True):
            known[d.parameter].write(made, d.index, column)
        return make_arrays(self._nominal, made)

    # ---- as rows
    @property
    def has_row_form(self) -> bool:
        """Whether scenes follow from arrays alone: Coulomb's friction, and no effect but a command and a weight."""
        plain = self.grasp.scene.scale is None and all(c.plain for c in self.spec.contacts)
        return plain and all(isinstance(e, _ROW_EFFECTS) for e in self.spec.effects)

    def make_rows(self, arrays: SampleArrays, kind: CompiledKind, share: float) -> Array:
        """(m, width) the scenes of samples whose kind is that of the grasp; share : of `Section`."""
        spec, scene, m = self.spec, self.grasp.scene, len(arrays.mu)
        force = arrays.wrench[:, :3]
        return write_rows(
            m,
            kind.scene_width,
            positions=arrays.positions,
            frames=arrays.frames,
            flexibility=arrays.flexibility,
            offset=self.total_offsets(arrays),
            prescribed=[scene.arrays.prescribed] * m,
            spin=np.zeros((m, 0)),
            force=force,
            moment=arrays.wrench[:, 3:] + np.cross(spec.reference, force),
            freedom=[scene.freedom] * m,
            limits=arrays.mu * share,
        )

    def total_offsets(self, arrays: SampleArrays) -> Array:
        """(m, 3n) with what effects add [m]."""
        offset = arrays.offset.reshape(len(arrays.mu), -1)
        if arrays.joints is None or not self.spec.effects:
            return offset
        return np.asarray(offset + self._effect_offsets(arrays, arrays.joints))

    def _effect_offsets(self, arrays: SampleArrays, joints: SampleJoints) -> Array:
        """(m, 3n) what commands and the fingers' weight add to the offsets: -J δq and J K⁻¹ g."""
        moved = np.zeros(joints.weight.shape)
        for e in self.spec.effects:
            if isinstance(e, JointOffset):
                moved -= arrays.squeeze[:, None] * e.command
            elif isinstance(e, FingerWeight) and e.sags:
                moved += (joints.root @ (joints.root.swapaxes(1, 2) @ joints.weight[:, :, None]))[:, :, 0]
        added = (joints.jacobian @ moved[:, :, None])[:, :, 0]
        if self.spec.planar:  # nothing opens across the plane
            added[:, 1::3] = 0.0
        return np.asarray(added)

    def why_unplaced(self, past: Bools) -> str | None:
        """What is wrong with a sample, some of whose fingers (k,) are past an edge."""
        if not past.any():
            return None
        names = [self.spec.names[i] for i in np.flatnonzero(past)]
        return f"{words.list_names(names)} would be past an edge of the object, where a contact has no normal"

    # ---- as grasps
    def place_samples(self, values: Array) -> list[PlacedSample]:
        """The grasp of each sample with values (m, d), SI units."""
        arrays = self.make_sample_arrays(values)
        return [
            PlacedSample(self.make_grasp(arrays, k), self.why_unplaced(past)) for k, past in enumerate(arrays.past_edge)
        ]

    def make_grasp(self, arrays: SampleArrays, k: int) -> Grasp:
        """That of sample k; where it is past an edge, with its nominal axes."""
        spec = self._changed_spec(arrays, k)
        for remade, factors in arrays.samples.remade:
            spec = remade(spec, float(factors[k]))
        return type(self.grasp)(spec)

    def _changed_spec(self, arrays: SampleArrays, k: int) -> GraspSpec:
        spec, written = self.spec, arrays.samples.written.keys()
        changes: dict[str, Any] = {}
        if "friction" in written or "slides" in written:
            changes["contacts"] = self._sample_contacts(arrays, k, "slides" in written)
        if "slides" in written:
            changes |= {
                "positions": read_only(arrays.positions[k].copy()),
                "frames": read_only(arrays.frames[k].copy()),
            }
        if written & {"mass", "load"}:
            changes["wrench"] = read_only(arrays.wrench[k].copy())
        if written & {"joints", "squeeze"}:
            changes["offset"] = read_only(arrays.offset[k].copy())
        if written & {"slides", "joints", "springs", "pads"}:
            changes["flexibility"] = read_only(arrays.flexibility[k].copy())
        if arrays.joints is not None and written & {"slides", "joints", "springs", "pads", "mass"}:
            hand = self._nominal.hand
            assert hand is not None
            changes["mechanism"] = _sample_mechanism(hand, arrays, arrays.joints, k)
        if spec.effects and written & {"joints", "squeeze"}:
            changes["effects"] = self._sample_effects(arrays, k)
        return spec.replace(**changes)

    def _sample_effects(self, arrays: SampleArrays, k: int) -> tuple[Any, ...]:
        """With commands eased, and the fingers' weight of the sample's posture."""
        found: list[Any] = []
        for e in self.spec.effects:
            if isinstance(e, JointOffset) and arrays.squeeze[k] != 1.0:
                found.append(replace(e, command=read_only(arrays.squeeze[k] * e.command), reach=None))
            elif isinstance(e, FingerWeight) and arrays.joints is not None:
                found.append(replace(e, torque=read_only(arrays.joints.weight[k].copy())))
            else:
                found.append(e)
        return tuple(found)

    def _sample_contacts(self, arrays: SampleArrays, k: int, slid: bool) -> tuple[Contact, ...]:
        out, laws = [], dict[tuple[int, float], Any]()
        for i, c in enumerate(self.spec.contacts):
            mu, law = float(arrays.mu[k, i]), c.friction
            if mu != c.mu:  # one law for all contacts that share it
                law = laws.setdefault((id(law), mu), law.with_mu(mu))
            p, R = (c.position, c.rotation)
            if slid:
                p, R = read_only(arrays.positions[k, i].copy()), read_only(arrays.frames[k, i].copy())
            out.append(Contact.from_arrays(p, R, law, c.planar, c.name))
        return tuple(out)


def _sample_mechanism(hand: HandMechanism, arrays: SampleArrays, joints: SampleJoints, k: int) -> HandMechanism:
    """The hand's mechanism in sample k, with its springs, pads and posture."""
    model, posture, few, parts = hand.posture.hand, joints.postures[k], len(hand.tips), dict[str, Any]()
    if joints.springs is not None:
        parts["stiffness"] = _scale_springs(model.stiffness, joints.springs[k])
    if joints.pads is not None:
        blocks = model.pads.blocks.copy()
        blocks[list(hand.tips)] *= joints.pads[k][:, None, None]
        parts["pads"] = FingertipPads(blocks)
    if parts:
        posture = _posture_with_hand(posture, model.with_parts(**parts))
    target = hand.target if hand.target is None else hand.target.weighing(float(arrays.mass[k]) * hand.target.mass)
    return replace(
        hand,
        posture=posture,
        jacobian=read_only(joints.jacobian[k].copy()),
        compliance_factor=posture.hand.stiffness.compliance_factor,
        positions=read_only(arrays.positions[k, :few].copy()),
        frames=read_only(arrays.frames[k, :few].copy()),
        target=target,
        stand_off=read_only(joints.stand_off[k].copy()),
    )


def _scale_springs(springs: Elasticity, factors: Array) -> Elasticity:
    """Springs that are stiffer by factors (nv,), which are all alike for tendons and synergies."""
    if isinstance(springs, JointStiffness) and not springs.is_transmission:
        return springs.scale_by_joint(factors)
    return springs.scale_stiffness(float(factors[0]))


def _posture_with_hand(old: HandPosture, hand: Any) -> HandPosture:
    """The posture of a hand that differs in springs and pads alone."""
    made = object.__new__(type(old))
    made.__dict__.update(old.__dict__, hand=hand)
    made.__dict__.pop("flexibility", None)  # of the other springs
    return made


# ----------------------------------------------------------------
# Samples of a grasp whose hand varies by the names of `Hand.vary`: each is made anew, and all else varied after it.


class HandNumberPlacer(SamplePlacer):
    """Makes samples of a hand's grasp where some dimensions are numbers of the hand."""

    def __init__(self, grasp: Grasp, dimensions: tuple[Dimension, ...]) -> None:
        super().__init__(grasp, dimensions)
        self._is_hand_number = np.array([d.parameter == HAND_NUMBER for d in dimensions])
        self._other_dimensions = tuple([d for d in dimensions if d.parameter != HAND_NUMBER])

    def make_sample_arrays(self, values: Array) -> SampleArrays:
        """What others write, for what is read off arrays; the grasps themselves are made one by one."""
        found = SamplePlacer(self.grasp, self._other_dimensions).make_sample_arrays(values[:, ~self._is_hand_number])
        made = [self._vary_sample(row) for row in values]

        def spec_of_sample(_: GraspSpec, k: float) -> GraspSpec:
            spec = made[int(k)]
            return self.spec if spec is None else spec

        found.samples.remade.append((spec_of_sample, np.arange(len(values), dtype=float)))
        lost = np.array([spec is None for spec in made])
        return replace(found, past_edge=found.past_edge | lost[:, None])

    def _vary_sample(self, row: Array) -> GraspSpec | None:
        """The grasp of one sample with values row (d,); None where the fingertips do not come to touch."""
        assert isinstance(self.grasp, HandGrasp)
        numbers = [d.name for d in self.dimensions if d.parameter == HAND_NUMBER]
        try:
            grasp = vary_grasp(self.grasp, dict(zip(numbers, row[self._is_hand_number].tolist(), strict=True)))
        except NoGraspFound:
            return None
        others = SamplePlacer(grasp, self._other_dimensions)
        return others.make_grasp(others.make_sample_arrays(row[None, ~self._is_hand_number]), 0).spec

    def why_unplaced(self, past: Bools) -> str | None:
        """What is wrong with a sample."""
        return "the fingertips of such a hand do not come to touch the object again" if past.any() else None


def make_placer(grasp: Grasp, dimensions: tuple[Dimension, ...]) -> SamplePlacer:
    """What makes samples of these dimensions."""
    by_number = any(d.parameter == HAND_NUMBER for d in dimensions)
    return HandNumberPlacer(grasp, dimensions) if by_number else SamplePlacer(grasp, dimensions)
