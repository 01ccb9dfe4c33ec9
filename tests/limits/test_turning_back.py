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


# ---------------------------------------------------------------- A finger that touches and slides at once, on the co

PLACES = [
    [-0.018848652947, -0.022651095188, -0.005626381507], [0.026958306719, 0.010928360513, 0.007336254859],
    [-0.014305640772, 0.026367588011, -0.000314554612], [0.027570469221, -0.009894944317, -0.006477600167],
    [0.027421181838, -0.011339016826, 0.004416501336],
]  # fmt: skip
NORMALS = [
    [0.54731471619, 0.578267367088, 0.605023514918], [-0.985944838156, -0.165716180369, -0.021234963547],
    [0.205840700406, -0.943635503828, -0.259194216703], [-0.917008205972, 0.318180506778, 0.24053506041],
    [-0.935316774112, 0.350707083654, 0.046766158056],
]  # fmt: skip
FLEXIBILITY = 1e-4 * np.array([
    1.035564733067, 0.9119802342192, 1.595258035026, 1.338282062753, 0.5370458252978, 1.023093472085, 0.512954313748,
    0.9635766247804, 1.201534366564, 1.042927489212, 1.286215165736, 0.5442131580337, 1.923372698025, 0.8166651780807,
    0.6261851964529,
])  # fmt: skip
PRELOAD = [0.000684846519, 0.000736837659, 0.000456702601, 0.000932364368, 0.000323622398]
LOAD = np.array([-0.728185442248, -1.895207482881, 0.199115608717, 0.008460161166, -0.002233497107, -0.014224723047])


def test_a_finger_that_touches_again_and_slides_at_once_ends_no_path():
    contacts = [hl.Contact(p, m, hl.Coulomb(0.7)) for p, m in zip(PLACES, NORMALS, strict=True)]
    grasp = hl.Grasp(contacts, flexibility=np.diag(FLEXIBILITY), preload=PRELOAD)
    assert grasp.load_limit(LOAD, max_slip=np.inf).factor == np.inf
    assert grasp.follow(20.0 * LOAD, geometry="fixed", steps=60).reached
