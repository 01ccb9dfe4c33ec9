"""Hands whose tendons run along routes, on followed paths: beside fixed arms, MuJoCo, and closed forms of wraps."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import Hand
from tests.support.hand import agrees_with_mujoco
from tests.support.routed import KT, threes

from .chains import A, chain_hand

FIRST, SECOND, Y = 0.009, 0.006, (0.0, 1.0, 0.0)  # m, m


def on_pulleys(name, x, s):
    """Over two pulleys about the joints, on which the cable lies in every posture that matters."""
    return hl.Route([
        hl.Site("palm", (x - s * 0.02, 0, -0.02)),
        hl.Around("palm", ((x, 0, 0), Y), FIRST, side=(x + s * 0.02, 0, 0)),
        hl.Site(f"{name}_1", (-s * 0.015, 0, 0.025)),
        hl.Around(f"{name}_1", ((0, 0, A), Y), SECOND, side=(s * 0.02, 0, A)),
        hl.Site(f"{name}_2", (-s * 0.015, 0, 0.02)),
    ])  # fmt: skip


def chains(write, routed, friction=0.0):
    """A box between two fingers of two joints, with one tendon each."""
    arms: dict[str, object] = {n: {f"{n}_root": FIRST, f"{n}_end": SECOND} for n in ("left", "right")}
    if routed:
        arms = {n: on_pulleys(n, x, s) for n, x, s in (("left", -0.01, 1.0), ("right", 0.01, -1.0))}
    tendons = hl.Tendons(arms, KT, 1.0, friction=friction)
    hand = chain_hand(write, joint_stiffness=tendons, pad_flexibility=1e-4, tip_radius=0.005)
    box = hl.Box((0.01, 0.02, 0.02), placement=(0, 0, 0.08), mass=0.1)
    return hand.at(np.zeros(4)).grasp(box, friction=0.8, squeeze=0.003)


def test_a_cable_on_pulleys_is_a_tendon_of_fixed_arms(write):
    fixed, routed = (chains(write, along).follow() for along in (False, True))
    np.testing.assert_allclose(routed.steps.tensions, fixed.steps.tensions, rtol=1e-8)
    np.testing.assert_allclose(routed.steps.forces, fixed.steps.forces, atol=1e-8)
    np.testing.assert_allclose(routed.steps.displacement, fixed.steps.displacement, atol=1e-11)
    np.testing.assert_allclose(routed.steps.stored, fixed.steps.stored, atol=1e-8 * fixed.steps.stored[-1])
    np.testing.assert_allclose(routed.steps.work, fixed.steps.work, atol=1e-8 * fixed.steps.work[-1])
    assert routed.solution.held


def test_posts_of_a_route_take_what_its_wraps_say(write):
    """F = T (1 - exp(-μθ)) at the first pulley, of what the drive pulls with, with θ of the end's posture."""
    path = chains(write, True, friction=0.1).follow(order="squeeze")
    bound = on_pulleys("left", -0.01, 1.0).bound(path.state.hand.kinematics)
    first, second = bound.at(path.state.q).angles
    tension, posts = path.steps.tensions[-1, 0], path.last.pull.post_friction[:2]
    left = tension * np.exp(-0.1 * first)
    np.testing.assert_allclose(posts, [tension - left, left * (1 - np.exp(-0.1 * second))], rtol=1e-6)


def test_arms_are_those_of_the_posture_in_which_the_hand_stands(write):
    """A straight cable has the arm of its distance from the joint, which a grasp's stiffness has, too."""
    across = {n: hl.Route([hl.Site("palm", (x - s * 0.02, 0, -0.02)), hl.Site(f"{n}_1", (s * 0.015, 0, 0.02))])
              for n, x, s in (("left", -0.01, 1.0), ("right", 0.01, -1.0))}  # fmt: skip
    hand = chain_hand(write, joint_stiffness=hl.Tendons(across, KT, 1.0), tip_radius=0.005)
    for angle in (0.0, 0.5):
        state = hand.at([angle, 0.0, angle, 0.0])
        a, c, s = np.array([-0.02, -0.02]), np.cos(angle), np.sin(angle)
        b = np.array([[c, s], [-s, c]]) @ [0.015, 0.02]  # x towards the object, z up, seen from the joint
        arm = abs(a[0] * b[1] - a[1] * b[0]) / np.linalg.norm(b - a)
        np.testing.assert_allclose(state.hand.joint_stiffness[0, 0], 1.0 + KT * arm**2, rtol=1e-12)


def test_what_posts_of_routes_take_is_dissipated(write):
    """Work is what is stored and what the pulleys take, the nearer the shorter the steps."""
    off = list[float]()
    for count in (50, 200):
        found = chains(write, True, friction=0.1).follow(order="squeeze", steps=count).steps
        assert found.dissipated[-1] > 0.01 * found.work[-1]
        off.append(abs(found.work[-1] - found.stored[-1] - found.dissipated[-1]) / found.work[-1])
    assert off[1] < 5e-4
    assert off[1] < 0.3 * off[0]


def test_iterates_are_about_as_many_as_where_arms_stay():
    """With Σ T ∂R/∂q in the tangent; without it there were twice as many."""
    routed, fixed = (threes(True, 2.0, along).follow().steps.states for along in (True, False))
    assert np.mean([s.iterates for s in routed]) < 1.3 * np.mean([s.iterates for s in fixed])


def test_mujoco_has_the_same_forces_and_torques():
    """Spatial tendons, which only pull: an extensor goes slack under the load."""
    agrees_with_mujoco(threes(True, 2.0), 0.005, torques=True)


def finger(k, angle):
    """Three joints 40 mm apart that bend towards the middle, and four tendons: long and short ones on both sides."""
    x, y = -0.05 * np.cos(angle), -0.05 * np.sin(angle)
    body, tail = "", ""
    sides = {"flexor": 1.0, "extensor": -1.0}
    way = {f"{size} {side}": "" for size in ("long", "short") for side in sides}
    for j in range(3):
        pos = f'pos="{x} {y} 0" euler="0 0 {angle}"' if j == 0 else 'pos="0 0 0.04"'
        sites = "".join(f'<site name="{side} {k} {j}" pos="{s * 0.008} 0 0.02"/>' for side, s in sides.items())
        sites += "".join(f'<site name="beside {side} {k} {j}" pos="{s * 0.03} 0 0"/>' for side, s in sides.items())
        tip = '<geom type="capsule" size="0.006" fromto="0 0 0.02 0 0 0.03" mass="0.01"/>' if j == 2 else ""
        body += f"""<body name="finger_{k}_{j}" {pos}><joint name="joint_{k}_{j}" axis="0 1 0" range="-0.6 1.4"/>
          <geom name="post {k} {j}" type="cylinder" size="0.006 0.02" euler="1.5707963267948966 0 0" contype="0"
          conaffinity="0" mass="0.01"/>{tip}{sites}"""
        tail += "</body>"
        for name in way:
            side = name.split()[1]
            if j < 1 or name.startswith("long"):
                around = f'<geom geom="post {k} {j}" sidesite="beside {side} {k} {j}"/>'
                way[name] += f'{around}<site site="{side} {k} {j}"/>'
    roots = "".join(f'<site name="root {side} {k}" pos="{(1 - s * 0.18) * x} {(1 - s * 0.18) * y} -0.02"/>'
                    for side, s in sides.items())  # fmt: skip
    tendons = "".join(f'<spatial name="{name} {k}"><site site="root {name.split()[1]} {k}"/>{part}</spatial>'
                      for name, part in way.items())  # fmt: skip
    return roots + body + tail, tendons


def twenty_text(more="", joints=""):
    """Five fingers of three joints and four tendons each, written in MJCF."""
    fingers = [finger(k, 2 * np.pi * k / 5) for k in range(5)]
    return f"""<mujoco model="twenty"><compiler angle="radian" autolimits="true"/><worldbody><body name="palm">
      <geom type="cylinder" size="0.06 0.005" pos="0 0 -0.03" mass="0.1"/>{"".join(b for b, _ in fingers)}</body>
      </worldbody><tendon>{"".join(t for _, t in fingers)}</tendon>{more}</mujoco>""".replace(
        '<joint name="joint_', f'<joint{joints} name="joint_'
    )


def twenty():
    """A ball in five fingers."""
    text = twenty_text()
    routes = hl.tendon_routes(text)
    assert len(routes) == 20
    tendons = hl.Tendons(routes, KT, 0.5, pretension=3.0)
    tips = [f"finger_{k}_2" for k in range(5)]
    hand = Hand.from_mjcf(text, tips, joint_stiffness=tendons, pad_flexibility=1e-4)
    ball = hl.Sphere(0.03, (0, 0, 0.09), mass=0.2)
    return hand.at(hand.close_on(ball)).grasp(ball, friction=0.7, squeeze=0.01, wrench=[1.5, 0.5, 0, 0, 0, 0])


@pytest.mark.long
def test_a_whole_hand_of_twenty_tendons_is_as_in_mujoco():
    agrees_with_mujoco(twenty(), 0.02, torques=True)
