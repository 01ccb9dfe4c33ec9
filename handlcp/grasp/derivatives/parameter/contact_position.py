"""`ContactPositions`: where the contacts are and how their axes lie, and what moving and turning them changes in the
laws, in closed form.

A contact point moves by δp, its axes turn by δθ with it; the object stays, and so do the joints, their commands, and
offsets and pads in the axes of fingertip and contact. With the twist (u, ω) of a body about a point a, the force f on
it in world axes, and R the contact axes:

    by δp    δ(Gᵀu) = Rᵀ (ω × δp)         δ(G r) = (0, δp × f)
    by δθ    δ(Gᵀu) = -θ × Rᵀ(u + ω × (p - a))    δ(G r) = (R (θ × r), (p - a) × R (θ × r))

The object is one body, and a soft wrist (`SoftWrist`) another that moves by C W r. The joints move the fingertips by
J (δ - δq), which changes in the same way with their angular velocities Ω, and J changes what the joints feel. Geometric
stiffness changes with the contacts in no closed form that is known here: beside it the laws are differenced.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, check_keys, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, zero_change
from handlcp.grasp.derivatives.parameter.parameter import Parameter, ParameterEntry, Samples, Shown, with_larger_entry
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.compliance import ContactCompliance, SoftWrist
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.request import GraspSpec

_KNOWN_EFFECTS = (ContactCompliance, FingerWeight, GeometricStiffness, JointOffset, SoftWrist)


class _ContactVectors(Parameter):
    """(n, 3) of contacts that move or turn, the rest of the grasp following."""

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (spec.n, 3)

    def values(self, spec: GraspSpec) -> Array:
        return np.zeros((spec.n, 3))

    def each_finger_alone(self, spec: GraspSpec, text: str, ways: Array) -> Shown:
        """The row of changes (k, a, 3) of each of k fingers alone."""
        one = np.eye(spec.n)
        return Shown(text, [(spec.names[i], np.outer(one[i], way)) for i, own in enumerate(ways) for way in own])


class ContactPositions(_ContactVectors):
    """[m], world axes; derivatives [1/m], in a planar scene those in its plane. In samples, slides along the object's
    surface.
    """

    name = "positions"
    order, step, spread = 90, 1e-7, "positions"
    uncertain = "Of each contact along both tangents, in metres."

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return _place_contacts(spec, with_larger_entry(spec.positions, k, step), spec.frames)

    def change(self, answer: LinearisationPoint) -> LawChange:
        return _motion_change(answer, turns=False) if answer.geometric_stiffness is None else super().change(answer)

    def shown(self, answer: LinearisationPoint) -> Shown:
        axes = answer.spec.frames[: answer.spec.of_hand].swapaxes(1, 2)
        return self.each_finger_alone(answer.spec, "1 mm aside", 1e-3 * axes[:, :2])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """Along both tangents of each finger, or of those that a mapping names."""
        names = spec.names[: spec.of_hand]
        named = (
            check_keys(argument, given, names, "a finger")
            if isinstance(given, Mapping)
            else dict.fromkeys(names, given)
        )
        axes = (0,) if spec.planar else (0, 1)  # a contact of a plane stays in it
        return [
            ParameterEntry(
                f"position {name} {'xy'[a]}", (i, a), None, -np.inf, "m", named[name], f"{argument}[{name!r}]"
            )
            for i, name in enumerate(names)
            if name in named
            for a in axes
        ]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.array("slides", 0.0, samples.spec.of_hand, 2)[:, at[0], at[1]] = values


class ContactNormals(_ContactVectors):
    """Turns [rad] of the contact axes about themselves; derivatives [1/rad]: x and y tilt the normal, z turns the
    tangents.
    """

    name = "normals"
    order, step = 100, 1e-6

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        i, a = divmod(k, 3)
        x, y = (a + 1) % 3, (a + 2) % 3
        frames = spec.frames.copy()
        frames[i, :, x] = np.cos(step) * spec.frames[i, :, x] + np.sin(step) * spec.frames[i, :, y]
        frames[i, :, y] = np.cos(step) * spec.frames[i, :, y] - np.sin(step) * spec.frames[i, :, x]
        return _place_contacts(spec, spec.positions, read_only(frames))

    def change(self, answer: LinearisationPoint) -> LawChange:
        return _motion_change(answer, turns=True) if answer.geometric_stiffness is None else super().change(answer)

    def shown(self, answer: LinearisationPoint) -> Shown:
        tilts = np.tile(np.radians(1.0) * np.eye(3)[:2], (answer.spec.of_hand, 1, 1))
        return self.each_finger_alone(answer.spec, "normal by 1°", tilts)


def _place_contacts(spec: GraspSpec, positions: Array, frames: Array) -> GraspSpec:
    """The grasp with its contacts at positions (n, 3) with frames (n, 3, 3)."""
    if spec.mechanism is not None:
        made: GraspSpec = spec.mechanism.variation.replace_contacts(spec, positions, frames)
        return made
    contacts = []
    for c, p, R, before in zip(spec.contacts, positions, frames, spec.frames, strict=True):
        rotation = read_only(R @ before.T @ c.rotation)  # its own axes turn along
        contacts.append(c.from_arrays(p, rotation, c.friction, c.planar, c.name))
    return spec.replace(contacts=tuple(contacts), positions=positions, frames=frames)


# ---------------------------------------------------------------- closed forms
def _motion_change(answer: LinearisationPoint, turns: bool) -> LawChange:
    spec = answer.spec
    if strange := [type(e).__name__ for e in spec.effects if _follows_contacts(e)]:
        raise Unsupported(f"how {', '.join(strange)} changes with the contacts is not known")
    n, change = spec.n, zero_change(answer, 3 * spec.n)
    forces, moments = answer.components[: 3 * n].reshape(n, 3), _contact_moments(answer)
    everybody = np.ones(n)
    own = _BodyMotion.from_twist(answer, answer.twist, spec.reference, everybody)
    change.motion[:], change.balance[:] = (
        own.velocity_changes(answer, turns),
        own.wrench_changes(forces, moments, turns),
    )
    for e in spec.effects:
        if isinstance(e, SoftWrist):
            _add_wrist(answer, e, forces, moments, turns, change)
    if spec.mechanism is not None:
        _add_joints(answer, forces, moments, turns, change)
    if spec.planar:
        change.motion[1 : 3 * n : 3] = 0.0
    change.motion[:] *= answer.scale[:, None]
    return change


class _BodyMotion:
    """What n contacts see of a body: its velocity (n, 3) and angular velocity (n, 3) at the points, world axes; and the
    arms (n, 3) from the point that its wrench refers to. carried (n,) : 1 for the contacts on it, 0 for others.
    """

    def __init__(self, answer: LinearisationPoint, velocity: Array, omega: Array, arms: Array, carried: Array) -> None:
        self.R, self.soft = answer.spec.frames, list(answer.scene.soft)
        self.velocity, self.omega, self.arms, self.carried = velocity, omega, arms, carried

    @classmethod
    def from_twist(cls, answer: LinearisationPoint, twist: Array, about: Array, carried: Array) -> _BodyMotion:
        """With a small motion (6,) about a point (3,)."""
        arms = answer.spec.positions - about
        omega = np.tile(twist[3:], (len(arms), 1))
        return cls(answer, twist[:3] + np.cross(omega, arms), omega, arms, carried)

    def velocity_changes(self, answer: LinearisationPoint, turns: bool) -> Array:
        """(c, 3n) δv of its motion in contact axes."""
        n, c = len(self.R), answer.scene.components
        out, axes = np.zeros((c, 3 * n)), self.R.transpose(0, 2, 1)
        blocks = _skew((axes @ self.velocity[:, :, None])[:, :, 0]) if turns else axes @ _skew(self.omega)
        _on_diagonal(out, blocks * self.carried[:, None, None])
        if turns:
            for at, i in enumerate(self.soft, 3 * n):
                out[at, 3 * i : 3 * i + 3] = -self.carried[i] * (self.omega[i] @ self.R[i] @ _skew(_Z_AXIS))
        return out

    def wrench_changes(self, forces: Array, moments: Array, turns: bool) -> Array:
        """(6, 3n) δb of forces (n, 3) and moments (n,) in contact axes."""
        n = len(self.R)
        out = np.zeros((6, n, 3))
        if turns:
            pulled = -(self.R @ _skew(forces))
            out[:3] = pulled.transpose(1, 0, 2)
            turned = _skew(self.arms) @ pulled - moments[:, None, None] * (self.R @ _skew(_Z_AXIS))
            out[3:] = turned.transpose(1, 0, 2)
        else:
            out[3:] = -_skew((self.R @ forces[:, :, None])[:, :, 0]).transpose(1, 0, 2)
        return np.asarray((out * self.carried[:, None]).reshape(6, 3 * n))


def _add_wrist(
    answer: LinearisationPoint, wrist: SoftWrist, forces: Array, moments: Array, turns: bool, change: LawChange
) -> None:
    """Add Wᵀ C W r."""
    spec = answer.spec
    fingers = (np.arange(spec.n) < spec.of_hand).astype(float)
    W = wrist.carried(spec, answer.scene.soft)
    body = _BodyMotion.from_twist(answer, wrist.flexibility @ (W @ answer.components), wrist.at, fingers)
    change.motion[:] += body.velocity_changes(answer, turns)
    change.motion[:] += W.T @ (wrist.flexibility @ body.wrench_changes(forces, moments, turns))


def _add_joints(answer: LinearisationPoint, forces: Array, moments: Array, turns: bool, change: LawChange) -> None:
    """Add J (δ - δq), and what the joints feel."""
    spec, J = answer.spec, answer.jacobian_rows
    mechanism = spec.mechanism
    assert mechanism is not None
    n, nv, follows = spec.n, J.shape[1], answer.elastic_joints
    moved = answer.joints.deflection + answer.joints.yielded - answer.command
    if not follows:
        moved = moved - mechanism.deflection(answer.components @ J)
    turning, axes = mechanism.variation.angular_jacobian(), spec.frames
    velocity = (axes @ (J[: 3 * n] @ moved).reshape(n, 3, 1))[:, :, 0]
    body = _BodyMotion(answer, velocity, turning @ moved, np.zeros((n, 3)), np.ones(n))
    change.motion[:] += body.velocity_changes(answer, turns)
    felt = body.wrench_changes(forces, moments, turns).reshape(
        6, n, 3
    )  # one point after the other: each finger feels its own
    torque = np.einsum("nkj,kna->jna", turning, felt[3:])
    if turns:
        torque += np.einsum("nkj,kna->jna", axes @ J[: 3 * n].reshape(n, 3, nv), felt[:3])
    change.torque[:] += torque.reshape(nv, 3 * n)
    if follows:
        change.motion[:] += J @ (answer.compliance @ change.torque)
        if turns:
            _add_pads(answer, forces, change)


def _add_pads(answer: LinearisationPoint, forces: Array, change: LawChange) -> None:
    """Add pads that stay with the fingertip while the contact axes turn: δ(P r) = P (θ × r) - θ × P r."""
    spec, J = answer.spec, answer.jacobian_rows
    assert spec.mechanism is not None
    root = spec.mechanism.compliance_factor
    for i in range(spec.of_hand):
        own = slice(3 * i, 3 * i + 3)
        through = J[own] @ root
        P = spec.flexibility[own, own] - through @ through.T
        change.motion[own, own] += _skew(P @ forces[i]) - P @ _skew(forces[i])


def _follows_contacts(effect: Effect) -> bool:
    """Whether an effect may change with where the contacts are, in a way that is not known here."""
    kind = type(effect)
    own = kind.added_flexibility is not Effect.added_flexibility or kind.added_offset is not Effect.added_offset
    return own and not isinstance(effect, _KNOWN_EFFECTS) and bool(kind.title)


def _contact_moments(answer: LinearisationPoint) -> Array:
    """(n,) about the normals, 0 of contacts that bear none."""
    out = np.zeros(answer.spec.n)
    out[list(answer.scene.soft)] = answer.components[3 * answer.spec.n :]
    return out


def _on_diagonal(out: Array, blocks: Array) -> None:
    """Write blocks (n, 3, 3) on the diagonal of the first 3n rows."""
    for i, block in enumerate(blocks):
        out[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = block


def _skew(a: Array) -> Array:
    """(…, 3, 3) with skew(a) b = a × b."""
    out = np.zeros((*a.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = a[..., 2], -a[..., 1], a[..., 0]
    return out


_Z_AXIS = np.array([0.0, 0.0, 1.0])
