"""Derivatives of load limits: closed forms of a pinch, jumps of symmetric grasps, and what is printed of both."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp import PathSensitivity
from tests.grasp.scenes import pinch

PAD, SQUEEZE, MU = 1e-4, 1e-3, 0.5
N = SQUEEZE / PAD  # a finger's normal force


@pytest.fixture(scope="module")
def limit():
    return pinch().load_limit(geometry="fixed")


@pytest.fixture(scope="module")
def found(limit):
    return limit.sensitivity()


def test_a_common_change_follows_the_closed_form(limit, found):
    """The pinch holds 2 μ N, with N = squeeze / pad."""
    assert limit.factor == pytest.approx(2 * MU * N, rel=1e-9)
    assert found.factor_by_all_friction == pytest.approx(2 * N, rel=1e-6)
    assert found.factor_by_all_squeeze == pytest.approx(2 * MU / PAD, rel=1e-6)
    assert found.factor_by_all_pads == pytest.approx(-2 * MU * N / PAD, rel=1e-3)


def test_one_finger_of_a_symmetric_pinch_has_no_derivative(found):
    """With less friction at one finger the limit falls by 2 N δμ; with more, the other finger decides: nothing."""
    each = found.factor_by_friction
    ahead, behind, _ = found.sides("factor", "friction")
    assert np.isnan(each).all()
    assert np.isnan(each).tolist() == (abs(ahead - behind) > 0.1 * np.maximum(abs(ahead), abs(behind))).tolist()
    assert found.error("factor", "friction") == pytest.approx(abs(ahead - behind))
    assert "factor_by_friction" in found.jumps
    assert "factor_by_all_friction" not in found.jumps


def test_a_jump_is_no_derivative_whatever_its_size_beside_the_step():
    """An end that falls by a hundredth wherever the two fingers differ, beside a smooth part."""

    def end(spec):
        one, other = (c.mu for c in spec.contacts)
        return {"factor": np.array(one + other - (0.01 if abs(one - other) > 1e-9 else 0.0))}

    found = PathSensitivity(pinch().spec, end)
    assert np.isnan(found.factor_by_friction).all()
    assert found.sides("factor", "friction").ahead == pytest.approx([1 - 0.01 / 1e-5] * 2)
    assert found.factor_by_all_friction == pytest.approx(2.0)
    assert found.jumps == ("factor_by_friction",)
    apart = pinch().spec.with_laws((hl.Coulomb(0.5), hl.Coulomb(0.6)))
    assert np.isfinite(PathSensitivity(apart, end).factor_by_friction).all()


def test_pads_count_where_hand_and_object_are_followed():
    """Against limits of hands with other pads, closed by the same command of the joints."""
    hand, cube = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    q, pad, more = hand.close_on(cube), 1e-4, 1e-7
    held = hand.at(q).grasp(cube, friction=0.8, squeeze=0.005)

    def factor(softness):
        other = hand.replace(pad_flexibility=softness).at(q).grasp(cube, friction=0.8, joint_offset=held.joint_offset)
        return other.load_limit((0, 0, -1.0, 0, 0, 0)).factor

    found = held.load_limit((0, 0, -1.0, 0, 0, 0)).sensitivity().factor_by_all_pads
    assert found == pytest.approx((factor(pad + more) - factor(pad - more)) / (2 * more), rel=1e-4)
    assert found < -100.0


def test_a_heavier_object_loads_the_grasp_once():
    """Against paths of the same grasp of a heavier and of a lighter object, which a weight counted twice misses by half
    the answer and more.
    """
    hand, cube = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    held, h, push = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005), 1e-5, (0, 0.3, -1.0, 0, 0, 0)
    heavier, lighter = (held.replace(mass=0.2 + step) for step in (h, -h))

    lower = (heavier.load_limit(push).factor - lighter.load_limit(push).factor) / (2 * h)
    assert lower < -1.0
    assert held.load_limit(push).sensitivity().factor_by_mass == pytest.approx(lower, rel=1e-2)
    assert held.replace(load=push).load_limit().sensitivity().factor_by_mass == pytest.approx(lower, rel=1e-2)

    sinks = (heavier.follow(steps=8).displacement - lighter.follow(steps=8).displacement) / (2 * h)
    found = held.follow(steps=8).sensitivity().displacement_by_mass[:, 0]
    np.testing.assert_allclose(found, sinks, atol=1e-3 * abs(sinks).max())
