"""Loads that a slowly loaded grasp loses, though other equilibria hold more of them: jamming between the fingers."""

import numpy as np
import pytest

import handlcp as hl


def jammed(seed):
    """(grasp, load) in the plane: three fingers with much friction, whose springs couple pressing and sliding."""
    rng = np.random.default_rng(seed)
    turns, tilts = rng.uniform(0, 2 * np.pi, 3), rng.uniform(-0.5, 0.5, 3)
    points = 0.03 * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    normals = -np.stack([np.cos(turns + tilts), np.sin(turns + tilts)], axis=1)
    friction = hl.Coulomb(rng.uniform(0.5, 1.5))
    E = np.zeros((6, 6))
    for i in range(0, 6, 2):
        a, b = 10 ** rng.uniform(-4, -2.5, 2)
        c = rng.uniform(-0.9, 0.9) * np.sqrt(a * b)
        E[i : i + 2, i : i + 2] = [[a, c], [c, b]]
    contacts = [hl.Contact(p, n, friction) for p, n in zip(points, normals, strict=True)]
    grasp = hl.Grasp(contacts, flexibility=E, preload=rng.uniform(0.5e-3, 2e-3, 3))
    return grasp, np.append(rng.normal(size=2), 0.02 * rng.normal())


def bounded(seed):
    """The same, with fingers whose forces have an end."""
    grasp, load = jammed(seed)
    most = grasp.load_limit(load).path.forces[..., 2].max()
    return grasp.replace(effects=[hl.TotalForceBound(3.0 * most)]), load


SEEDS = (40, 80)  # found among the first hundred


@pytest.mark.parametrize("seed", SEEDS)
def test_an_equilibrium_beyond_the_limit_is_reported_beside_it(seed):
    grasp, load = bounded(seed)
    limit = grasp.load_limit(load)
    assert 0.0 < limit.factor < 0.95 * limit.some_equilibrium
    assert limit.some_equilibrium <= limit.bound * (1.0 + 1e-9)
    assert grasp.replace(wrench=limit.some_equilibrium * limit.wrench).solve().held
    told = " ".join(str(limit).split())
    assert told.startswith(f"at {limit.factor:.4g} times the load")
    assert f"found up to {limit.some_equilibrium:.4g} times the load; a load that grows slowly never reaches it" in told


@pytest.mark.parametrize("seed", SEEDS)
def test_a_hand_that_is_loaded_slowly_sees_the_limit_and_not_what_is_beyond(seed):
    grasp, load = jammed(seed)
    limit = grasp.load_limit(load)
    assert grasp.follow(0.99 * limit.load).reached
    assert not grasp.follow(1.01 * limit.load).reached
