"""Seeded grasps for the tests."""

import numpy as np

import handlcp as hl


def ring(rng, n=4, mu=0.6, preload=0.02, shared=True):
    """Two-joint fingers, n of them, around a waist of 30 mm in a random attitude, soft pads, a load of some newtons."""
    t = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    p = np.column_stack([np.cos(t), np.sin(t), rng.uniform(-0.3, 0.3, n)]) * 0.03 @ Q.T
    z = -np.column_stack([np.cos(t), np.sin(t), rng.uniform(-0.1, 0.1, n)]) @ Q.T
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    J = np.zeros((3 * n, 2 * n + 1))
    for i in range(n):
        J[3 * i : 3 * i + 3, 2 * i : 2 * i + 2] = rng.normal(size=(3, 2)) * 0.05
    if shared:
        J[:, -1] = rng.normal(size=3 * n) * 0.02
    E = J @ J.T + np.diag(np.tile([6e-4, 6e-4, 3e-4], n))
    f = rng.normal(size=3)
    wrench = np.r_[f / np.linalg.norm(f) * rng.uniform(1, 5), rng.normal(size=3) * 0.01]
    friction = hl.Coulomb(mu) if mu else hl.Frictionless()
    contacts = [hl.Contact(a, b, friction) for a, b in zip(p, z, strict=True)]
    return contacts, {"wrench": wrench, "flexibility": E, "preload": preload}


def pinch(mu=0.5, squeeze=1e-3, load=(0, 0, -1.0), **more):
    """Two opposing fingers 2 cm apart along x, pads of 1e-4 m/N along every axis."""
    contacts = [
        hl.Contact((-0.01, 0, 0), (1, 0, 0), hl.Coulomb(mu), tangent=(0, 0, 1), name="left"),
        hl.Contact((0.01, 0, 0), (-1, 0, 0), hl.Coulomb(mu), tangent=(0, 0, 1), name="right"),
    ]
    return hl.Grasp(contacts, (*load, 0, 0, 0), **({"flexibility": 1e-4, "preload": squeeze} | more))


def cube_example(faces_mu=0.6):
    """The paper's Example 3: a unit cube of 5 N on three hard fingers."""
    p = [(0, 0.75, 0.75), (0.75, 0, 0.75), (0.75, 0.75, 0)]
    x = [(0, 1, 0), (1, 0, 0), (1, 0, 0)]
    contacts = [hl.Contact(a, n, hl.Coulomb(faces_mu), tangent=t) for a, n, t in zip(p, np.eye(3), x, strict=True)]
    return hl.Grasp(contacts, (0, 0, -5, 0, 0, 0), flexibility=(6e-6, 6e-6, 1.5e-6), reference=(0.5, 0.5, 0.5))
