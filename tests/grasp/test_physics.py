"""Laws that every solution obeys, whatever the scene: energy, oracle, invariance."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import ring
from tests.oracle import every_solution
from tests.support import patches
from tests.support.grasp import arrays, at_centre

SEEDS = range(12)


def solved(seed, faces=8, **more):
    contacts, data = ring(np.random.default_rng(seed), **more)
    g = hl.Grasp(contacts, **data)
    return g, g.solve(faces, throw=False)


@pytest.mark.parametrize("seed", SEEDS)
def test_energy_and_forces_balance_and_forces_stay_in_the_circular_cone(seed):
    """Work of the load on u = elastic energy stored twice over + work against the preload + friction's loss ≥ 0."""
    g, s = solved(seed)
    if not s.held:
        pytest.skip("this scene has no solution")
    r, E = s.forces.ravel(), arrays(g).flexibility
    work = arrays(g).wrench @ at_centre(g, s)
    loss = -(s.tangential_force * s.slip).sum()
    np.testing.assert_allclose(work, r @ E @ r + r @ g.offset.ravel() + loss, atol=1e-10 * abs(r @ E @ r))
    assert loss >= -1e-12 * (r @ E @ r)
    F, p = s.forces_world, np.array([c.position for c in g.contacts])
    np.testing.assert_allclose(F.sum(0), -arrays(g).force, atol=1e-8 * abs(F).max())
    np.testing.assert_allclose(np.cross(p, F).sum(0), -arrays(g).moment, atol=1e-9 * abs(F).max())
    slack = 0.6 * s.normal_force - np.linalg.norm(s.tangential_force, axis=1)
    assert (slack > -1e-8 * abs(F).max()).all()  # inscribed pyramids lie inside


@pytest.mark.parametrize("seed", SEEDS)
def test_small_scenes_agree_with_the_enumeration_of_all_active_sets(seed):
    contacts, data = ring(np.random.default_rng(seed), n=3)
    g = hl.Grasp(contacts, **data)
    p = g.problem(3)
    assert p.eliminated
    assert p.n == 12
    oracle = every_solution(p.scaled.M, p.scaled.q)
    s = g.solve(3, throw=False)
    assert s.held == bool(oracle)
    if s.held:
        found = [p.candidate(z).forces for z in oracle]
        assert min(abs(f - s.forces).max() for f in found) < 1e-7 * abs(s.forces).max()


@pytest.mark.parametrize("seed", SEEDS)
def test_mixed_and_eliminated_problems_have_the_same_answer(seed, monkeypatch):
    g, s = solved(seed)
    if not s.held:
        pytest.skip("this scene has no solution")
    patches.nothing_is_eliminated(monkeypatch)
    assert not g.problem().eliminated
    for solver in (None, hl.Lemke()):
        mixed = g.solve(8, solver, throw=False)
        if mixed.held and s.uniqueness.loose_motions == 0:
            known = [s.forces, *(e.forces for e in g.equilibria(8))]  # Lemke's method may find another one
            assert any(np.allclose(mixed.forces, f, atol=1e-6 * abs(f).max()) for f in known)
        else:
            assert solver is None  # Lemke solves whatever the chain solves here


@pytest.mark.parametrize("plane", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, 0.8), tuple(np.ones(3) / np.sqrt(3))])
def test_a_planar_scene_is_the_same_in_every_plane(plane):
    n = np.asarray(plane, float)
    a = np.cross(n, [0.3, 0.5, 0.7])
    a /= np.linalg.norm(a)
    b = np.cross(n, a)
    angles = np.array([0.1, 2.0, 4.3])
    flat = [hl.Contact((np.cos(t), np.sin(t)), (-np.cos(t), -np.sin(t)), hl.Coulomb(0.4)) for t in angles]
    there = [
        hl.Contact(a * np.cos(t) + b * np.sin(t), -a * np.cos(t) - b * np.sin(t), hl.Coulomb(0.4),
                   tangent=-a * np.sin(t) * np.sign(1) + b * np.cos(t))
        for t in angles
    ]  # fmt: skip
    s = hl.Grasp(flat, (1.0, -2.0, 0.1), flexibility=1e-3, preload=0.01).solve()
    w = np.r_[a * 1.0 + b * -2.0, n * 0.1]
    t = hl.Grasp(there, w, flexibility=1e-3, preload=0.01, plane=plane).solve()
    np.testing.assert_allclose(t.normal_force, s.normal_force, rtol=1e-9)
    np.testing.assert_allclose(abs(t.tangential_force), abs(s.tangential_force), atol=1e-9)
    np.testing.assert_allclose(t.object_displacement[3:], n * s.object_displacement[5], atol=1e-12)
    assert len(t.forces_world @ n) == 3
    np.testing.assert_allclose(t.forces_world @ n, 0, atol=1e-12)


def test_circumscribed_pyramids_allow_more_than_inscribed_ones():
    contacts, data = ring(np.random.default_rng(1))
    g = hl.Grasp(contacts, **data)
    inside, outside = g.solve(hl.Pyramid(8)), g.solve(hl.Pyramid(8, inscribed=False))
    limit = np.linalg.norm(outside.tangential_force, axis=1) / outside.normal_force
    assert (limit <= 0.6 / np.cos(np.pi / 8) + 1e-9).all()
    assert inside.held
