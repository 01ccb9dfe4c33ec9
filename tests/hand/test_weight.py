"""The fingers' own weight: torques that hold it, and joints that sag under it, against the one-link finger."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import Hand
from tests.support.study import left_out

LENGTH, CENTRE, MASS, STIFF, G = 0.08, 0.03, 0.25, 2.0, 9.81
LINK = f"""
<robot name="lever">
  <link name="palm"/>
  <link name="link"><inertial><origin xyz="{CENTRE} 0 0"/><mass value="{MASS}"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
  <link name="tip"/>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="link"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="5" velocity="1"/></joint>
  <joint name="end" type="fixed"><parent link="link"/><child link="tip"/><origin xyz="{LENGTH} 0 0"/></joint>
</robot>
"""


@pytest.fixture
def lever(tmp_path):
    """One link along x, turning about y: positive is down."""
    path = tmp_path / "lever.urdf"
    path.write_text(LINK)
    return Hand.from_urdf(path, joint_stiffness=STIFF, tip_radius=0.01)


def pushed(lever, q, weight, load=1.5):
    """The tip pushes straight up against a load that pushes down on it."""
    state = lever.at([q])
    p = state.tip_positions[0]
    contact = hl.Contact(p, (0, 0, 1), hl.Frictionless())
    return state.grasp([contact], wrench=(0, 0, -load, 0, 0, 0), reference=p, finger_weight=weight)


@pytest.mark.parametrize("q", [0.0, -0.9])
def test_a_one_link_finger_sags_by_its_weight_over_its_stiffness(lever, q):
    """With g = -m G c cos q the tip sinks by ℓ cos q · m G c cos q / k before a load, by (ℓ cos q)² w / k under it."""
    w, c = 1.5, np.cos(q)
    held = MASS * G * CENTRE * c
    sunk = LENGTH * c * held / STIFF
    g = pushed(lever, q, True)
    assert g.offset[0, 2] == pytest.approx(sunk, rel=1e-9)  # a gap: the tip went away from the object
    assert g.gravity_torque[0] == pytest.approx(-held, rel=1e-9)
    assert g.sag[0] == pytest.approx(-held / STIFF, rel=1e-9)
    s = g.solve()
    assert s.forces[0, 2] == pytest.approx(w, rel=1e-9)
    assert s.object_displacement[2] == pytest.approx(-sunk - (LENGTH * c) ** 2 * w / STIFF, rel=1e-9)
    assert s.torques[0] == pytest.approx(-held - LENGTH * c * w, rel=1e-9)
    assert s.joint_deflection[0] == pytest.approx(s.torques[0] / STIFF, rel=1e-9)


def test_a_measured_posture_has_sagged_already(lever):
    """The weight is in the torques, and nothing else changes."""
    torques, none = pushed(lever, 0.4, "torques"), pushed(lever, 0.4, False)
    np.testing.assert_array_equal(torques.offset, none.offset)
    a, b = torques.solve(), none.solve()
    np.testing.assert_array_equal(a.object_displacement, b.object_displacement)
    np.testing.assert_allclose(a.torques - b.torques, [-MASS * G * CENTRE * np.cos(0.4)], rtol=1e-9)
    np.testing.assert_array_equal(a.joint_deflection, b.joint_deflection)
    assert not torques.sag.any()


def test_an_offset_makes_up_for_the_sag():
    """Tips commanded J K⁻¹ g higher end where weightless ones are, and so do the forces."""
    ball = hl.Sphere(0.03, (0, 0, 0.085), mass=0.1)
    five = hl.example_hand("five_finger", joint_stiffness=5.0)
    state = five.at(five.close_on(ball, squeeze=4e-3))
    light, heavy = state.grasp(ball), state.grasp(ball, finger_weight=True)
    assert abs(heavy.tip_sag).max() > 1e-5
    np.testing.assert_allclose(heavy.offset - light.offset, heavy.tip_sag, atol=1e-18)
    lifted = state.grasp(ball, finger_weight=True, offset=-heavy.tip_sag)
    np.testing.assert_allclose(lifted.solve().forces, light.solve().forces, atol=1e-9)
    assert abs(heavy.solve().forces - light.solve().forces).max() > 1e-3


def test_with_rigid_joints_nothing_sags(five):
    ball = hl.Sphere(0.03, (0, 0, 0.085))
    state = hl.example_hand("five_finger", joint_stiffness=np.inf).at(five.close_on(ball, squeeze=4e-3))
    a, b = (state.grasp(ball, preload=1e-3, finger_weight=x) for x in (True, False))
    np.testing.assert_array_equal(a.offset, b.offset)


def test_in_a_plane_fingers_sag_in_it_alone():
    """The ring's joints turn in its plane; gravity across it moves nothing."""
    hand = hl.example_hand("planar_ring")
    disc = hl.Cylinder(0.03, 0.02)
    state = hand.at(hand.close_on(disc, np.tile([0.5, -0.9], 6), squeeze=2e-3))
    across = state.grasp(disc, plane=(0, 0, 1), finger_weight=True)
    assert abs(across.tip_sag).max() < 1e-15
    within = state.grasp(disc, plane=(0, 0, 1), finger_weight=True, gravity=(0, -9.81, 0))
    assert abs(within.tip_sag[:, [0, 2]]).max() > 1e-6
    assert not within.tip_sag[:, 1].any()
    assert within.solve(throw=False).held


def test_the_study_leaves_out_weight_with_its_sag_and_stiff_joints_do_not_sag(lever):
    """Without the weight, the offset of weightless fingers is back."""
    found = left_out(pushed(lever, 0.4, True))
    for name in ("finger weight", "joint compliance"):
        np.testing.assert_allclose(found[name].offset, 0.0, atol=1e-18)
    assert not found["finger weight"].gravity_torque.any()
    assert found["joint compliance"].gravity_torque.any()
    assert "preload and gaps" not in found


@pytest.mark.parametrize("weight", [1, "elastic"])
def test_a_weight_that_is_none_of_the_three_is_refused(lever, weight):
    """One InputError."""
    with pytest.raises(hl.InputError, match="finger_weight"):
        pushed(lever, 0.0, weight)
