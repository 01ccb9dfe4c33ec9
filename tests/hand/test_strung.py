"""All tendons of a hand in one call: each as if alone, compiled or not, and how their arms change."""

from __future__ import annotations

import pickle
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import handlcp as hl
from handlcp.actuation import Around, Pulley, Route, Site
from handlcp.errors import InputError
from handlcp.hand import example_hand
from tests.support.kernels import interpreted

from .conftest import inside

Y = (0.0, 1.0, 0.0)


@cache
def cabled(friction=0.0):
    """Two flexors round cylinders, an extensor round a ball on the other side, and a differential."""
    routes = dict[str, Route]()
    for k, a in ((1, 0.0), (2, 2 * np.pi / 3), (3, -2 * np.pi / 3)):
        near, far, s = f"finger_{k}_proximal_link", f"finger_{k}_distal_link", 1.0 if k == 3 else -1.0
        r = 0.045 + s * 0.012
        shape = "sphere" if k == 3 else "cylinder"
        at = (0, 0, 0.05) if k == 3 else ((0, 0, 0.05), Y)
        routes[f"cable {k}"] = Route([
            Site("palm", (r * np.cos(a), r * np.sin(a), -0.005)), Site(near, (s * 0.009, 0.002, 0.02)),
            Around(near, at, 0.006, shape, (s * 0.02, 0, 0.05)), Site(far, (s * 0.004, -0.001, 0.015)),
        ])  # fmt: skip
    if not friction:
        first, second = (routes[f"cable {k}"].places[:2] for k in (1, 2))
        routes["pair"] = Route([Pulley(2), *first, Pulley(2), *second])
    return example_hand("three_finger", joint_stiffness=hl.Tendons(routes, 3e4, 1.0, pretension=2.0, friction=friction))


def postures(hand, n):
    return np.random.default_rng(1).uniform(-0.5, 0.9, (n, hand.nv))


def alone(hand):
    return [route.bound(hand.kinematics) for route in hand.stiffness.routes.values()]


def test_a_hand_has_the_arms_and_lengths_of_each_route():
    hand = cabled()
    wraps = 0
    for q in postures(hand, 5):
        there, paths = hand.posed(q).stiffness, [bound.at(q) for bound in alone(hand)]
        np.testing.assert_array_equal(there.arms, [path.arms for path in paths])
        lengths = -there.cables.shift - there.arms @ q
        np.testing.assert_allclose(lengths, [path.length for path in paths], rtol=0.0, atol=1e-16)
        wraps += sum(int(np.count_nonzero(path.angles)) for path in paths)
    assert 0 < wraps < 15


def test_posts_are_the_round_bodies_in_their_order_whether_touched_or_not():
    """μ θ, and the arms of what comes after."""
    hand = cabled(0.2)
    for q in postures(hand, 5):
        cables = hand.posed(q).stiffness.cables
        assert cables.post_tendon.tolist() == [0, 1, 2]
        for bound, grip, row in zip(alone(hand), cables.wrap_friction, cables.posts, strict=True):
            path = bound.at(q)
            assert grip == pytest.approx(0.2 * path.angles[0], abs=1e-16)
            if grip:
                np.testing.assert_allclose(row, path.pieces[-1].arms, atol=1e-17)


def test_compiled_or_not_it_is_the_same():
    hand = cabled()
    for q in postures(hand, 2):
        for bound in alone(hand):
            compiled, slope = bound.at(q), bound.slope(q)
            with interpreted():
                plain = bound.at(q)
                np.testing.assert_allclose(bound.slope(q), slope, atol=1e-9)
            assert plain.length == pytest.approx(compiled.length, rel=1e-15)
            np.testing.assert_allclose(plain.arms, compiled.arms, atol=1e-16)
            np.testing.assert_allclose(plain.angles, compiled.angles, atol=1e-14)


def by_differences(bound, q, step=1e-6):
    return np.array([(bound.at(q + d).arms - bound.at(q - d).arms) / (2 * step) for d in step * np.eye(len(q))])


def test_how_arms_change_is_what_central_differences_of_them_say(coupled):
    """Also of joints that others follow."""
    hand = cabled()
    for q in postures(hand, 3):
        for bound in alone(hand):
            np.testing.assert_allclose(bound.slope(q), by_differences(bound, q), atol=1e-9)
    route = Route([Site("palm", (0.0, 0.03, 0.0)), Site("a", (0.02, 0.0, 0.01)),
                   Around("b", ((0.02, 0.0, 0.0), (0.0, 0.0, 1.0)), 0.004), Site("c", (0.02, 0.01, 0.0)),
                   Pulley(1.5), Site("c", (0.0, 0.0, 0.02)), Site("d", (0.03, 0.0, 0.0))])  # fmt: skip
    bound = route.bound(coupled.kinematics)
    for seed in range(4):
        q = inside(coupled, seed)
        np.testing.assert_allclose(bound.slope(q), by_differences(bound, q), atol=1e-9)


def test_tensions_weigh_how_arms_change_and_rigid_joints_feel_none_of_it():
    hand = cabled()
    q, T = postures(hand, 1)[0], np.array([3.0, 0.0, 1.0, 2.0])
    slopes = np.array([bound.slope(q) for bound in alone(hand)])
    turning = hand.posed(q).stiffness.cables.moment_arm_stiffness
    np.testing.assert_allclose(turning(T), np.tensordot(T, slopes, 1), atol=1e-12)
    first = hand.joint_names[0]
    springs = {name: np.inf if name == first else 1.0 for name in hand.joint_names}
    rigid = hand.replace(joint_stiffness=hl.Tendons(hand.stiffness.routes, 3e4, springs)).posed(q).stiffness.cables
    expected = np.tensordot(T, slopes, 1)
    expected[0] = expected[:, 0] = 0.0
    np.testing.assert_allclose(rigid.moment_arm_stiffness(T), expected, atol=1e-12)


def test_a_hand_with_routes_is_pickled():
    hand = cabled()
    again = pickle.loads(pickle.dumps(hand))
    for q in postures(hand, 2):
        np.testing.assert_array_equal(again.posed(q).stiffness.root, hand.posed(q).stiffness.root)


def test_hands_that_share_tendons_have_arms_of_their_own():
    """The same routes on links of other sizes: nothing is remembered of one hand for the other."""
    hand = cabled()
    q = postures(hand, 1)[0]
    stiffness = hand.posed(q).stiffness
    other = example_hand("three_finger", joint_stiffness=1.0)
    there = stiffness.in_posture(other.kinematics, q)
    np.testing.assert_allclose(there.arms, stiffness.arms, atol=1e-16)
    assert there is not stiffness


def test_friction_at_posts_of_several_branches_is_refused():
    """Also where they share the tension alike: what one branch loses the other does not miss."""
    routes = [cabled().stiffness.routes[f"cable {k}"].places for k in (1, 2)]
    pair = Route([Pulley(2), *routes[0], Pulley(2), *routes[1]])
    with pytest.raises(InputError, match="0 for 'pair', which a pulley divides"):
        example_hand("three_finger", joint_stiffness=hl.Tendons({"pair": pair}, 3e4, 1.0, friction=0.1))
    assert all(a.leg < b.leg for a, b in pairwise(pair.bound(cabled().kinematics).at(cabled().neutral).pieces[::3]))
