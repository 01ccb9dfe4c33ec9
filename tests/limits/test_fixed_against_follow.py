"""The path from event to event is the one that `follow` takes in small steps: random grasps in one posture."""

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
