"""NSNGRK converges linearly, at the rate that conditioning predicts, in natural units and in no others."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import Units
from handlcp.method.convergence import convergence, generalized_jacobian, greedy_bound, measured_rate, uniform_bound
from handlcp.method.paper import example
from tests.lcp.problems import random_p
from tests.support.study import run_case

N = 24


def ring(delta):
    """A circulant of known conditioning, M = δ I + Laplacian of a ring, and a solution z > 0, w = 0: there J = -M.

    Its smallest singular value is δ, and all rows have |g|² = (2 + δ)² + 2.
    """
    M = (2 + delta) * np.eye(N) - np.roll(np.eye(N), 1, 0) - np.roll(np.eye(N), -1, 0)
    z = np.random.default_rng(0).uniform(1, 2, N)
    return hl.LCP(M, -M @ z, units=Units.ones(N))


def share(delta):
    """σ² / |g|² of that problem."""
    return delta**2 / ((2 + delta) ** 2 + 2)


@cache
def of_ring(delta):
    return convergence(ring(delta), seeds=range(5))


@cache
def of_example(number, faces):
    return convergence(example(number).grasp, faces, seeds=range(3))


def test_the_jacobian_is_the_derivative_of_phi():
    rng = np.random.default_rng(3)
    M, q = random_p(rng, 7)
    p = hl.LCP(M, q, rng.random(7) < 0.3).scaled
    z, h = rng.normal(size=7), 1e-6

    def phi(z):
        w = p.M @ z + p.q
        return np.where(p.free, w, np.hypot(z, w) - z - w)

    numbers = np.column_stack([(phi(z + h * e) - phi(z - h * e)) / (2 * h) for e in np.eye(7)])
    np.testing.assert_allclose(generalized_jacobian(p, z), numbers, atol=1e-8)


def test_bounds_have_their_closed_forms_on_the_ring():
    J = -ring(0.5).M
    gain = share(0.5) / N  # σ² / ‖J‖²_F, as all rows are of one length
    assert uniform_bound(J) == pytest.approx(-0.5 * np.log(1 - gain))
    assert greedy_bound(J) == pytest.approx(-0.5 * np.log(1 - 0.5 * (N / (N - 1) + 1) * gain))


def test_the_uniform_bound_is_what_a_step_takes_off_the_worst_error():
    J = np.random.default_rng(1).normal(size=(6, 6))
    length = np.linalg.norm(J, axis=1)
    worst = np.linalg.svd(J / length[:, None])[2][-1]
    gain = ((J @ worst / length) ** 2).mean()
    assert uniform_bound(J) == pytest.approx(-0.5 * np.log(1 - gain))


def test_the_greedy_bound_holds_for_any_error_that_a_step_has_left():
    rng = np.random.default_rng(2)
    for _ in range(200):
        J, e = rng.normal(size=(4, 4)), rng.normal(size=4)
        g2 = (J * J).sum(1)
        e -= (J[0] @ e) / g2[0] * J[0]
        e /= np.linalg.norm(e)
        r2 = (J @ e) ** 2
        U = r2 / g2 >= 0.5 * ((r2 / g2).max() + r2.sum() / g2.sum())
        gain = (r2[U] * (r2 / g2)[U]).sum() / r2[U].sum()
        assert -0.5 * np.log1p(-gain) >= greedy_bound(J)


def test_a_direction_that_changes_nothing_does_not_count():
    J = np.diag([1.0, 0.5, 0.0])
    assert greedy_bound(J) > 0
    assert uniform_bound(J) == pytest.approx(-0.5 * np.log(1 - 1 / 3))


def test_a_rate_is_the_slope_of_the_logarithm_over_the_second_half():
    k = np.arange(0, 1000, 10.0)
    assert measured_rate(np.column_stack([k, np.exp(-0.01 * k)])) == pytest.approx(0.01)
    bent = np.where(k < 400, 1.0, np.exp(-0.02 * (k - 400)))
    assert measured_rate(np.column_stack([k, bent])) == pytest.approx(0.02)
    assert measured_rate(np.column_stack([k, np.ones(100)])) == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(measured_rate(np.array([[0.0, 1.0], [1.0, 0.5]])))
    assert np.isnan(measured_rate(np.column_stack([k, 0 * k])))


@pytest.mark.parametrize("delta", [1.0, 0.4])
def test_uniform_sampling_takes_the_rate_of_a_known_condition(delta):
    c = of_ring(delta)
    assert all(r.converged for r in c.select(sampling="uniform"))
    assert c.bound(sampling="uniform") == pytest.approx(-0.5 * np.log(1 - share(delta) / N), rel=1e-6)
    # theory: between once and twice the bound in mean square; measured 1.97 to 2.08
    assert 1.8 < c.rate(sampling="uniform") / c.bound(sampling="uniform") < 2.3
    assert 1 < c.rate() / c.bound() < 5  # measured 3.9 to 4.1: greedy steps gain more than their bound allows for


def test_the_rate_falls_with_the_square_of_the_condition():
    for sampling in ("uniform", "greedy"):
        found = of_ring(1.0).rate(sampling=sampling) / of_ring(0.4).rate(sampling=sampling)
        assert found == pytest.approx(share(1.0) / share(0.4), rel=0.15)


@pytest.mark.parametrize(("number", "faces"), [(1, 8), (2, 4), (3, 4), (3, 8), (5, 6)])
def test_grasps_in_natural_units_converge_at_a_rate_that_conditioning_bounds(number, faces):
    c = of_example(number, faces)
    for r in c.select("natural", "greedy"):
        assert r.converged
        assert 1 < r.rate / r.bound < 25  # measured 5.5 to 13: the bound allows for the worst error
    for r in c.select("natural", "uniform"):
        assert r.converged
        assert 1 < r.rate / r.bound < 5  # measured 2.0 to 3.9
    assert 1.5 < c.gain < 10  # measured 2.2 to 5


@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6)])
def test_in_metres_and_newtons_it_stands_still_as_conditioning_predicts(number, faces):
    c = of_example(number, faces)
    for r in c.select("given"):
        assert not r.converged
        assert r.bound < 1e-11
        assert abs(r.rate) < 1e-4 < c.rate()
        assert r.stop is not None, "and meets the paper's stop rule"
        assert c.error(r)[-1] > 0.002 > 1e-6 > max(c.error(s)[-1] for s in c.select())


def test_equilibration_cannot_stand_in_for_natural_units():
    c = of_example(3, 8)
    assert max(c.error(r)[-1] for r in c.select("equilibrated")) > 0.05


@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6)])
def test_runs_as_given_stop_where_the_papers_do(number, faces):
    c, case = of_example(number, faces), run_case(number, faces, range(3))
    for run, printed in zip(c.select("given"), case.printed, strict=True):
        assert run.stop == printed.steps
        np.testing.assert_allclose(run.stopped, printed.normal, rtol=1e-12)
    np.testing.assert_allclose(c.answer, case.ours, rtol=1e-8)
    assert c.spread("given") == pytest.approx(case.spread, rel=1e-3)
    assert c.spread("given") > 0.05 > 1e-6 > c.spread("natural")


def test_finger_forces_come_with_their_names_and_land_on_the_answer():
    c = of_example(3, 8)
    assert c.names == ("finger 1", "finger 2", "finger 3")
    np.testing.assert_allclose(c.answer, [0.934263, 0.934263, 3.96422], rtol=2e-6)  # Table 6
    for r in c.select():
        np.testing.assert_allclose(r.values[-1], c.answer, rtol=1e-7)
        assert (np.diff(r.looks) > 0).all()
        assert r.looks[-1] == pytest.approx(r.history[-1, 0], abs=len(r.history))


def test_any_lcp_will_do_and_equal_seeds_give_equal_runs():
    p = hl.LCP(*random_p(np.random.default_rng(0), 6))
    a, b = (convergence(p, seeds=[4], tol=1e-6, max_iterations=20_000) for _ in range(2))
    assert a.names[0] == "z[0]"
    np.testing.assert_allclose(a.select()[0].values[-1], a.answer, atol=1e-5)
    for r, s in zip(a.runs, b.runs, strict=True):
        np.testing.assert_array_equal(r.history, s.history)
        np.testing.assert_array_equal(r.values, s.values)


@pytest.mark.parametrize(
    ("wrong", "name"),
    [({"problem": 3}, "problem"), ({"faces": "cone"}, "faces"), ({"seeds": []}, "seeds"), ({"seeds": 3}, "seeds"),
     ({"seeds": [-1]}, "seeds"), ({"tol": 0}, "tol"), ({"max_iterations": 0}, "max_iterations"),
     ({"stop": -1}, "stop"), ({"problem": hl.LCP(np.eye(2), [1.0, 2.0])}, "zero")],
)  # fmt: skip
def test_bad_arguments_are_refused_by_name(wrong, name):
    with pytest.raises(hl.InputError, match=name):
        convergence(**{"problem": example(3).grasp, **wrong})
