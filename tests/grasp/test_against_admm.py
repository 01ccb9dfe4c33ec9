"""The exact cone against Pinocchio's ADMM in a proximal loop, which shares no code with the package."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.admm import equilibrium
from tests.grasp.scenes import ring


def natural(contacts, wrench, E, d):
    """(G, E, w, d) of order one about the contacts' centre, from SI; and the unit of force."""
    p = np.array([c.position for c in contacts])
    R = [c.rotation for c in contacts]
    centre = p.mean(0)
    length = np.sqrt(((p - centre) ** 2).sum(1).mean())
    G = np.hstack([np.vstack([F, np.cross(a, F.T).T]) for F, a in zip(R, (p - centre) / length, strict=True)])
    w = np.r_[wrench[:3], (wrench[3:] - np.cross(centre, wrench[:3])) / length]
    force, soft = np.linalg.norm(w), np.trace(E) / len(E)
    return G, E / soft, w / force, d / (soft * force), force


@pytest.mark.parametrize(
    ("seed", "n", "mu", "frictionless"), [(0, 4, 0.6, ()), (1, 5, 0.4, ()), (8, 4, 0.6, ()), (0, 5, 0.6, (2,))]
)
def test_forces_agree_with_admm(seed, n, mu, frictionless):
    contacts, rest = ring(np.random.default_rng(seed), n, mu)
    contacts = [
        hl.Contact(c.position, c.normal, hl.Frictionless()) if i in frictionless else c for i, c in enumerate(contacts)
    ]
    solution = hl.Grasp(contacts, **rest).solve("cone")
    assert "sliding" in solution.contact_state  # where all fingers stick, friction plays no part
    assert solution.uniqueness.forces_determined
    d = np.zeros((n, 3))
    d[:, 2] = -rest["preload"]
    G, E, w, d, force = natural(contacts, rest["wrench"], rest["flexibility"], d.ravel())
    found = equilibrium(G, E, w, d, np.array([c.mu for c in contacts]))
    assert found.converged
    expected = found.forces.reshape(n, 3) * force
    assert abs(solution.forces - expected).max() <= 1e-8 * abs(expected).max()
