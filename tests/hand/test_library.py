"""The hands that ship, and those of example-robot-data."""

from __future__ import annotations

import importlib.util
import math
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from handlcp.errors import UnknownName, URDFError
from handlcp.hand import HANDS, Hand, example_hand
from handlcp.hand.library import SHIPPED_HANDS, allegro, psyonic, urdf
from tests.support.hand import knows_all_limits

ROOT = Path(__file__).parents[2]


def test_urdfs_are_regenerated_byte_for_byte():
    """The script in urdf/ writes the files that are in urdf/, every byte."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "urdf" / "generate.py")
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    assert set(generate.HANDS) == set(SHIPPED_HANDS)
    for name in SHIPPED_HANDS:
        assert generate.text(name) == urdf(name).read_bytes(), f"run python urdf/generate.py ({name})"


@pytest.mark.parametrize("name", SHIPPED_HANDS)
def test_yourdfpy_and_pinocchio_read_the_same_hand(name):
    """Yourdfpy validates each file, and its forward kinematics agrees with Pinocchio's."""
    from yourdfpy import URDF

    robot = URDF.load(str(urdf(name)), load_meshes=False, build_scene_graph=True)
    assert robot.validate()
    hand = example_hand(name)
    q = dict(zip(hand.joint_names, np.random.default_rng(0).uniform(0.0, 1.0, hand.nv), strict=True))
    robot.update_cfg(q)
    for tip, position, R in zip(hand.fingertips, hand.at(q).tip_positions, hand.at(q).tip_rotations, strict=True):
        T = robot.get_transform(tip, "palm")
        np.testing.assert_allclose(T[:3, 3], position, atol=1e-12)
        np.testing.assert_allclose(T[:3, :3], R, atol=1e-12)


@pytest.mark.parametrize(("name", "fingers"), list(zip(SHIPPED_HANDS, (2, 3, 5, 6), strict=True)))
def test_shipped_hands_are_what_they_say(name, fingers):
    """Two joints a finger, 50 + 40 mm, efforts 0.8 and 0.4 N·m, sound inertias, visual and collision geometry."""
    hand = example_hand(name)
    model = hand.model
    assert hand.fingertips == tuple(f"finger_{i + 1}_tip" for i in range(fingers))
    assert hand.nv == 2 * fingers
    assert set(zip(hand.joint_names, hand.torque_limits.tolist(), strict=True)) == {
        (f"finger_{i + 1}_{kind}", effort)
        for i in range(fingers)
        for kind, effort in (("proximal", 0.8), ("distal", 0.4))
    }
    state = hand.at(np.zeros(hand.nv))
    for i, tip in enumerate(state.tip_positions):
        root = model.jointPlacements[model.getJointId(f"finger_{i + 1}_proximal")].translation
        assert np.linalg.norm(tip - root) == pytest.approx(0.09, abs=1e-11)
    for body in list(model.inertias)[1:]:
        a, b, c = np.sort(np.linalg.eigvalsh(body.inertia))
        assert 0 < a <= c <= a + b
        assert 0.01 < body.mass < 0.1
    for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION):
        assert pin.buildGeomFromUrdf(model, str(urdf(name)), kind).ngeoms >= 3 * fingers


def test_positive_angles_close_upright_hands():
    """Fingers point along +z at zero, and positive angles bring every tip nearer to the axis of the palm."""
    for name in ("two_finger", "three_finger", "five_finger"):
        hand = example_hand(name)
        before, after = (hand.at(np.full(hand.nv, a)).tip_positions for a in (0.0, 0.3))
        np.testing.assert_allclose(before[:, 2], 0.09, atol=1e-12)
        assert (np.hypot(*after[:, :2].T) < np.hypot(*before[:, :2].T) - 0.01).all()


def test_the_ring_is_planar_and_points_at_its_centre():
    """All tips and all motions lie in the xy plane; straight fingers point at the origin."""
    hand = example_hand("planar_ring")
    state = hand.at(hand.neutral)
    np.testing.assert_allclose(np.hypot(*state.tip_positions[:, :2].T), 0.03, atol=1e-11)
    assert not state.jacobian.reshape(6, 3, -1)[:, 2].any()
    inward = state.tip_rotations[:, :, 0]
    np.testing.assert_allclose(inward, -state.tip_positions / 0.03, atol=1e-10)


@pytest.mark.parametrize("name", HANDS)
def test_example_hands_have_sane_limits(name):
    """Every limit is known; the Allegro's placeholder of 15 N·m is gone."""
    hand = example_hand(name)
    assert knows_all_limits(hand)
    assert hand.torque_limits.max() < {"psyonic": 7.0, "g1": 3.0}.get(name, 1.0)
    assert example_hand(name, torque_limits=0.3).torque_limits.tolist() == [0.3] * hand.nv


def test_both_sides_of_example_robot_data():
    """Left and right Allegro, and the right psyonic hand, cut from the same robot; its base is the world."""
    file, share = allegro("left")
    hand = Hand.from_urdf(file, joint_stiffness=1.0, package_dirs=share)
    assert set(hand.fingertips) == {f"link_{i}.0_tip" for i in (3, 7, 11, 15)}
    robot, _ = psyonic()
    right = Hand.from_urdf(
        robot,
        [f"Right_{f}_anchor" for f in ("thumb", "index")],
        joint_stiffness=1.0,
        base="RightPsyonicAbilityBaseLink",
    )
    assert right.nv == 6
    assert all(name.startswith("Right_") for name in right.joint_names)
    assert max(math.dist(p, (0, 0, 0)) for p in right.at(right.neutral).tip_positions) < 0.25


def test_unknown_hands_list_those_that_exist():
    """The error names them."""
    with pytest.raises(UnknownName, match="planar_ring"):
        urdf("four_finger")
    with pytest.raises(UnknownName, match="psyonic"):
        example_hand("atlas")
    with pytest.raises(UnknownName, match="right"):
        allegro("both")


def test_where_conda_has_installed_the_robot_data_it_is_found(tmp_path, monkeypatch):
    def gone(name):
        raise metadata.PackageNotFoundError(name)

    pips = metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share")
    monkeypatch.setattr(metadata, "distribution", gone)
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    with pytest.raises(URDFError, match="pip install example-robot-data"):
        example_hand("allegro")
    (tmp_path / "share").symlink_to(pips)
    assert len(example_hand("allegro").joint_names) == 16
