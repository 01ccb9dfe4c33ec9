"""Elimination along the arrow against dense linear algebra, also where blocks are no good or fingers are coupled."""

import numpy as np
import pytest

from tests.support.lcp import Reordered


def system(rng, contacts=6, border=6, coupled=(), rigid=(), pairs=0):
    """(M, role, blocks) of that many friction blocks and pairs: flexibility blocks, and a full border."""
    k = 3 * contacts + pairs
    n = k + border
    M = np.zeros((n, n))
    for i in range(contacts):
        A = rng.normal(size=(3, 3))
        b = slice(3 * i, 3 * i + 3)
        M[b, b] = 0.0 if i in rigid else A @ A.T + 0.1 * np.eye(3)
    for i in range(3 * contacts, k):
        M[i, i] = 1.0
    for i, j in coupled:
        M[3 * i, 3 * j] = M[3 * j, 3 * i] = 0.05
    G = rng.normal(size=(border, k))
    M[:k, k:], M[k:, :k] = G.T, -G
    blocks = 3 * np.arange(contacts)[:, None] + np.arange(3)
    role = np.where(np.arange(n) < k, 1, 0)
    role[blocks[:, 1:]] = 2
    shuffle = rng.permutation(n)
    place = np.argsort(shuffle)
    return M[np.ix_(shuffle, shuffle)], role[shuffle], place[blocks]


CASES = {
    "blocks": {},
    "pairs": {"pairs": 3},
    "rigid fingers": {"rigid": (0, 4)},
    "all rigid": {"rigid": (0, 1), "contacts": 2},
    "coupled fingers": {"coupled": ((0, 1), (1, 2), (4, 5))},
    "every finger coupled": {"coupled": tuple((i, j) for i in range(6) for j in range(i))},
    "no border": {"border": 0},
    "no blocks": {"contacts": 0},
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("seed", range(5))
def test_the_arrow_is_the_same_matrix_and_has_the_same_solution(name, seed):
    rng = np.random.default_rng(seed)
    M, role, blocks = system(rng, **CASES[name])
    n = len(M)
    arrow = Reordered(M, role, blocks)
    assert sorted(arrow.order) == list(range(n))
    P = M[np.ix_(arrow.order, arrow.order)]
    x, q = rng.normal(size=n), rng.normal(size=n)
    np.testing.assert_allclose(arrow.multiplied(x, q), P @ x + q, atol=1e-12)

    # some rows of M, some unit vectors, as at contacts that stick and contacts that are open
    open_ = rng.random(n) < 0.3
    open_[arrow.starts[-1] :] = False
    J = np.where(open_[:, None], np.eye(n), P)
    truth = rng.normal(size=n)
    found = arrow.solved(~open_, open_, J @ truth, 1e-12)
    np.testing.assert_allclose(J @ found, J @ truth, atol=1e-9)
    if np.linalg.cond(J) < 1e6:
        np.testing.assert_allclose(found, truth, atol=1e-8)


def test_blocks_are_as_many_as_are_not_coupled():
    rng = np.random.default_rng(0)
    assert Reordered(*system(rng)).blocks == 6
    assert Reordered(*system(rng, coupled=((0, 1), (1, 2)))).blocks == 5  # the middle one goes to the border
    assert Reordered(*system(rng, coupled=((0, 1), (1, 2), (0, 2)))).blocks == 4


def test_a_stiff_finger_beside_soft_ones_costs_the_soft_ones_no_digits():
    """Eliminating the stiff block would put 1e9 into the border, where the others have 1."""
    rng = np.random.default_rng(1)
    M, role, blocks = system(rng)
    stiff = blocks[2]
    M[np.ix_(stiff, stiff)] *= 1e-9
    arrow, n = Reordered(M, role, blocks), len(M)
    truth = rng.normal(size=n)
    found = arrow.solved(np.ones(n), np.zeros(n), arrow.matrix @ truth, 1e-14)
    np.testing.assert_allclose(found, truth, rtol=1e-11, atol=1e-11)
