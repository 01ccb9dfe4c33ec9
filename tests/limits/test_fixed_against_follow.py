"""Random grasps in one posture: a limit is where small steps of `follow` lead."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.limits import balanced

LAWS = {
    "coulomb": lambda rng: hl.Coulomb(rng.uniform(0.2, 0.4)),
    "soft": lambda rng: hl.SoftFinger(rng.uniform(0.2, 0.4), rng.uniform(0.003, 0.01)),
    "anisotropic": lambda rng: hl.AnisotropicCoulomb(rng.uniform(0.3, 0.5), rng.uniform(0.2, 0.3)),
}
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)


def random_grasp(seed, law):
    """Four fingers around a ball, whose springs are coupled; and a load."""
    rng = np.random.default_rng(seed)
    points = TETRAHEDRON + 0.1 * rng.normal(size=(4, 3))
    normals = -points / np.linalg.norm(points, axis=1)[:, None]
    contacts = [hl.Contact(0.05 * p, n, LAWS[law](rng)) for p, n in zip(points, normals, strict=True)]
    A = rng.normal(size=(12, 12))
    grasp = hl.Grasp(contacts, flexibility=2e-5 * A @ A.T + 2e-4 * np.eye(12), preload=rng.uniform(2e-3, 4e-3, 4))
    return grasp, np.append(rng.normal(size=3), 0.02 * rng.normal(size=3))


def holds(grasp, load, faces):
    """Whether `follow` reaches a load, and the contacts balance it."""
    end = grasp.follow(load, geometry="fixed", faces=faces)
    return end.reached and balanced(end, load)


CASES = [(0, "coulomb", 6), (0, "coulomb", "cone"), (2, "coulomb", "cone")]
OPEN = [(1, "coulomb", "cone"), (0, "soft", 6), (3, "anisotropic", "cone"), (3, "soft", "cone")]
ENDS = [(0, "coulomb", 6), (20, "coulomb", "cone"), (21, "soft", 6), (10, "coulomb", "cone")]


@pytest.mark.parametrize(("seed", "law", "faces"), OPEN)
def test_follow_goes_on_where_nothing_binds(seed, law, faces):
    grasp, w = random_grasp(seed, law)
    limit = grasp.load_limit(w, faces=faces)
    assert limit.factor == (np.inf if limit.slides is None else limit.slides)
    assert limit.lost is None
    assert holds(grasp, 3.0 * max(e.factor for e in limit.events) * w, faces)


@pytest.mark.parametrize(("seed", "law", "faces"), CASES)
def test_the_forces_at_an_event_are_those_of_follow(seed, law, faces):
    grasp, w = random_grasp(seed, law)
    limit = grasp.load_limit(w, faces=faces)
    path = limit.path
    k = len(path.factors) - 2
    steps = grasp.follow(path.factors[k] * w, geometry="fixed", faces=faces).steps
    size = abs(path.forces[k]).max()
    assert abs(steps.forces[-1] - path.forces[k]).max() < 0.005 * size


@pytest.mark.parametrize(("seed", "law", "faces"), ENDS)
def test_the_end_of_a_path_is_certified(seed, law, faces):
    grasp, w = random_grasp(seed, law)
    limit = grasp.load_limit(w, faces=faces)
    there = limit.at_limit
    assert there.held
    assert abs(there.forces - limit.path.forces[-1]).max() < 1e-6 * abs(there.forces).max()


@pytest.mark.parametrize(("seed", "law"), [(1, "coulomb"), (8, "coulomb"), (4, "soft"), (1, "anisotropic")])
def test_on_flat_laws_a_limit_is_exact_whatever_accuracy_is_asked(seed, law):
    """Friction that slides along a face, into a corner, and out of it where another finger changes."""
    grasp, w = random_grasp(seed, law)
    rough = grasp.load_limit(w, faces=6, accuracy=0.1)
    assert rough.slides is not None
    assert grasp.load_limit(w, faces=6, accuracy=1e-6).factor == pytest.approx(rough.factor, rel=1e-8)
    steps = grasp.follow(1.1 * rough.factor * w, ("squeeze", "load"), geometry="fixed", faces=6, steps=100).steps
    load = steps.stage == steps.stage[-1]
    slid = steps.slipped[load].max(axis=1)
    assert 1.1 * np.interp(1e-3, slid, steps.share[load]) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("seed", "law"), [(5, "coulomb"), (7, "coulomb"), (3, "soft"), (6, "anisotropic")])
def test_on_round_laws_a_limit_is_as_accurate_as_was_asked(seed, law):
    grasp, w = random_grasp(seed, law)
    fine = grasp.load_limit(w, accuracy=1e-6).factor
    for accuracy in (1e-2, 1e-3, 1e-4):
        assert grasp.load_limit(w, accuracy=accuracy).factor == pytest.approx(fine, rel=accuracy)
