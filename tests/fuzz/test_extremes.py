"""Friction, torsion, stiffness, squeeze and size from 1e-14 to 1e14: right, undecided or refused, and never wrong.

An answer is judged by its laws written out in newtons, metres and radians, each measured by what it does to the grasp,
and not in the coordinates that the solver works in. A proof that nothing holds is judged by witnesses: forces and
motions found for other coefficients, none of them sliding, that these coefficients allow as well.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import handlcp as hl

SEEDS = range(40) if os.environ.get("HANDLCP_HARD") == "1" else (1, 3)
SIZES = [10.0**e for e in (-14, -9, -3, -1, 2, 6, 12, 14)]
ENOUGH = 1e-5


@dataclass(frozen=True)
class Scene:
    """Fingers around a waist, two joints each, pads, an arbitrary load, a squeeze."""

    p: np.ndarray
    z: np.ndarray
    E: np.ndarray
    w: np.ndarray
    squeeze: float
    witnesses: list = field(default_factory=list)
    proofs: list = field(default_factory=list)

    def grasp(self, *laws):
        """The grasp with one law for all contacts, or one for each."""
        each = laws * len(self.p) if len(laws) == 1 else laws
        contacts = [hl.Contact(p, z, law) for p, z, law in zip(self.p, self.z, each, strict=True)]
        return hl.Grasp(contacts, self.w, flexibility=self.E, preload=self.squeeze)


def scene(seed):
    rng = np.random.default_rng(seed)
    n = 2 + seed % 3
    t = 2 * np.pi * np.arange(n) / n + rng.uniform(-0.2, 0.2, n)
    out = np.column_stack([np.cos(t), np.sin(t), 0.2 * rng.uniform(-1, 1, n)])
    out /= np.linalg.norm(out, axis=1)[:, None]
    J = rng.normal(size=(3 * n, 2 * n)) * np.kron(np.eye(n), np.ones((3, 2))) * 0.05
    w = np.r_[rng.normal(size=3), 0.02 * rng.normal(size=3)]
    return Scene(0.03 * out, -out, J @ J.T + 1e-4 * np.eye(3 * n), w, 5e-3)


def coefficients(law):
    """Along x, along y, and of the moment [m]."""
    if isinstance(law, hl.AnisotropicCoulomb):
        return law.mu_x, law.mu_y, 0.0
    return law.mu, law.mu, getattr(law, "mu_torsion", 0.0)


def used(law, f, moment):
    """(n,) share of the friction limit; nothing is all of nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = [
            np.where(a == 0, 0.0, a / m) for a, m in zip((f[:, 0], f[:, 1], moment), coefficients(law), strict=True)
        ]
        return np.where(f[:, 2] > 0, np.sqrt(sum(x**2 for x in parts)) / f[:, 2], 0.0)


def missed(case, law, s, faces):
    """The worst law, of balance, contact and friction: a tenth of friction's limit to spare means no slip."""
    f, u = s.forces, s.object_displacement
    moment = np.zeros(len(f)) if s.torsion is None else s.torsion
    R = np.array([c.rotation for c in case.grasp(law).contacts])
    centre, F = case.p.mean(0), max(float(abs(f).max()), 1e-300)
    L = float(np.sqrt(((case.p - centre) ** 2).sum(1).mean()))
    world = np.einsum("nij,nj->ni", R, f)
    lost = world.sum(0) + case.w[:3]
    turned = np.cross(case.p, world).sum(0) + (R[:, :, 2] * moment[:, None]).sum(0) + case.w[3:]
    worst = [np.linalg.norm(lost) / F, np.linalg.norm(turned) / (F * L)]
    bent = (case.E @ f.ravel()).reshape(-1, 3)
    moved = np.einsum("nji,nj->ni", R, u[:3] + np.cross(u[3:], case.p))
    v = moved + bent - [0.0, 0.0, case.squeeze]
    spin = np.einsum("nj,j->n", R[:, :, 2], u[3:])
    V = np.maximum(np.max([abs(bent), abs(moved)], axis=(0, 2)), case.squeeze)
    worst += [-f[:, 2].min() / F, -(v[:, 2] / V).min(), np.minimum(f[:, 2] / F, abs(v[:, 2]) / V).max()]
    share = used(law, f, moment)
    worst.append(max(0.0, float((share - 1.0).max())) * min(1.0, law.mu))
    idle = (share < (0.9 if faces == "cone" else 0.6)) & (f[:, 2] > 1e-6 * F)
    slips = np.hypot(v[:, 0], v[:, 1]) / V
    if isinstance(law, hl.SoftFinger):  # counts as much as the moment that could hinder it
        give = law.torsional_flexibility * moment
        turns = abs(spin + give) / np.max([V / L, abs(spin), abs(give)], axis=0)
        slips = np.maximum(slips, turns * np.minimum(1.0, law.mu_torsion * f[:, 2] / (F * L)))
    worst.append(float(slips[idle].max(initial=0.0)))
    return max(worst)


def wrong(case, make, x, faces):
    """Why the answer is wrong; "" where it is right, undecided or refused."""
    try:
        law = make(x)
        s = case.grasp(law).solve(faces, throw=False)
    except hl.InputError:
        return ""
    if s.held and not missed(case, law, s, faces) < ENOUGH:
        return f"{law} {faces}: misses its laws by {missed(case, law, s, faces):.1e}"
    turned = 0.0 if s.spin is None else abs(s.spin).max()
    if s.held and abs(s.slip[s.forces[:, 2] > 0]).max() <= 1e-9 * case.squeeze and turned <= 1e-9:
        case.witnesses.append((law, s))
    if s.status in (hl.Status.NO_EQUILIBRIUM, hl.Status.NOT_HOLDABLE):
        case.proofs.append((law, s.status))
    return ""


def contradicted(case):
    """Proofs that nothing holds, beside forces that do."""
    return [
        f"{status.name} of {law}, which the forces of {other} satisfy"
        for law, status in case.proofs
        for other, s in case.witnesses
        if like(law, other) and (used(law, s.forces, np.zeros(1) if s.torsion is None else s.torsion) < 0.5).all()
    ]


def like(law, other):
    """Whether they differ in their coefficients alone."""
    return type(law) is type(other) and all(
        getattr(x, "torsional_flexibility", 0.0) == getattr(law, "torsional_flexibility", 0.0) for x in (law, other)
    )


LAWS = {
    "torsion": lambda x: hl.SoftFinger(0.5, x, 3.0),
    "torsion, rigid pads": lambda x: hl.SoftFinger(0.5, x),
    "friction beside torsion": lambda x: hl.SoftFinger(x, 0.01, 3.0),
    "both": lambda x: hl.SoftFinger(x, 0.01 * x, 3.0),
    "friction": hl.Coulomb,
    "one direction": lambda x: hl.AnisotropicCoulomb(0.7, x),
    "torsional flexibility": lambda x: hl.SoftFinger(0.5, 0.01, x),
}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("faces", ["cone", 8])
@pytest.mark.parametrize("name", LAWS)
def test_coefficients_of_any_size(name, faces, seed):
    case = scene(seed)
    found = [why for x in SIZES if (why := wrong(case, LAWS[name], x, faces))]
    assert not found + contradicted(case)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("size", [1e-14, 1e14])
def test_the_same_grasp_in_other_units_bears_the_same_forces(seed, size):
    case, law = scene(seed), hl.SoftFinger(0.8, 0.01, 3.0)
    one = case.grasp(law).solve("cone", throw=False)
    soft = replace(case, E=size * case.E, squeeze=size * case.squeeze)
    strong = replace(case, E=case.E / size, w=size * case.w)
    large = replace(case, p=size * case.p, E=size * case.E, w=case.w * np.repeat([1, size], 3), squeeze=size * 5e-3)
    for other, of_law, force in (
        (soft, hl.SoftFinger(0.8, 0.01, 3.0 * size), 1.0),
        (strong, hl.SoftFinger(0.8, 0.01, 3.0 / size), size),
        (large, hl.SoftFinger(0.8, 0.01 * size, 3.0 / size), 1.0),
    ):
        s = other.grasp(of_law).solve("cone", throw=False)
        assert s.status is one.status
        if s.held:
            np.testing.assert_allclose(s.forces / force, one.forces, atol=1e-7 * abs(one.forces).max())
