"""Which single change buys most load: against a pinch by hand, and as promises that the answer keeps."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from tests.design.hands import cube_grasp, pinch
from tests.hand.levers import MU, L

N = 2.0  # N of grip


def by_change(found):
    return {t.what: t for t in found.tried}


def test_of_a_pinch_that_slips_grip_and_friction_buy_their_share_and_stiffness_nothing(tmp_path):
    found = pinch(tmp_path, (0, 0, -1.0), limits=10.0, grip_force=N).best_change(share=0.2, geometry="fixed")
    assert found.before.factor == pytest.approx(2 * MU * N, rel=1e-6)
    tried = by_change(found)
    assert tried["20 % more grip"].factor == pytest.approx(1.2 * 2 * MU * N, rel=1e-6)
    assert tried["20 % more friction"].gain == pytest.approx(0.2, rel=1e-6)
    assert tried["20 % less grip"].gain == pytest.approx(-0.2, rel=1e-6)
    for what in ("20 % more torque", "joints 20 % stiffer", "joints 20 % softer"):
        assert tried[what].gain == pytest.approx(0.0, abs=1e-6)
    assert found.best.gain == pytest.approx(0.2, rel=1e-6)
    assert found.confirmed
    assert found.verdicts == ("HELD", "NOT HELD")
    assert found.why_not == ""
    assert 2 * MU * N < found.between < found.best.factor


def test_of_a_pinch_at_its_torque_limit_torque_buys_most_and_less_grip_helps(tmp_path):
    """The left finger bears N plus half of the push, at the lever L."""
    limit = 1.25 * N * L
    found = pinch(tmp_path, (0.5, 0, 0), limits=limit, grip_force=N).best_change(geometry="fixed")
    assert found.before.factor == pytest.approx((limit / L - N) * 2 / 0.5, rel=1e-5)
    tried = by_change(found)
    assert tried["10 % more torque"].factor == pytest.approx((1.1 * limit / L - N) * 2 / 0.5, rel=1e-5)
    assert tried["10 % less grip"].factor == pytest.approx((limit / L - 0.9 * N) * 2 / 0.5, rel=1e-5)
    assert tried["10 % more friction"].gain == pytest.approx(0.0, abs=1e-6)
    assert found.best.what == "10 % more torque"
    assert found.verdicts == ("HELD", "OVER LIMIT")


def test_fingers_without_a_hand_have_preload_friction_and_stiffness():
    contacts = [hl.Contact((s, 0, 0), (-s, 0, 0), hl.Coulomb(0.8), tangent=(0, 0, 1)) for s in (-1.0, 1.0)]
    found = hl.Grasp(contacts, (0, 0, -3.0, 0, 0, 0), flexibility=1e-4, preload=1e-3).best_change()
    tried = by_change(found)
    assert set(tried) == {
        "10 % more preload", "10 % less preload", "10 % more friction", "fingers 10 % stiffer", "fingers 10 % softer"
    }  # fmt: skip
    assert found.before.factor == pytest.approx(2 * 0.8 * 10.0 / 3.0, rel=1e-6)
    assert tried["fingers 10 % stiffer"].gain == pytest.approx(0.1, rel=1e-6)  # what is preloaded presses harder
    assert found.confirmed


def test_changes_are_ranked_and_each_is_the_load_limit_of_the_changed_grasp():
    grasp = cube_grasp().replace(grip_force=5.0)
    push = (0, 1, 0, 0, 0, 0)
    found = grasp.best_change(push, geometry="fixed")
    factors = [t.factor for t in found.tried]
    assert factors == sorted(factors, reverse=True)
    tried = by_change(found)
    rough, tight = grasp.replace(friction=0.88), grasp.replace(grip_force=5.5)
    for other, what in ((rough, "10 % more friction"), (tight, "10 % more grip")):
        assert other.load_limit(push, geometry="fixed").factor == pytest.approx(tried[what].factor, rel=1e-6)
    stiff = grasp.state.hand.replace(joint_stiffness=66.0).at(grasp.state.q)
    limit = stiff.grasp(grasp.target, friction=0.8, grip_force=5.0).load_limit(push, geometry="fixed")
    assert limit.factor == pytest.approx(tried["joints 10 % stiffer"].factor, rel=1e-6)


def test_without_a_load_of_its_own_the_weight_grows():
    found = cube_grasp().replace(grip_force=5.0).best_change(geometry="fixed")
    np.testing.assert_allclose(found.wrench, (0, 0, -0.5 * 9.81, 0, 0, 0), atol=1e-12)
    assert found.before.factor > 0
    assert found.of_weight
    said = " ".join(str(found).split())
    assert f"as it is, the grasp holds {found.before.factor:.4g} × the weight in addition" in said
    assert "added to the object's own" in said
    assert "the load check()" not in said


def test_where_check_does_not_say_held_with_the_change_it_says_why():
    hand = hl.example_hand("three_finger", joint_stiffness=60.0)
    box = hl.Box((0.05, 0.05, 0.13), (0.0, 0.0, 0.05), mass=0.1)  # down through the palm
    grasp = hand.at(hand.close_on(box)).grasp(box, friction=0.8, grip_force=5.0)
    found = grasp.best_change(geometry="fixed")
    assert found.verdicts[0] == "UNDECIDED"
    assert "palm" in found.why_not
    assert " ".join(str(found).split()).endswith(f"UNDECIDED with the change and UNDECIDED without: {found.why_not}")


@pytest.mark.parametrize("share", [0.0, 1.0, -0.1, np.nan, "10 %"])
def test_a_share_is_between_0_and_1(share):
    with pytest.raises(InputError):
        cube_grasp().best_change((0, 1, 0, 0, 0, 0), share)
