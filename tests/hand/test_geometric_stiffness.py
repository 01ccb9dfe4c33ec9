"""Fingers under load, against springs that really turn, columns that buckle, and central differences."""

import re

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.scene import read
from tests.support import patches
from tests.support.grasp import arrays, at_centre, judged
from tests.support.hand import curvature, jacobian_at, under_load
from tests.support.refusals import refused
from tests.support.scene_texts import BOX_IN_TWO_FINGERS
from tests.support.texts import says, without_numbers

from .conftest import MIMIC, inside
from .levers import PAD, K, L, lever_hand, lever_pinch

BALL = hl.Sphere(0.03, (0, 0, 0.085), mass=0.2)
QUICK = hl.Auto(search_seconds=0)
BENT = hl.GeometricStiffness()


def ball_grasp(stiffness=5.0, squeeze=3e-3, **more):
    hand = hl.example_hand("five_finger", joint_stiffness=stiffness)
    plain = hl.example_hand("five_finger", joint_stiffness=5.0)
    return hand.at(plain.close_on(BALL, squeeze=squeeze)).grasp(BALL, **({"effects": [BENT]} | more))


# ---------------------------------------------------------------- second derivatives
def points_of(state, seed):
    """Points beside the tips, where they are in tip axes, and frames turned anyhow."""
    rng = np.random.default_rng(seed)
    n = len(state.tip_positions)
    local = 0.02 * rng.normal(size=(n, 3))
    frames = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    return state.tip_positions + np.einsum("nij,nj->ni", state.tip_rotations, local), local, frames


def check_hessian(hand, q):
    state, h = hand.at(q), 1e-5
    points, local, frames = points_of(state, 1)

    def jacobian(q):
        s = hand.at(q)
        moved = s.tip_positions + np.einsum("nij,nj->ni", s.tip_rotations, local)
        return (frames.transpose(0, 2, 1) @ jacobian_at(s, moved)).reshape(-1, hand.nv)

    H = curvature(state, points, frames)
    steps = h * np.eye(hand.nv)
    differences = np.stack([(jacobian(q + e) - jacobian(q - e)) / (2 * h) for e in steps], axis=2)
    np.testing.assert_allclose(H, differences, rtol=0, atol=1e-8 * abs(H).max())
    np.testing.assert_array_equal(H, H.transpose(0, 2, 1))


def test_second_derivatives_are_those_of_central_differences(hand):
    check_hessian(hand, inside(hand, 2))


def test_so_are_those_of_mimic_joints_and_slides(coupled, write):
    check_hessian(coupled, np.array([0.3, 0.7]))
    slide = MIMIC.replace('"k3" type="revolute"', '"k3" type="prismatic"')
    check_hessian(hl.Hand.from_urdf(write(re.sub("<mimic[^>]*/>", "", slide)), joint_stiffness=1.0), np.full(4, 0.2))


# ---------------------------------------------------------------- springs that really turn
@pytest.mark.parametrize("force", [(0.0, 0.0, 2.0), (0.0, 0.0, -2.0), (-1.0, 0.0, 1.5)])
def test_one_link_has_the_tangent_stiffness_of_its_own_equilibria(write, force):
    """It is k - f · p; between equilibria k (q_c - q) = J(q)ᵀ f the tip moves by J (k - f · p)⁻¹ Jᵀ Δf."""
    hand, k, f, q = lever_hand(write, joint_stiffness=0.5, pad_flexibility=0.0), 0.5, np.array(force), 0.4
    tip = L * np.array([np.sin(q), 0, np.cos(q)])  # the left finger turns about y
    J = L * np.array([np.cos(q), 0, -np.sin(q)])
    frame = np.column_stack([(0, 0, 1.0), (0, 1.0, 0), (-1.0, 0, 0)])
    state = hand.at([q, 0.0])
    g = state.grasp([hl.Contact(state.tip_positions[0], (-1, 0, 0), tangent=(0, 0, 1))], fingers=["left_tip"],
                    effects=[BENT])  # fmt: skip
    np.testing.assert_allclose(g.frames[0], frame, atol=1e-15)
    r = (frame.T @ f)[None]
    np.testing.assert_allclose(under_load(g).stiffness(r)[0, 0], -f @ tip, rtol=1e-9)
    C = under_load(g).compliance(r)
    np.testing.assert_allclose(C[0, 0], 1 / (k - f @ tip), rtol=1e-9)

    commanded = q + J @ f / k  # where this posture carries f

    def path(more):
        x = q
        for _ in range(200):  # k (q_c - x) = J(x)ᵀ f
            x = commanded - L * np.array([np.cos(x), 0, -np.sin(x)]) @ (f + more) / k
        return L * np.array([np.sin(x), 0, np.cos(x)])

    change = under_load(g).change(r)
    E = frame @ (g.flexibility + change) @ frame.T
    for push in np.eye(3)[[0, 2]] * 1e-5:
        moved = (path(-push) - path(push)) / 2  # the tip retreats where it pushes harder
        np.testing.assert_allclose(E @ push, moved, atol=1e-7 * abs(E).max() * 1e-5)


# ---------------------------------------------------------------- solved again until the forces stay
@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("pull", [8.0, -8.0])
def test_fingers_that_carry_a_load_along_themselves_are_columns(write, faces, pull):
    """Each carries P / 2 along its link: N = δ / (L² / (K - L P / 2) + pad), softer in compression and else stiffer."""
    g = lever_pinch(lever_hand(write), force=(0, 0, -pull), preload=1e-2, effects=[BENT])
    s = g.solve(faces)
    column = K - L * pull / 2
    np.testing.assert_allclose(s.normal_force, 1e-2 / (L * L / column + PAD), rtol=1e-9)
    np.testing.assert_allclose(s.tangential_force[:, 0], pull / 2, rtol=1e-9)
    np.testing.assert_allclose(s.joint_deflection, L * s.normal_force / column, rtol=1e-9)
    np.testing.assert_allclose(s.torques, K * s.joint_deflection, rtol=1e-9)  # the load's lever has grown, too
    assert s.residuals.effects <= 1e-8
    assert s.trace[-1].startswith("geometric stiffness: 3 ")


@pytest.mark.parametrize(("command", "weight"), [(0.01, False), (0.01, True)])
def test_torques_are_those_of_the_deflected_posture(command, weight):
    """Pinocchio's at q + δq - δ: what they miss is a quarter at half the squeeze; the given posture's miss a half."""
    missed, plain = [], []
    for share in (1.0, 0.5):
        g = ball_grasp(squeeze=0.0, joint_offset=np.full(10, share * (0.04 + command)), finger_weight=weight)
        g = g.replace(wrench=share * np.array([0, 0, -4.0, 0, 0, 0]))
        s = g.solve("cone")
        hand, state = g.state.hand, g.state
        there, data = state.q + g.joint_offset - s.joint_deflection, hand.model.createData()
        pin.computeJointJacobians(hand.model, data, there)
        pin.updateFramePlacements(hand.model, data)
        torque = g.gravity_torque.copy()
        for i, name in enumerate(hand.fingertips):
            at, k = data.oMf[hand.model.getFrameId(name)], hand.model.getFrameId(name)
            J = pin.getFrameJacobian(hand.model, data, k, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            local = state.tip_rotations[i].T @ (arrays(g).positions[i] - state.tip_positions[i])
            torque += (J[:3] - pin.skew(at.rotation @ local) @ J[3:]).T @ s.forces_world[i]
        missed.append(abs(s.torques - torque).max())
        plain.append(abs(s.forces.ravel() @ g.jacobian + g.gravity_torque - torque).max())
    assert missed[0] < 0.3 * plain[0]
    assert missed[1] < 0.35 * missed[0] or weight  # the weight does not shrink with the squeeze
    if not weight:
        np.testing.assert_allclose(s.torques, hand.joint_stiffness @ s.joint_deflection, atol=1e-9)


# ---------------------------------------------------------------- where nothing is claimed
def test_a_finger_that_buckles_is_no_answer(write):
    """A column of 0.4 N·m/rad carries 0.4 / L = 5 N; at just less it is so soft that the squeeze is lost."""
    soft = lever_hand(write, joint_stiffness=0.4)
    for pull in (12.0, 9.9):
        g = lever_pinch(soft, force=(0, 0, -pull), preload=0.25, effects=[BENT])
        s = g.solve(solver=QUICK, throw=False)
        assert s.status is hl.Status.UNDECIDED
        assert np.isnan(s.forces).all()
        assert np.isnan(s.torques).all()
        says(without_numbers(s.trace[-1]), "geometric stiffness")
        assert ("left_joint, right_joint" in s.trace[-1]) == (pull > 10)
        with pytest.raises(hl.NoSolutionFound) as caught:
            g.solve(solver=QUICK)
        assert s.trace[-1] in str(caught.value)
    assert lever_pinch(soft, force=(0, 0, -12.0), preload=0.25).solve().held, "without the effect nobody would know"


def test_forces_that_have_not_settled_are_no_answer(monkeypatch):
    """Two solves leave more than the certifier lets pass."""
    g = ball_grasp(preload=5e-3)
    assert g.solve().held
    patches.no_solve_takes_more_than(monkeypatch, 2)
    s = g.solve(throw=False)
    assert s.status is hl.Status.UNDECIDED
    says(s.trace[-1], "geometric stiffness", "2")


def test_flexibility_that_is_not_the_joints_is_refused():
    g = ball_grasp(preload=5e-3)
    refused("flexibility", g.replace, flexibility=0.5 * g.flexibility)
    assert g.replace(flexibility=1.1 * g.flexibility).solve().held


def test_no_proof_about_one_flexibility_is_passed_on(write):
    """What the unloaded fingers cannot do is not proven of the loaded ones; what no force can do still is."""
    hand = lever_hand(write)
    s = lever_pinch(hand, force=(0, 0, -1.0), preload=1e-6, effects=[BENT]).solve(throw=False)
    assert lever_pinch(hand, force=(0, 0, -1.0), preload=1e-6).solve(throw=False).status is hl.Status.NO_EQUILIBRIUM
    assert (s.status, s.bounds, s.required_preload) == (hl.Status.UNDECIDED, None, None)
    smooth = [hl.Contact((x, 0, L), (-np.sign(x), 0, 0), hl.Coulomb(0.0)) for x in (-0.01, 0.01)]
    s = hand.at([0, 0]).grasp(smooth, wrench=(0, 0, -1, 0, 0, 0), preload=1e-2, effects=[BENT]).solve(throw=False)
    assert s.status is hl.Status.NOT_HOLDABLE
    assert s.certificate is not None


def test_the_certifier_rejects_forces_that_have_another_flexibility():
    """The answer without the effect is none with it, and by as much as E is off."""
    g = ball_grasp()
    plain = g.state.grasp(BALL).solve("cone")
    missed = judged(g, "cone", plain.forces, at_centre(g, plain))
    change = under_load(g).change(plain.forces)
    assert missed.effects == pytest.approx(abs(change).max() / abs(g.flexibility).max())
    assert not missed.passes


# ---------------------------------------------------------------- the size of it, without asking for it
def test_one_correction_says_by_how_much_each_force_would_change(write):
    """On the levers it is the whole of it, because their tangential forces are given by the load."""
    hand = lever_hand(write)
    g = lever_pinch(hand, force=(0, 0, -8.0), preload=1e-2)
    s, t = g.solve(), lever_pinch(hand, force=(0, 0, -8.0), preload=1e-2, effects=[BENT]).solve()
    moved = np.linalg.norm(t.forces - s.forces, axis=1) / np.linalg.norm(s.forces, axis=1).max()
    np.testing.assert_allclose(g.geometric_change(s), moved, rtol=1e-6)
    assert moved[0] > 0.01
    five = ball_grasp()
    np.testing.assert_allclose(five.geometric_change(five.solve()), 0.0, atol=1e-9)
    soft = lever_pinch(lever_hand(write, joint_stiffness=0.4), force=(0, 0, -12.0), preload=0.25)
    np.testing.assert_array_equal(soft.geometric_change(soft.solve()), np.inf)
    for bad in (None, soft.replace(wrench=(0, 0, -1e3, 0, 0, 0)).solve(throw=False, solver=QUICK)):
        refused("solution", soft.geometric_change, bad)


# ---------------------------------------------------------------- neutral, absent, and in company
def test_what_finger_flexibility_changes_beside_it_is_measured(monkeypatch):
    patches.shares_of_a_quarter(monkeypatch)
    effects = {x.title: x for x in ball_grasp().explain(measure=True).effects}
    assert effects["finger flexibility"].share == 0.25, "at the answer and with its E, as without the effect"
    assert effects[hl.GeometricStiffness.title].cost == 0


def test_what_cannot_count_it_says_so(write):
    g = lever_pinch(lever_hand(write, torque_limits=0.6), preload=5e-3, effects=[BENT])
    for effect in (BENT, *g.effects):
        refused("effects[0]", hl.Grasp, g.contacts, match=r"hand\.at\(q\)\.grasp", effects=[effect])
    with pytest.raises(hl.InputError, match="GeometricStiffness"):
        hl.GraspStream(g)
    with pytest.raises(hl.InputError, match="accuracy"):
        g.solve(accuracy=1e-3)
    with pytest.raises(hl.Unsupported, match="GeometricStiffness"):
        g.equilibria()
    refused("grasp", hl.accuracy_cost, g, match="GeometricStiffness")
    with pytest.raises(hl.InputError, match="torque saturation"):
        lever_pinch(g.state.hand, effects=[hl.TorqueSaturation(), BENT])


def test_a_scene_file_asks_for_it():
    text = f"""
    {BOX_IN_TWO_FINGERS}
    [grasp]
    preload_m = 5e-3
    [effects]
    geometric_stiffness = true
    """
    assert "geometric stiffness" in read(text).solve().trace[-1]
    assert not read(text.replace("true", "false")).build().effects
    contact = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[effects]\ngeometric_stiffness = true"
    with pytest.raises(hl.InputError, match=r"effects\.geometric_stiffness: .*\[hand\]"):
        read(contact)
