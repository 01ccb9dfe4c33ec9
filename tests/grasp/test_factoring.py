"""E given as a matrix of many contacts: the factor that is found in it, and answers that stay those of the matrix."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.support.power import STRONG, WEAK, factor_of, power_grasp


def formed(factor) -> np.ndarray:
    """E of (J, A, P)."""
    J, A, P = factor
    E = J @ A @ A.T @ J.T
    for i, block in enumerate(P):
        E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] += block
    return E


def off(E: np.ndarray, factor) -> float:
    """Largest difference, each contact measured by its own softness."""
    size = np.sqrt(np.repeat(np.diag(E).reshape(-1, 3).max(axis=1), 3))
    return float((abs(formed(factor) - E) / size / size[:, None]).max())


@pytest.mark.parametrize("n", [30, 45, 60])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_factor_of_a_hand(n, seed):
    """No more columns than joints, and pads that give way in every direction."""
    E = power_grasp(n, seed).flexibility
    factor = factor_of(E)
    assert off(E, factor) < 1e-11
    assert factor.rows.shape[1] <= 16
    assert min(np.linalg.eigvalsh(P)[0] for P in factor.pads) > 0.0


def test_a_wrist_couples_all_fingers():
    g = power_grasp(40, 3)
    wrist = 0.02 * np.random.default_rng(0).normal(size=(120, 2))
    E = g.flexibility + wrist @ wrist.T
    factor = factor_of(E)
    assert off(E, factor) < 1e-10
    assert factor.rows.shape[1] <= 18


def test_what_two_contacts_share_is_split_between_them():
    """No third contact says whose it is: any split that leaves both of them something is right."""
    rng, E = np.random.default_rng(1), np.zeros((90, 90))
    for pair in range(15):
        J = rng.normal(size=(6, 2))
        E[6 * pair : 6 * pair + 6, 6 * pair : 6 * pair + 6] = J @ J.T + 1e-3 * np.eye(6)
    factor = factor_of(E)
    assert off(E, factor) < 1e-12
    assert factor.rows.shape[1] == 30
    assert min(np.linalg.eigvalsh(P)[0] for P in factor.pads) > 0.0


def test_pads_alone_have_no_columns():
    E = np.diag(np.linspace(1e-5, 1e-3, 90))
    assert factor_of(E).rows.shape == (90, 0)
    assert off(E, factor_of(E)) < 1e-15


def test_no_factor():
    """Of a matrix of full rank, of one whose contacts are rigid in some direction, and of few contacts."""
    A = np.random.default_rng(0).normal(size=(90, 90))
    assert factor_of(A @ A.T) is None
    J = power_grasp(30, 0).jacobian
    assert factor_of(J @ J.T) is None
    assert factor_of(power_grasp(29, 0).flexibility) is None


@pytest.mark.parametrize(("n", "seed", "mu"), [(30, 0, STRONG), (40, 2, WEAK), (45, 1, STRONG), (60, 4, STRONG)])
@pytest.mark.parametrize("faces", ["cone", 8])
def test_the_answer_stays_that_of_the_matrix(n, seed, mu, faces):
    g = power_grasp(n, seed, mu, loaded=False)
    a, b = g.as_matrix().solve(faces, throw=False), g.dense().solve(faces, throw=False)
    assert a.status is b.status
    if a.held:
        assert abs(a.forces - b.forces).max() < 1e-9 * abs(a.forces).max()
        assert abs(a.gap - b.gap).max() < 1e-9 * abs(a.gap).max()
        assert a.contact_state == b.contact_state
        assert b.residuals.worst < 1e-8


def test_a_matrix_that_is_no_hands_is_solved_as_before():
    g, rng = power_grasp(30, 0, STRONG, loaded=False), np.random.default_rng(2)
    A = 1e-3 * rng.normal(size=(90, 90))
    grasp = hl.Grasp(g.contacts, g.wrench, flexibility=g.flexibility + A @ A.T, offset=g.offset)
    assert grasp.scene.factor is None
    assert grasp.solve(throw=False).status.name in ("SOLVED", "NO_EQUILIBRIUM", "UNDECIDED")
