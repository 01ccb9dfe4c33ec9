"""Joints that yield at their torque limit, against answers written down; certificates; no limit, no cost."""

from pathlib import Path

import numpy as np
import pytest

from handlcp import Grasp, GraspStream, Status, TorqueSaturation
from handlcp.errors import InputError
from handlcp.hand import HandGraspSolution
from handlcp.scene import read
from handlcp.viz.solution_output import solution_record
from tests.support.grasp import arrays, at_centre, judged
from tests.support.refusals import refused
from tests.support.scene_texts import BOX_IN_TWO_FINGERS
from tests.support.texts import says

from .levers import MU, PAD, C, K, L, lever_hand, lever_pinch

SQUEEZE = 5e-3  # m: 12 N a finger, 0.95 N·m, where no joint yields
SECTIONS = [8, "cone"]
EXACT = {"rtol": 1e-9, "atol": 1e-14}


def saturating(hand, **more):
    settings = {"preload": SQUEEZE, "effects": [TorqueSaturation()]} | more
    return lever_pinch(hand, **settings)


# ---------------------------------------------------------------- written down
@pytest.mark.parametrize("faces", SECTIONS)
def test_the_joint_that_yields_holds_its_limit_and_the_other_carries_the_rest(write, faces):
    """A push P to the right, 0.6 N·m there: N₂ = 0.6 / L, N₁ = N₂ - P, u = δ - C N₁, and C N₂ + L s = δ + u."""
    hand, push = lever_hand(write, torque_limits={"right_joint": 0.6}), 1.5
    g = saturating(hand, force=(push, 0, -1.0))
    s = g.solve(faces)
    right = 0.6 / L
    np.testing.assert_allclose(s.normal_force, [right - push, right], **EXACT)
    u = SQUEEZE - C * (right - push)
    np.testing.assert_allclose(s.object_displacement, [u, 0, -0.5 * PAD, 0, 0, 0], **EXACT)
    given_way = (SQUEEZE + u - C * right) / L
    np.testing.assert_allclose(s.joint_yield, [0.0, given_way], **EXACT)
    np.testing.assert_allclose([s.extra["s⁺"], s.extra["s⁻"]], [[0, given_way], [0, 0]], **EXACT)
    np.testing.assert_allclose(s.torques, [(right - push) * L, 0.6], **EXACT)
    assert s.torques[1] == 0.6
    np.testing.assert_allclose(s.joint_deflection, s.torques / K, **EXACT)
    row = s.torque_check["right_joint"]
    assert (row.utilisation, s.torque_check.binding, s.torque_check.yielding) == (1.0, "right_joint", ("right_joint",))
    assert s.torque_check.ok
    says(s.torque_check.verdict, "right_joint")
    assert str(s.torque_check).endswith(s.torque_check.verdict)
    assert s.uniqueness.forces_determined
    # virtual work, nothing slides: w·u = r·(E r + d) + τ_max s
    r = s.forces.ravel()
    work = push * u - 1.0 * s.object_displacement[2]
    assert work == pytest.approx(r @ arrays(g).flexibility @ r + r @ g.offset.ravel() + 0.6 * given_way, rel=1e-9)


def test_where_both_yield_the_object_may_be_anywhere_between(write):
    """N = 0.6 / L on both sides; either joint yields by (δ - C N) / L; one loose direction more."""
    s = saturating(lever_hand(write, torque_limits=0.6)).solve()
    np.testing.assert_allclose(s.normal_force, 0.6 / L, **EXACT)
    np.testing.assert_allclose(s.joint_yield, (SQUEEZE - C * 0.6 / L) / L, **EXACT)
    np.testing.assert_allclose(s.object_displacement[:2], 0.0, atol=1e-15)
    assert s.uniqueness.loose_motions == 2


def test_a_joint_that_is_pulled_yields_the_other_way(write):
    """A joint with its axis turned round holds -L N."""
    text = Path(write("")).parent / "turned.urdf"
    hand = lever_hand(lambda urdf: (text.write_text(urdf.replace("0 -1 0", "0 1 0")), text)[1], torque_limits=0.6)
    s = saturating(hand, force=(1.5, 0, -1.0)).solve()
    assert s.torques[1] == -0.6
    assert s.extra["s⁺"][1] == 0.0
    assert s.extra["s⁻"][1] > 0.0
    np.testing.assert_allclose(s.joint_yield[1], -s.extra["s⁻"][1])
    np.testing.assert_allclose(s.normal_force, [0.6 / L - 1.5, 0.6 / L], **EXACT)


# ---------------------------------------------------------------- what it costs, and what it doesn't
def test_it_costs_two_unknowns_a_limited_joint(write):
    def sizes(limits):
        hand = lever_hand(write, torque_limits=limits)
        return {u.name: (u.count, u.free) for u in saturating(hand).problem().groups if u.name.startswith("s")}

    assert sizes({"left_joint": 0.6, "right_joint": np.inf}) == {"s⁺": (1, False), "s⁻": (1, False)}
    assert sizes(0.6) == {"s⁺": (2, False), "s⁻": (2, False)}
    assert sizes(np.inf) == {}


def test_absent_it_leaves_no_bit(write):
    hand = lever_hand(write, torque_limits=0.6)
    plain, g = lever_pinch(hand, preload=SQUEEZE).problem(), saturating(hand).problem()
    keep = [k for k, name in enumerate(g.labels) if not name.startswith("s")]
    np.testing.assert_array_equal(plain.scaled.M, g.scaled.M[np.ix_(keep, keep)])
    np.testing.assert_array_equal(plain.scaled.q, g.scaled.q[keep])
    assert any("torque saturation" in line.title and line.cost == 4 for line in saturating(hand).explain().effects)


# ---------------------------------------------------------------- certificates
@pytest.mark.parametrize("faces", [8, "cone"])
def test_the_certifier_rejects_what_it_should(write, faces):
    hand = lever_hand(write, torque_limits={"right_joint": 0.6})
    g = saturating(hand, force=(1.5, 0, -1.0))
    s = g.solve(faces)
    u = at_centre(g, s)
    assert judged(g, faces, s.forces, u, s.extra).passes
    for name in ("s⁺", "s⁻"):
        for i in range(2):
            for change in (1e-5, -1e-5, np.nan, np.inf):
                bad = {k: v.copy() for k, v in s.extra.items()}
                bad[name][i] += change
                assert not judged(g, faces, s.forces, u, bad).passes
    free = lever_pinch(hand, preload=SQUEEZE, force=(1.5, 0, -1.0)).solve(faces)
    nothing = {k: 0 * v for k, v in s.extra.items()}
    over = judged(g, faces, free.forces, at_centre(g, free), nothing)
    assert max(over.balance, over.normal, over.cone, over.slip) < 1e-8
    assert over.effects > 1e-2


@pytest.mark.parametrize("faces", SECTIONS)
def test_limits_too_low_for_the_load_are_proven_so(write, faces):
    """Two fingers carry 2 μ τ_max / L at most."""
    hand = lever_hand(write, torque_limits=0.6)
    s = saturating(hand, force=(0, 0, -1.01 * 2 * MU * 0.6 / L)).solve(faces, throw=False)
    assert s.status is Status.NO_EQUILIBRIUM
    says(s.diagnosis, "torque limits")
    assert np.isnan(s.torques).all()
    assert np.isnan(s.joint_yield).all()
    assert not s.torque_check.yielding
    assert saturating(hand, force=(0, 0, -0.9 * 2 * MU * 0.6 / L * np.cos(np.pi / 4))).solve(faces).held


@pytest.mark.parametrize("faces", SECTIONS)
def test_a_squeeze_too_weak_for_the_load_is_proven_so_within_limits_that_would_do(write, faces):
    """5 N a finger hold 5 N between them, 7.5 N at the joints' limits would hold 7.5 N."""
    hand, weak = lever_hand(write, torque_limits=0.6), 5.0 * C
    s = saturating(hand, preload=weak, force=(0, 0, -5.2)).solve(faces, throw=False)
    assert s.status is Status.NO_EQUILIBRIUM
    assert s.bounds[0] >= 1000
    says(s.diagnosis, "squeeze is too small")
    assert saturating(hand, preload=weak, force=(0, 0, -4.9 * np.cos(np.pi / 4))).solve(faces).held


# ---------------------------------------------------------------- company
def test_a_plain_grasp_says_what_to_do(write):
    g = saturating(lever_hand(write, torque_limits=0.6))
    for effect in (TorqueSaturation(), *g.effects):
        refused("effects[0]", Grasp, g.contacts, match=r"hand\.at\(q\)\.grasp", effects=[effect])
    with pytest.raises(InputError, match="TorqueSaturation"):
        GraspStream(g)


def test_the_verdict_and_the_record_name_the_joint(write):
    g = saturating(lever_hand(write, torque_limits={"right_joint": 0.6, "left_joint": 5.0}), force=(1.5, 0, -1.0))
    s = g.solve()
    v = s.verdict
    assert v.word == "HELD"
    says(v.text, "right_joint")
    rows = {r["joint"]: r["yield_rad"] for r in solution_record(g, s, g.explain())["torques"]}
    assert rows["left_joint"] == 0.0
    assert rows["right_joint"] == pytest.approx(s.joint_yield[1])


def test_a_scene_file_asks_for_it():
    text = f"""
    {BOX_IN_TWO_FINGERS}
    torque_limits_Nm = 0.04
    [grasp]
    preload_m = 5e-3
    [effects]
    torque_saturation = true
    """
    s = read(text).solve()
    assert isinstance(s, HandGraspSolution)
    assert s.torque_check.ok
    assert s.torque_check.yielding
    assert abs(s.torques).max() == 0.04
    assert not read(text.replace("true", "false")).build().effects
    contact = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[effects]\ntorque_saturation = true"
    with pytest.raises(InputError, match=r"effects\.torque_saturation: .*\[hand\]"):
        read(contact)
