"""What must not matter where contacts are soft or anisotropic: units, the world's attitude, the fingers' order."""

import numpy as np
import pytest

import handlcp as hl
from tests.hard_cases.scenes import turn

SEEDS = range(8)


def scene(seed):
    """Four fingers around an object, all laws among them, squeezed several times harder than loaded."""
    rng = np.random.default_rng(seed)
    out = []
    for k in range(4):
        a = 2 * np.pi * (k + 0.3 * rng.random()) / 4
        n = np.array([-np.cos(a), -np.sin(a), 0.3 * rng.standard_normal()])
        n /= np.linalg.norm(n)
        t = rng.standard_normal(3)
        kind = ("soft", "soft", "ellipse", "point")[k]
        out.append((-0.03 * n, n, t, kind, rng.uniform(0.3, 0.7), rng.uniform(0.002, 0.006), rng.uniform(1.0, 5.0)))
    load = rng.standard_normal(6) * np.array([1, 1, 1, 0.005, 0.005, 0.005])
    return out, load, 1e-4 * rng.uniform(0.5, 2.0, 3)


def solved(contacts, load, E, faces, squeeze=0.7e-3, length=1.0, force=1.0):
    """In other units, everything `length` and `force` times as large in numbers."""
    made = []
    for p, n, t, kind, mu, mt, c in contacts:
        law = {
            "soft": hl.SoftFinger(mu, mt * length, c / (force * length)),
            "ellipse": hl.AnisotropicCoulomb(mu, 0.4 * mu),
            "point": hl.Coulomb(mu),
        }[kind]
        made.append(hl.Contact(p * length, n, law, t))
    load = load * force * np.array([1, 1, 1, length, length, length])
    return hl.Grasp(made, load, flexibility=E * length / force, preload=squeeze * length).solve(faces)


def everything(s):
    """Forces and moments, contact by contact."""
    return np.column_stack([s.forces_world, s.torsion])


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("seed", SEEDS)
def test_units_of_length_and_force(seed, faces):
    contacts, load, E = scene(seed)
    a, b = solved(contacts, load, E, faces), solved(contacts, load, E, faces, length=1e3, force=1e-3)
    size = abs(a.forces).max()
    np.testing.assert_allclose(b.forces / 1e-3, a.forces, atol=1e-8 * size)
    np.testing.assert_allclose(b.torsion, a.torsion, atol=1e-8 * size * 0.03)
    np.testing.assert_allclose(b.spin, a.spin, atol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_worlds_attitude(seed):
    contacts, load, E = scene(seed)
    Q = turn(np.random.default_rng(seed + 100))
    turned = [(Q @ p, Q @ n, Q @ t, *rest) for p, n, t, *rest in contacts]
    a = solved(contacts, load, E, "cone")
    b = solved(turned, np.append(Q @ load[:3], Q @ load[3:]), E, "cone")
    np.testing.assert_allclose(b.forces, a.forces, atol=1e-8 * abs(a.forces).max())
    np.testing.assert_allclose(b.torsion, a.torsion, atol=1e-9)


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_fingers_order(seed, faces):
    contacts, load, E = scene(seed)
    order = np.random.default_rng(seed).permutation(4)
    a, b = solved(contacts, load, E, faces), solved([contacts[i] for i in order], load, E, faces)
    np.testing.assert_allclose(everything(b), everything(a)[order], atol=1e-8 * abs(a.forces).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_stronger_friction_than_any_force_asks_for_is_sticking_and_linear(seed):
    """Where everything sticks the answer is linear in load and squeeze."""
    contacts, load, E = scene(seed)
    strong = [(*c[:4], 50.0, 5.0, c[6]) for c in contacts]
    a, b = solved(strong, load, E, "cone"), solved(strong, 2.0 * load, E, "cone", squeeze=1.4e-3)
    assert a.contact_state == ("sticking",) * 4
    np.testing.assert_allclose(b.forces, 2.0 * a.forces, atol=1e-8 * abs(a.forces).max())
    np.testing.assert_allclose(b.torsion, 2.0 * a.torsion, atol=1e-9)
