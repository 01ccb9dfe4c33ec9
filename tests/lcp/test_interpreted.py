"""Compiled and as Python, kernels say the same, to rounding."""

import warnings
from itertools import product

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp import Grasp
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support.kernels import interpreted
from tests.support.lcp import projection, uniform_numbers


def both(call):
    """What a call returns compiled, and as Python: without a warning, of which every one is an error here."""
    first = call()
    with interpreted(), warnings.catch_warnings():
        warnings.simplefilter("error")
        return first, call()


def same_solution(call):
    a, b = both(call)
    assert (a.status, a.contact_state) == (b.status, b.contact_state)
    size = max(1.0, float(np.nanmax(abs(a.forces), initial=0.0)))
    np.testing.assert_allclose(a.forces, b.forces, atol=1e-9 * size)
    np.testing.assert_allclose(a.object_displacement, b.object_displacement, atol=1e-9, rtol=1e-9)
    assert type(b.residuals.worst) is float


@pytest.mark.parametrize("faces", ["cone", 3, 8, hl.Pyramid(5, inscribed=False)], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_grasps_compiled_and_as_python(faces, seed):
    contacts, given = ring(np.random.default_rng(seed))
    same_solution(lambda: Grasp(contacts, **given).solve(faces, throw=False))


@pytest.mark.parametrize("faces", ["cone", 6])
def test_soft_fingers_compiled_and_as_python(faces):
    contacts, given = ring(np.random.default_rng(5))
    soft = [hl.Contact(c.position, c.normal, hl.SoftFinger(0.5, 0.005)) for c in contacts]
    same_solution(lambda: Grasp(soft, **given).solve(faces, throw=False))


@pytest.mark.parametrize("faces", ["cone", 4])
@pytest.mark.parametrize("load", [-1.0, -6.0, -1e3])
def test_searches_compiled_and_as_python(faces, load):
    same_solution(lambda: pinch(load=(0, 0, load)).solve(faces, throw=False))


def test_lists_of_equilibria_compiled_and_as_python():
    a, b = both(lambda: cube_example().equilibria(4))
    assert str(a) == str(b)


@pytest.mark.parametrize("solver", [hl.Lemke(), hl.NSNGRK(), hl.NSNGRK(polish=False), hl.SemismoothNewton()], ids=repr)
def test_solvers_compiled_and_as_python(solver):
    rng = np.random.default_rng(3)
    for n in (1, 4, 9):
        A = rng.normal(size=(n, n))
        problem = hl.LCP(A @ A.T + 0.1 * np.eye(n), rng.normal(size=n))
        a, b = both(lambda problem=problem: hl.solve_lcp(problem, solver, throw=False))
        assert a.status is b.status
        np.testing.assert_allclose(a.z, b.z, atol=1e-7, rtol=1e-7)


def test_projections_compiled_and_as_python():
    points = np.random.default_rng(4).uniform(-2.0, 2.0, (20, 2)).tolist()
    for (x, y), faces in product([*points, (0.0, 0.0)], (0, 2, 5)):
        a, b = both(lambda x=x, y=y, faces=faces: projection(x, y, 1.0, 0.5, faces))
        for one, other in zip(a, b, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-13)


def test_random_numbers_compiled_and_as_python():
    """The generator counts on 64 bits that overflow."""
    np.testing.assert_array_equal(*both(lambda: uniform_numbers(2**63 + 7, 50)))
