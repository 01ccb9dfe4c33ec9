"""NSNGRK converges linearly, at the rate that conditioning predicts, in natural units and in no others."""

from functools import cache

import numpy as np
import pytest
from matplotlib.image import imread

import handlcp as hl
from handlcp.studies.paper import example
from tests.lcp.problems import random_p
from tests.support.scripts import script

study = script("paper/convergence")
N = 24


def ring(delta):
    """A circulant of known conditioning, M = δ I + Laplacian of a ring, and a solution z > 0, w = 0: there J = -M.

    Its smallest singular value is δ, and all rows have |g|² = (2 + δ)² + 2.
    """
    M = (2 + delta) * np.eye(N) - np.roll(np.eye(N), 1, 0) - np.roll(np.eye(N), -1, 0)
    z = np.random.default_rng(0).uniform(1, 2, N)
    return hl.LCP(M, -M @ z, units=hl.lcp.Units.ones(N))


def share(delta):
    """σ² / |g|² of that problem."""
    return delta**2 / ((2 + delta) ** 2 + 2)


@cache
def of_example(number, faces):
    return study.convergence(example(number).grasp, faces, seeds=range(1))


def rate(take, delta, seed):
    _, steps, _ = take(ring(delta).scaled, seed, 1e-9, 200_000, 0)
    return study.measured_rate(take(ring(delta).scaled, seed, 1e-9, steps, max(1, steps // 400))[2])


def test_the_jacobian_is_the_derivative_of_phi():
    rng = np.random.default_rng(3)
    M, q = random_p(rng, 7)
    p = hl.LCP(M, q, rng.random(7) < 0.3).scaled
    z, h = rng.normal(size=7), 1e-6

    def phi(z):
        w = p.M @ z + p.q
        return np.where(p.free, w, np.hypot(z, w) - z - w)

    numbers = np.column_stack([(phi(z + h * e) - phi(z - h * e)) / (2 * h) for e in np.eye(7)])
    np.testing.assert_allclose(study.generalized_jacobian(p, z), numbers, atol=1e-8)


def test_bounds_have_their_closed_forms_on_the_ring():
    J = -ring(0.5).M
    gain = share(0.5) / N  # σ² / ‖J‖²_F, as all rows are of one length
    assert study.uniform_bound(J) == pytest.approx(-0.5 * np.log(1 - gain))
    assert study.greedy_bound(J) == pytest.approx(-0.5 * np.log(1 - 0.5 * (N / (N - 1) + 1) * gain))


def test_the_uniform_bound_is_what_a_step_takes_off_the_worst_error():
    J = np.random.default_rng(1).normal(size=(6, 6))
    length = np.linalg.norm(J, axis=1)
    worst = np.linalg.svd(J / length[:, None])[2][-1]
    gain = ((J @ worst / length) ** 2).mean()
    assert study.uniform_bound(J) == pytest.approx(-0.5 * np.log(1 - gain))


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
        assert -0.5 * np.log1p(-gain) >= study.greedy_bound(J)


def test_a_rate_is_the_slope_of_the_logarithm_over_the_second_half():
    k = np.arange(0, 1000, 10.0)
    assert study.measured_rate(np.column_stack([k, np.exp(-0.01 * k)])) == pytest.approx(0.01)
    bent = np.where(k < 400, 1.0, np.exp(-0.02 * (k - 400)))
    assert study.measured_rate(np.column_stack([k, bent])) == pytest.approx(0.02)


@pytest.mark.parametrize("delta", [1.0, 0.4])
def test_rates_are_those_of_a_known_condition(delta):
    bound = -0.5 * np.log(1 - share(delta) / N)
    uniform, greedy = (np.median([rate(take, delta, k) for k in range(3)]) for take in (study.uniform, study.greedy))
    # theory: between once and twice the bound in mean square
    assert 1.7 < uniform / bound < 2.4
    assert 2.5 < greedy / bound < 6  # greedy steps gain more than their bound allows for


@pytest.mark.parametrize(("number", "faces"), [(3, 4), pytest.param(3, 8, marks=pytest.mark.long),
                                               pytest.param(5, 6, marks=pytest.mark.long)])  # fmt: skip
def test_grasps_in_natural_units_converge_at_a_rate_that_conditioning_bounds(number, faces):
    c = of_example(number, faces)
    for r in c.select("natural", "greedy"):
        assert r.converged
        assert 1 < r.rate / r.bound < 25
        np.testing.assert_allclose(r.values[-1], c.answer, rtol=1e-6)
    for r in c.select("natural", "uniform"):
        assert r.converged
        assert 1 < r.rate / r.bound < 5
    assert 1.5 < c.rate() / c.rate("uniform") < 10


@pytest.mark.long
@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6)])
def test_in_metres_and_newtons_it_stands_still_as_conditioning_predicts(number, faces):
    c = of_example(number, faces)
    for r in c.select("given"):
        assert not r.converged
        assert r.bound < 1e-11
        assert abs(r.rate) < 1e-4 < c.rate()
        assert r.stop is not None, "and meets the paper's stop rule"
        assert c.error(r) > 0.002 > 1e-6 > max(c.error(s) for s in c.select())


def test_the_picture_shows_every_run(tmp_path):
    problem, names = example(3).grasp.problem(8), ("finger 1", "finger 2", "finger 3")
    runs = [study.observe(problem, *kind, 0, 3000) for kind in study.KINDS]
    found = study.Convergence(names, example(3).grasp.solve(8).normal_force, tuple(runs))
    image = imread(study.draw(found, tmp_path / "c.png", "A title", ("Table 7", 0.945)))[..., :3]
    assert image.shape[1] == 1600
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00), (0xB8, 0x78, 0x00)):
        assert (abs(image - np.array(colour) / 255).max(-1) < 0.05).sum() > 200


@pytest.mark.long
def test_the_script_writes_its_pictures(tmp_path):
    assert all(path.stat().st_size > 20_000 for path in study.main(tmp_path, range(2)))
