"""Tendons that rub on their posts: closed forms of levers and of a chain, energy, and what is refused."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName
from handlcp.hand import Hand

from .levers import PAD, L, along, lever_hand, lever_pinch

ARM, KT, OWN, GRIP = 0.01, 6e4, 4.0, 0.25  # m, N/m, N·m/rad, μθ
SHUT, PULL = 0.05, 12.0  # rad commanded; N on the object
K, LESS, MORE = OWN + KT * ARM**2, np.exp(-GRIP), np.exp(GRIP)
ASIDE = [PULL, 0.0, 0.0, 0.0, 0.0, 0.0]
ARMS = {f"{side}_flexor": {f"{side}_joint": ARM} for side in ("left", "right")}


def pinch(write, **tendons):
    hand = lever_hand(write, joint_stiffness=hl.Tendons(ARMS, KT, OWN, **({"friction": GRIP} | tendons)))
    return lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=[SHUT] * 2)


def pressed():
    """N of a finger that has closed, and the tension: τ = r T exp(-μθ) - K_p q, with q = N PAD / L."""
    N = LESS * K * SHUT / (L + PAD / L * (LESS * K + (1.0 - LESS) * OWN))
    q = N * PAD / L
    return N, (K * (SHUT - q) + OWN * q) / ARM


@pytest.mark.parametrize("steps", [1, 40])
def test_a_tendon_drawn_around_a_post_loses_the_share_that_its_wrap_takes(write, steps):
    end = pinch(write).follow(order="squeeze", steps=steps, geometry="fixed").last
    N, tension = pressed()
    np.testing.assert_allclose(end.read.forces[:, 2], N, rtol=2e-9 if steps == 1 else 1e-7)
    np.testing.assert_allclose(end.pull.tension, tension, rtol=1e-8)
    np.testing.assert_allclose(end.pull.post_friction, tension * (1.0 - LESS), rtol=1e-8)


@pytest.mark.parametrize("steps", [3, 60])
def test_a_post_holds_a_finger_that_is_pushed_open_until_the_tendon_slides_back(write, steps):
    """T exp(-μθ) at the joint grows to T exp(μθ) while the joint stands still. The other finger goes on closing."""
    path = pinch(write).follow(ASIDE, steps=steps, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    _, tension = pressed()
    still, closes, opens = 1.0 / PAD, along(OWN + LESS * KT * ARM**2), along(OWN + MORE * KT * ARM**2)
    first = ARM * tension * (MORE - LESS) / L / still * (still + closes)
    assert 1.0 < first < PULL - 1.0
    after = first / (still + closes) + (load - first) / (opens + closes)
    expected = np.where(load < first, load / (still + closes), after)
    assert path.reached
    assert (path.steps.forces[-1, :, 2] > 0.0).all()
    np.testing.assert_allclose(moved, expected, atol=2e-7 * expected.max())


CHAIN = """<robot name="chain"><link name="palm"/>{}</robot>"""
PART = """<link name="{s}_{k}"/><joint name="{s}_joint_{k}" type="revolute"><parent link="{parent}"/>
<child link="{s}_{k}"/><axis xyz="0 {axis} 0"/><origin xyz="{x} 0 {z}"/>
<limit lower="-1" upper="1" effort="50" velocity="1"/></joint>"""
END = """<link name="{s}_tip"/><joint name="{s}_end" type="fixed"><parent link="{s}_1"/><child link="{s}_tip"/>
<origin xyz="0 0 0.03"/></joint>"""
RADII = np.array([0.012, 0.009, 0.006])
WRAPS = np.array([0.1, 0.3, 0.2])


def chain(order=(1, 2, 3)):
    """Two fingers of three joints, each pulled by one tendon over three posts; the first link of each presses."""
    parts, arms, wraps = list[str](), dict[str, dict[str, float]](), dict[str, dict[str, float]]()
    for s, axis, x in (("left", 1, -0.01), ("right", -1, 0.01)):
        for k in (1, 2, 3):
            parent = "palm" if k == 1 else f"{s}_{k - 1}"
            x, z = (x, 0.0) if k == 1 else (0, 0.03)
            parts.append(PART.format(s=s, k=k, parent=parent, axis=axis, x=x, z=z))
        parts.append(END.format(s=s))
        arms[s] = {f"{s}_joint_{k}": float(RADII[k - 1]) for k in order}
        wraps[s] = {f"{s}_joint_{k}": float(WRAPS[k - 1]) for k in (1, 2, 3)}
    tendons = hl.Tendons(arms, 3e4, 0.5, friction=wraps)
    hand = Hand.from_urdf(CHAIN.format("".join(parts)), joint_stiffness=tendons, pad_flexibility=PAD)
    drawn = np.tile(RADII / RADII[0] * SHUT, 2)
    law, up = hl.Coulomb(0.5), (0, 0, 1)
    contacts = [hl.Contact((side * 0.01, 0, 0.03), (-side, 0, 0), law, tangent=up) for side in (-1.0, 1.0)]
    return hand.at(np.zeros(6)).grasp(contacts, wrench=(0, 0, 0, 0, 0, 0), reference=(0, 0, 0.03), joint_offset=drawn)


@pytest.mark.parametrize("order", [(1, 2, 3), (3, 1, 2)])
def test_behind_three_posts_a_tendon_pulls_with_what_all_of_them_leave(order):
    """In the order in which it passes them: τ + K_p q = r T exp(-Σ μθ) at each joint."""
    end = chain(order).follow(order="squeeze", geometry="fixed").last
    assert end.read.forces[:, 2].min() > 1.0
    at, moved = [k - 1 for k in order], RADII * end.where.q[:3]
    assert (np.cumsum(moved[at][::-1]) > 0.0).all()  # drawn in around each of them
    pulled = (end.read.torque + 0.5 * end.where.q)[:3] / RADII
    left = end.pull.tension[0] * np.exp(-np.cumsum(WRAPS[at]))
    np.testing.assert_allclose(pulled[at], left, rtol=1e-7)


def test_what_posts_take_is_dissipated(write):
    """All of it but for the steps' error, which halves with the steps; and it never falls."""
    off = []
    for steps in (150, 300):
        found = pinch(write).follow(ASIDE, steps=steps, geometry="fixed").steps
        assert found.dissipated[-1] > 0.01 * found.work[-1]
        assert (np.diff(found.dissipated) >= -1e-12).all()
        off.append(abs(found.work[-1] - found.stored[-1] - found.dissipated[-1]) / found.work[-1])
    assert off[1] < 1e-3
    assert off[1] < 0.6 * off[0]


@pytest.mark.parametrize(
    ("friction", "error", "words"),
    [
        (-0.1, InputError, "Tendons.friction: expected a finite number ≥ 0"),
        ({"thumb": 0.1}, UnknownName, "thumb"),
        ({"left_flexor": {"thumb_joint": 0.1}}, UnknownName, "thumb_joint"),
        ({"left_flexor": {"left_joint": -1.0}}, InputError, r"Tendons.friction\['left_flexor'\]\['left_joint'\]"),
    ],
)
def test_friction_that_cannot_be_is_refused(write, friction, error, words):
    with pytest.raises(error, match=words):
        pinch(write, friction=friction)
