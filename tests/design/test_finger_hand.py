"""Hands from numbers: beside the shipped hands and closed forms, each number by finger, files, and what is refused."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName


def test_the_numbers_of_the_example_hand_make_its_grasp():
    made = hl.finger_hand(3, (0.05, 0.04), 0.045, 0.007, tip_radius=0.008, joint_stiffness=6.0)
    shipped = hl.example_hand("three_finger", joint_stiffness=6.0)
    assert (made.joint_names, made.fingertips) == (shipped.joint_names, shipped.fingertips)
    assert (made.torque_limits == shipped.torque_limits).all()
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    one, other = (h.at(h.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005) for h in (made, shipped))
    np.testing.assert_allclose(one.jacobian, other.jacobian, atol=1e-9)
    np.testing.assert_allclose(one.solve().forces, other.solve().forces, atol=1e-9)


def test_a_finger_of_two_links_is_where_its_closed_form_says_and_gives_way_as_it_does():
    """X = r - a sin α - b sin(α + β), z = a cos α + b cos(α + β); E = J K⁻¹ Jᵀ."""
    a, b, r = 0.06, 0.03, 0.02
    hand = hl.finger_hand(1, (a, b), r, 0.005, joint_stiffness=[2.0, 3.0], pad_flexibility=0.0)
    alpha, beta = 0.4, 0.7
    state = hand.at([alpha, beta])
    s, c, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(alpha + beta), np.cos(alpha + beta)
    np.testing.assert_allclose(state.tip_positions, [[r - a * s - b * sb, 0.0, a * c + b * cb]], atol=1e-15)
    J = np.array([[-a * c - b * cb, -b * cb], [0.0, 0.0], [-a * s - b * sb, -b * sb]])
    np.testing.assert_allclose(state.flexibility, J @ np.diag([1 / 2, 1 / 3]) @ J.T, atol=1e-16)


def test_every_number_may_differ_by_finger():
    hand = hl.finger_hand(
        3, [(0.04, 0.03, 0.02), (0.05,), (0.02, 0.02, 0.02, 0.02)], palm_radius={"finger_2": 0.06},
        link_radius=(0.006, 0.007, 0.005), tip_radius={"finger_3": 0.01}, angles=(0.0, 2.0, -1.5),
        tilt={"finger_1": 0.2}, ranges={"finger_2": (-0.1, 0.3), "finger_1": [(-1, 1), (0, 1), (0, 2)]},
    )  # fmt: skip
    third = [f"finger_3_{kind}" for kind in ("proximal", "middle_1", "middle_2", "distal")]
    first = [f"finger_1_{kind}" for kind in ("proximal", "middle", "distal")]
    assert hand.joint_names == (*first, "finger_2_proximal", *third)
    state = hand.at(np.zeros(hand.nv))
    lean, out = np.array([np.sin(0.2), 0.0, np.cos(0.2)]), np.array([np.cos(-1.5), np.sin(-1.5), 0.0])
    expected = [[0.04, 0, 0] + 0.09 * lean, [0.06 * np.cos(2), 0.06 * np.sin(2), 0.05], 0.04 * out + [0, 0, 0.08]]
    np.testing.assert_allclose(state.tip_positions, expected, atol=1e-12)
    assert [hand.tip_shapes(i)[0].radius for i in range(3)] == [0.006, 0.007, 0.01]
    assert hand.upper.tolist() == [1, 1, 2, 0.3, 1.6, 1.9, 1.9, 1.9]
    assert hand.lower.tolist() == [-1, 0, 0, -0.1, -0.5, 0, 0, 0]


def test_joints_that_are_coupled_turn_so_far_for_each_radian_of_the_one_before():
    lengths = (0.04, 0.03, 0.02)
    hand = hl.finger_hand(2, [lengths, lengths], coupling={"finger_1": (0.8, 0.5)})
    free = hl.finger_hand(2, lengths)
    assert hand.joint_names == ("finger_1_proximal", *free.joint_names[3:])
    ours, theirs = hand.at([0.5, 0.1, 0.2, 0.3]), free.at([0.5, 0.4, 0.2, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(ours.tip_positions, theirs.tip_positions, atol=1e-15)
    assert hand.upper[0] == 1.6
    assert hl.finger_hand(2, lengths, coupling=0.9).nv == 2
    assert hl.finger_hand(2, lengths, coupling=[0.9, None]).nv == 4


def test_links_are_capsules_and_masses_follow_from_densities():
    hand = hl.finger_hand(1, (0.05,), 0.03, 0.006, tip_radius=0.01)
    root, _ = hand.urdf_tree
    link = next(e for e in root.findall("link") if e.get("name") == "finger_1_proximal_link")
    assert [shape.tag for shape in link.iterfind("collision/geometry/*")] == ["cylinder", "sphere"]
    volumes = {"palm": np.pi * 0.036**2 * 0.02, "link": np.pi * 0.006**2 * 0.05, "tip": 4 / 3 * np.pi * 0.01**3}
    mass = 1300 * volumes["palm"] + 3000 * volumes["link"] + 1400 * volumes["tip"]
    np.testing.assert_allclose(hand.describe().mass, mass, rtol=1e-9)


def test_the_file_is_the_same_hand_and_is_written_whole_or_not_at_all(tmp_path):
    hand = hl.finger_hand(2, (0.03, 0.02), coupling=0.7, torque_limits=0.5, file=tmp_path / "two.urdf")
    read = hl.Hand.from_urdf(tmp_path / "two.urdf", joint_stiffness=1.0, pad_flexibility=1e-4, torque_limits=0.5)
    ours, theirs = hand.at([0.3, 0.2]), read.at([0.3, 0.2])
    for name in ("tip_positions", "jacobian", "flexibility"):
        assert (getattr(ours, name) == getattr(theirs, name)).all()
    assert (hand.torque_limits == read.torque_limits).all()
    with pytest.raises(InputError, match="file"):
        hl.finger_hand(file=tmp_path / "no folder" / "two.urdf")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="file"):
        hl.finger_hand(file=tmp_path / "folder")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["folder", "two.urdf"]


@pytest.mark.parametrize(("given", "argument"), [
    ({"fingers": 0}, "fingers"),
    ({"fingers": 2.0}, "fingers"),
    ({"link_lengths": (0.05, 0.0)}, r"link_lengths\[1\]"),
    ({"link_lengths": ()}, "link_lengths"),
    ({"link_lengths": 0.05}, "link_lengths"),
    ({"link_lengths": [(0.05,), (0.04,)]}, "link_lengths"),
    ({"link_lengths": [(0.05,), (0.04,), ("long",)]}, r"link_lengths\[2\]"),
    ({"link_radius": -0.01}, "link_radius"),
    ({"tip_radius": {"finger_1": 0.0}}, r"tip_radius\['finger_1'\]"),
    ({"palm_radius": (0.04, 0.04)}, "palm_radius"),
    ({"palm_radius": 0.009}, "palm_radius"),
    ({"angles": (0.0, 0.1, 3.0)}, "angles"),
    ({"tilt": "out"}, "tilt"),
    ({"ranges": (1.0, -1.0)}, "ranges"),
    ({"ranges": {"finger_2": [(0, 1)] * 3}}, r"ranges\['finger_2'\]"),
    ({"coupling": (0.5, 0.5)}, "coupling"),
    ({"coupling": {"finger_1": (0.5, 0.5)}}, r"coupling\['finger_1'\]"),
    ({"link_lengths": (50, 40)}, r"link_lengths\[0\]: .*metres .*\(if millimetres are meant, 0.05\)"),
    ({"palm_radius": 40}, "palm_radius: .*metres"), ({"tip_radius": 8}, "tip_radius: .*metres"),
    ({"angles": (0, 120, 240)}, r"angles\[1\]: expected an angle in radians .*\(if degrees are meant, 2.094\)"),
    ({"tilt": 20}, "tilt: .*radians"), ({"ranges": (0, 90)}, "ranges: .*radians"),
    ({"name": ""}, "name"),
    ({"name": "hand\x00"}, "name"),
    ({"file": 3}, "file"),
    ({"joint_stiffness": -1.0}, "joint_stiffness"),
])  # fmt: skip
def test_numbers_that_make_no_hand_are_named(given, argument):
    with pytest.raises(InputError, match=argument):
        hl.finger_hand(**given)


def test_a_finger_that_does_not_exist_is_named_beside_those_that_do():
    with pytest.raises(UnknownName, match=r"finger_4.*finger_3|finger_3.*finger_4"):
        hl.finger_hand(link_lengths={"finger_4": (0.05, 0.04)})
