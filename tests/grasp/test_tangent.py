"""The equations of an active set: against their definition, contact by contact, and against whole solves."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp.derivatives.active_set import (
    LinearLaws,
    active_rows,
    least_norm_solutions,
    matrix_rank,
    saddle_matrix,
    solve_inverse,
    solve_without_slip,
)
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from tests.grasp.effect_rows import ROWS
from tests.grasp.scenes import pinch, ring
from tests.support.sensitivity import misses

MU, SOFTNESS = 0.7, 2.0
DIAGONAL = np.array([1.0, 1.0]) / np.sqrt(2.0)
# kind, faces that it slides against, slip over friction
WHAT = {
    "separated": (SEPARATED, [], 0.0),
    "resting": (RESTING, [], 0.0),
    "sticking": (STICKING, [], 0.0),
    "gliding": (GLIDING, [], 0.0),
    "sliding against a face": (SLIDING, [DIAGONAL], 0.0),
    "sliding at a corner": (SLIDING, [np.array([1.0, 0.0]), DIAGONAL], 0.0),
    "sliding on a round set": (SLIDING, [-DIAGONAL], 0.3),
}


def system(names, rng, gives=(False, True)):
    """(laws, states, parts): contacts that do these things, and two limits of which these give way."""
    n, c = len(names), 3 * len(names)
    B = rng.normal(size=(c, c))
    E, G, A = B @ B.T + np.eye(c), rng.normal(size=(6, c)), rng.normal(size=(2, c))
    kind, against, turn = (np.array(x) for x in zip(*((k, len(f), t) for k, f, t in map(WHAT.get, names)), strict=True))
    faces = np.zeros((n, 3, 3))
    for i, name in enumerate(names):
        for a, normal in enumerate(WHAT[name][1]):
            faces[i, a, :2] = normal
    contacts = np.array([[3 * i + 2, 3 * i, 3 * i + 1, -1] for i in range(n)])
    kept = np.array([False] * c + [True] * 6 + list(gives))
    laws = LinearLaws(saddle_matrix(E, SOFTNESS, G, A), kept, contacts, np.full(n, MU), SOFTNESS)
    return laws, ContactStates(kind, against, faces, turn), (E * SOFTNESS, G, A)


def reference(names, parts, b, more):
    """The changes, from the laws written down one by one: balance, limits, then each contact's three equations."""
    E, G, A = parts
    c = len(E)
    V, force, none = np.hstack([E, G.T, A.T]), np.eye(c, c + 8), np.eye(c + 8)[c + 6]  # motions, forces, a limit
    rows = [(np.hstack([G, np.zeros((6, 8))]), -b[c : c + 6]), (none, 0.0), (np.append(A[1], np.zeros(8)), -b[c + 7])]
    for i, name in enumerate(names):
        kind, faces, turn = WHAT[name]
        T, N = [3 * i, 3 * i + 1], 3 * i + 2
        if kind in (SEPARATED, RESTING):
            rows.append((force[[*T, N]], np.zeros(3)))
            continue
        rows.append((V[N], -b[N]))
        if kind == STICKING:
            rows.append((V[T], -b[T]))
        elif kind == GLIDING:
            rows.append((force[T], np.zeros(2)))
        rows += [(normal @ force[T] - MU * force[N], more[i]) for normal in faces]
        if len(faces) == 1:
            across = np.array([-faces[0][1], faces[0][0]])
            rows.append((across @ (V[T] + turn * SOFTNESS * force[T]), -across @ b[T]))
    return np.linalg.solve(np.vstack([row for row, _ in rows]), np.hstack([right for _, right in rows]))


@pytest.mark.parametrize("name", WHAT)
@pytest.mark.parametrize("seed", range(3))
def test_each_contact_state_has_its_equations(name, seed):
    rng = np.random.default_rng(seed)
    names = ["sticking", name, "sliding against a face", "sticking"]
    laws, states, parts = system(names, rng)
    A, B = active_rows(laws, states)
    inverse, regular = solve_inverse(A, B, 1e-10)
    b, more = rng.normal(size=len(A)), rng.normal(size=4)
    expected = reference(names, parts, b, more)
    assert regular
    np.testing.assert_allclose(inverse @ np.append(b, more), expected, atol=1e-9 * abs(expected).max())
    again, free = least_norm_solutions(A, (B @ np.append(b, more))[:, None], 1e-10)
    np.testing.assert_allclose(again[:, 0], expected, atol=1e-9 * abs(expected).max())
    assert free.shape == (len(A), 0)
    assert matrix_rank(A) == len(A)


def test_what_no_law_resists_is_found():
    """All contacts open: the object may go anywhere, and nothing answers a load."""
    laws, states, _ = system(["separated", "resting"], np.random.default_rng(0), (False, False))
    A, B = active_rows(laws, states)
    found, free = least_norm_solutions(A, B[:, [6]], 1e-10)
    assert free.shape[1] == 6
    assert np.isnan(found).all()
    assert not solve_inverse(A, B, 1e-10)[1]
    assert matrix_rank(A) == len(A) - 6


# ---------------------------------------------------------------- against whole solves
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_with_every_effect_the_answer_to_a_load_is_that_of_whole_solves(row):
    grasp = row.on()
    solution = grasp.solve(row.faces)
    s = solution.sensitivity()
    assert not [k for k in s.kinks if not k.by]
    for index in ((0,), (1,), (5,)):  # those of a plane, too
        missed = misses(grasp, solution, row.faces, "wrench", index)
        assert max(missed.values()) < 1e-6, (index, missed)


def without_slip(grasp):
    """(n, 3) forces of a grasp under its load in which nothing slips and nothing opens."""
    scene = grasp.scene
    found, _ = solve_without_slip(scene, scene.flexibility, scene.offset[:, None], scene.geometry.wrench[:, None])
    return scene.forces_to_contact_axes(found[:, 0])[: 3 * scene.n].reshape(-1, 3)


def test_without_slip_the_forces_are_those_of_a_solve_where_every_contact_sticks():
    contacts, data = ring(np.random.default_rng(1), n=3, mu=50.0, preload=0.02)
    g = hl.Grasp(contacts, **data)
    s = g.solve()
    assert s.contact_state == ("sticking",) * 3
    np.testing.assert_allclose(without_slip(g), s.forces, atol=1e-9 * abs(s.forces).max())


def test_without_slip_what_is_left_open_is_smallest():
    """Two rigid points, squeezed together by nothing: each bears half of the load, and no more."""
    g = pinch(squeeze=0.0, flexibility=0.0)
    np.testing.assert_allclose(without_slip(g), [[0.5, 0.0, 0.0], [0.5, 0.0, 0.0]], atol=1e-9)
