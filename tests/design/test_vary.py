"""`hand.vary`: hands with other numbers beside hands that are made or written with them, placements by hand, errors."""

import pickle

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName, Unsupported

FINGERS = ("finger_1", "finger_2", "finger_3")
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)

# One finger along x: a cylinder that ends 5 mm behind and beyond, a box, balls, two meshes, and a fingertip with a box
SHAPES = """
<robot name="shapes"><link name="palm"/>
  <link name="a"><inertial><origin xyz="0.02 0.001 0"/><mass value="0.1"/>
      <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial>
    <collision><origin xyz="0.02 0 0" rpy="0 1.5707963267948966 0"/>
      <geometry><cylinder radius="0.01" length="0.05"/></geometry></collision>
    <collision><origin xyz="0.03 0.01 0"/><geometry><box size="0.02 0.004 0.006"/></geometry></collision>
    <collision><origin xyz="0.05 0 0"/><geometry><sphere radius="0.005"/></geometry></collision>
    <collision><origin xyz="0.01 0 0"/><geometry><cylinder radius="0.002" length="0.03"/></geometry></collision>
    <visual><origin xyz="0.004 0 0" rpy="0 0 1.5707963267948966"/>
      <geometry><mesh filename="along.stl" scale="1 2 3"/></geometry></visual>
    <visual><origin rpy="0 0.6 0"/><geometry><mesh filename="askew.stl"/></geometry></visual></link>
  <link name="a_tip">
    <collision><origin xyz="-0.002 0 0"/><geometry><box size="0.01 0.01 0.01"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="palm"/><child link="a"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="t" type="fixed"><parent link="a"/><child link="a_tip"/><origin xyz="0.04 0 0"/></joint>
</robot>"""


def answers(hand, q=None):
    """Placements, Jacobian and flexibility of its tips in a posture that is no special one."""
    state = hand.at(np.clip(0.3, hand.lower, hand.upper) if q is None else q)
    return state.tip_positions, state.tip_rotations, state.jacobian, state.flexibility


def assert_same(one, other, atol=0.0):
    for a, b in zip(answers(one), answers(other), strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=atol)


def forces(hand):
    grasp = hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, squeeze=0.005)
    return grasp.solve().forces


def elements(hand, link):
    root, _ = hand.urdf_tree
    return next(e for e in root.findall("link") if e.get("name") == link)


def shapes(hand, link):
    """What collides of a link: tags, and their numbers."""

    def numbers(text):
        return [round(float(x), 12) + 0.0 for x in text.split()]

    found = elements(hand, link).iterfind("collision//*")
    return [(e.tag, {name: numbers(text) for name, text in e.items()}) for e in found]


# ---------------------------------------------------------------- lengths
def test_a_made_hand_and_one_whose_lengths_are_varied_are_the_same():
    given = {"joint_stiffness": 6.0}
    made = hl.finger_hand(link_lengths=(0.05, 0.035), **given)
    varied = hl.finger_hand(**given).vary({f"{finger}_distal.length": 0.035 for finger in FINGERS})
    assert_same(made, varied, atol=1e-12)
    np.testing.assert_allclose(forces(made), forces(varied), atol=1e-12)
    for finger in FINGERS:
        one, other = (shapes(h, f"{finger}_distal_link") for h in (made, varied))
        assert one == other


def test_nothing_varied_is_the_same_hand_and_there_and_back_are_the_same_answers():
    hand = hl.finger_hand(joint_stiffness=6.0)
    before, same = answers(hand), hand.vary({})
    assert_same(hand, same)
    assert (forces(hand) == forces(same)).all()
    there = hand.vary({"finger_1_proximal.length": 0.0731, "finger_2_distal.position": (0.01, 0, 0.05),
                       "finger_3_distal.axis": (0, -1, 0.2), "finger_3_tip.radius": 0.01})  # fmt: skip
    back = there.vary({"finger_1_proximal.length": 0.05, "finger_2_distal.position": (0, 0, 0.05),
                       "finger_3_distal.axis": (0, -1, 0), "finger_3_tip.radius": 0.008})  # fmt: skip
    assert_same(hand, back, atol=1e-12)
    np.testing.assert_allclose(forces(hand), forces(back), atol=1e-12)
    assert all((a == b).all() for a, b in zip(before, answers(hand), strict=True))
    assert abs(there.at(np.zeros(6)).tip_positions - hand.at(np.zeros(6)).tip_positions).max() > 0.009
    assert_same(pickle.loads(pickle.dumps(there)), there)


def test_lengths_of_the_allegro_hand_are_where_its_placements_scaled_by_hand_are():
    hand = hl.example_hand("allegro", torque_limits={"joint_0.0": 0.5})
    q = np.clip(0.3, hand.lower, hand.upper)
    model = hand.model
    last, tip = model.getJointId("joint_2.0"), model.getFrameId("link_7.0_tip")
    nearer = pin.SE3(model.jointPlacements[last + 1])
    nearer.translation *= 0.05 / np.linalg.norm(nearer.translation)
    model.jointPlacements[last + 1] = nearer
    end = pin.SE3(model.frames[tip].placement)
    end.translation *= 0.03 / np.linalg.norm(end.translation)
    model.frames[tip].placement = end
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    varied = hand.vary({"joint_2.0.length": 0.05, "joint_7.0.length": 0.03})
    expected = [data.oMf[model.getFrameId(name)].translation for name in hand.fingertips]
    np.testing.assert_allclose(varied.at(q).tip_positions, expected, atol=1e-15)
    assert (varied.torque_limits == hand.torque_limits).all()
    assert abs(varied.at(q).tip_positions - hand.at(q).tip_positions).max() > 0.003


def test_what_is_on_the_way_becomes_longer_and_what_is_beyond_moves_along():
    """From 40 to 60 mm: × 1.5 on the way, + 20 mm beyond it, and nothing behind the joint."""
    hand = hl.Hand.from_urdf(SHAPES, joint_stiffness=1.0)
    varied = hand.vary({"j.length": 0.06})
    link = elements(varied, "a")
    at = [[float(x) for x in e.get("xyz", "0 0 0").split()] for e in link.iter("origin")]
    expected = [[0.03, 0.001, 0], [0.03, 0, 0], [0.045, 0.01, 0], [0.07, 0, 0], [0.015, 0, 0], [0.006, 0, 0], [0, 0, 0]]
    np.testing.assert_allclose(at, expected, atol=1e-15)
    assert [float(c.get("length")) for c in link.iter("cylinder")] == pytest.approx([0.07, 0.03])
    assert [float(x) for x in link.find(".//box").get("size").split()] == pytest.approx([0.03, 0.004, 0.006])
    along, askew = link.iter("mesh")
    assert [float(x) for x in along.get("scale").split()] == pytest.approx([1, 3, 3])
    assert askew.get("scale") is None
    assert [d.joint for d in varied.doubts if "mesh kept its shape" in d.what] == ["a"]
    assert "mesh kept its shape" not in str(hand.doubts)
    (box,) = (e.get("size") for e in elements(varied, "a_tip").iter("box"))
    assert box == "0.01 0.01 0.01"
    np.testing.assert_allclose(varied.at([0.0]).tip_positions, [[0.06, 0, 0]], atol=1e-15)
    assert_same(varied.vary({"j.length": 0.04}), hand)


def test_a_point_on_a_link_moves_with_its_length():
    tips = {"left": ("finger_1_distal_link", (0.002, 0, 0.03)), "right": "finger_2_tip"}
    hand = hl.example_hand("two_finger", fingertips=tips)
    size = np.hypot(0.002, 0.03)
    varied = hand.vary({"finger_1_distal.length": 2 * size, "finger_2_proximal.length": 0.06})
    expected = [[0.045 + 0.004, 0, 0.05 + 0.06], [-0.045, 0, 0.06 + 0.04]]
    np.testing.assert_allclose(varied.at(np.zeros(4)).tip_positions, expected, atol=1e-12)
    assert_same(varied.vary({"finger_1_distal.length": size, "finger_2_proximal.length": 0.05}), hand, atol=1e-12)


def test_tendons_run_along_routes_on_the_longer_links():
    def hand(lengths, up):
        route = hl.Route([
            hl.Site("palm", (0.03, 0, -0.01)),
            hl.Around("finger_1_proximal_link", ((-0.001, 0, up / 2), (0, 1, 0)), 0.002, side=(-0.01, 0, up / 2)),
            hl.Site("finger_1_distal_link", (-0.01, 0, up / 2)),
        ])  # fmt: skip
        tendons = hl.Tendons({"flexor": route}, 3e4, 1.0, pretension=2.0)
        return hl.finger_hand(1, lengths, joint_stiffness=tendons)

    made, varied = hand((0.06, 0.06), 0.06), hand((0.05, 0.05), 0.05)
    varied = varied.vary({"finger_1_proximal.length": 0.06, "finger_1_distal.length": 0.06})
    assert_same(made, varied, atol=1e-12)
    motor = hl.Motor(20.0)
    assert varied.vary({"flexor.motor": motor, "finger_1_proximal.length": 0.05}).stiffness.drives.motors == (motor,)
    assert varied.vary({"flexor.motor": motor}).vary({"flexor.motor": None}).stiffness.drives is None
    with pytest.raises(InputError, match=r"finger_1_distal\.stiffness.*spring of its own"):
        varied.vary({"finger_1_distal.stiffness": 2.0})


def test_derivatives_by_lengths_are_differences_of_hands_with_other_lengths():
    """The sensitivity's coordinate along the last link is the length that is varied."""
    hand, step = hl.finger_hand(joint_stiffness=6.0), 1e-6
    q = hand.close_on(CUBE, squeeze=1e-4)

    def solution(length):
        varied = hand.vary({"finger_1_distal.length": length})
        return varied.at(q).grasp(CUBE, friction=0.8, squeeze=0.005).solve()

    found = solution(0.04).sensitivity()
    k = found.length_names.index("finger_1_tip")
    difference = (solution(0.04 + step).forces - solution(0.04 - step).forces) / (2 * step)
    np.testing.assert_allclose(found.forces_by_lengths[..., k, 2], difference, rtol=1e-6, atol=1e-6)


# ---------------------------------------------------------------- the other names
def test_axes_and_places_are_those_of_a_urdf_that_is_written_with_them(tmp_path):
    hl.finger_hand(2, file=tmp_path / "as_made.urdf")
    text = (tmp_path / "as_made.urdf").read_text()
    given = {"joint_stiffness": 1.0, "pad_flexibility": 1e-4}
    second = text.index('name="finger_1_distal"')
    head, tail = text[:second], text[second:]
    for was, new in (('xyz="0 0 0.05"', 'xyz="0.01 0 0.05"'), ('axis xyz="0 -1 0"', 'axis xyz="0.6 -0.8 0"')):
        tail = tail.replace(was, new, 1)
    written = hl.Hand.from_urdf(head + tail, **given)
    varied = hl.finger_hand(2).vary({"finger_1_distal.position": (0.01, 0, 0.05), "finger_1_distal.axis": (3, -4, 0)})
    assert_same(written, varied, atol=1e-15)
    both = hl.finger_hand(2).vary({"finger_1_distal.position": (0.03, 0, 0.04), "finger_1_proximal.length": 0.1})
    turned = hl.finger_hand(2).vary({"finger_1_distal.position": (0.06, 0, 0.08)})
    assert_same(both, turned, atol=1e-15)


def test_numbers_of_joints_and_fingertips_change_beside_those_of_the_others():
    hand = hl.finger_hand(torque_limits={"finger_1_distal": 0.7}, tip_radius=0.009)
    motor, weak = hl.Motor(0.3, stiffness=9.0), hl.Motor(0.2)
    varied = hand.vary({
        "joint_stiffness": 4.0, "finger_1_distal.stiffness": 2.0, "finger_2_distal.motor": motor,
        "finger_3_distal.torque_limit": 0.1, "finger_2_tip.radius": 0.01, "finger_2_tip.pad": (1e-5, 2e-5, 3e-5),
        "palm.pad": 5e-5, "joint_friction": 0.01,
    })  # fmt: skip
    assert np.diagonal(varied.joint_stiffness).tolist() == [4, 2, 4, 9, 4, 4]
    assert varied.torque_limits.tolist() == [0.8, 0.7, 0.8, 0.3, 0.8, 0.1]
    assert [varied.tip_shapes(i)[0].radius for i in range(3)] == [0.009, 0.01, 0.009]
    assert [np.diagonal(pad).tolist() for pad in varied.pad_flexibility] == [[1e-4] * 3, [1e-5, 2e-5, 3e-5], [1e-4] * 3]
    assert varied.joint_friction.tolist() == [0.01] * 6
    more = varied.vary({"finger_1_tip.pad": 0.0, "finger_1_tip.radius": 0.02, "finger_1_proximal.motor": weak,
                        "finger_2_proximal.torque_limit": 0.6, "joint_stiffness": 3.0})  # fmt: skip
    assert more.torque_limits.tolist() == [0.2, 0.7, 0.6, 0.3, 0.8, 0.1]
    assert np.diagonal(more.joint_stiffness).tolist() == [3] * 6
    assert [more.tip_shapes(i)[0].radius for i in range(3)] == [0.02, 0.01, 0.009]
    assert [float(pad.max()) for pad in more.pad_flexibility] == [0.0, 3e-5, 1e-4]
    gone = more.vary({"finger_1_proximal.motor": None, "finger_2_distal.torque_limit": 0.5})
    assert gone.torque_limits.tolist() == [0.8, 0.7, 0.6, 0.5, 0.8, 0.1]
    assert "5e-05" not in str(hand.describe())
    for one, other in ((hand.vary({"pad_flexibility": 2e-4}), hand.replace(pad_flexibility=2e-4)),
                       (hand.vary({"motors": motor}), hand.replace(motors=motor))):  # fmt: skip
        assert_same(one, other)


# ---------------------------------------------------------------- hands that are no URDF
def test_a_hand_from_a_model_has_lengths_and_places_like_one_from_its_urdf(tmp_path):
    hl.finger_hand(2, file=tmp_path / "two.urdf")
    robot = pin.RobotWrapper.BuildFromURDF(str(tmp_path / "two.urdf"), [])
    hand = hl.Hand.from_model(robot, joint_stiffness=1.0, pad_flexibility=1e-4)
    changes = {
        "finger_1_proximal.length": 0.07,
        "finger_2_proximal.position": (-0.05, 0.01, 0),
        "finger_1_distal.length": 0.03,
    }
    ours, theirs = hand.vary(changes), hl.finger_hand(2).vary(changes)
    assert_same(ours, theirs, atol=1e-15)
    touching = [str(h.describe()).partition("Joint")[0].partition("What may touch")[2] for h in (ours, theirs)]
    assert touching[0] == touching[1]
    q = np.full(4, 0.4)
    np.testing.assert_allclose(ours.at(q).gravity_torque(), theirs.at(q).gravity_torque(), atol=1e-15)
    with pytest.raises(Unsupported, match="finger_1_distal"):
        hand.vary({"finger_1_distal.axis": (1, 0, 0)})


def test_a_hand_from_an_mjcf_file_keeps_its_servos_and_couplings():
    pytest.importorskip("mujoco")
    text = """<mujoco model="m"><worldbody><body name="palm"><geom type="box" size="0.03 0.03 0.01"/>
      <body name="a1" pos="0.02 0 0.01"><joint name="a" axis="0 1 0" range="-1 1"/>
        <geom type="capsule" fromto="0 0 0 0 0 {0}" size="0.008"/>
        <body name="a2" pos="0 0 {0}"><joint name="b" axis="0 1 0" range="-1 1"/>
          <geom type="sphere" size="0.009" pos="0 0 0.02"/><site name="a_tip" pos="0 0 0.02"/></body></body>
    </body></worldbody><equality><joint joint1="b" joint2="a" polycoef="0 0.8 0 0 0"/></equality>
    <actuator><position joint="a" kp="3" forcerange="-1 1"/></actuator></mujoco>"""
    hand, made = (hl.Hand.from_mjcf(text.format(length), pad_flexibility=1e-4) for length in (0.04, 0.05))
    varied = hand.vary({"a.length": 0.05})
    assert_same(varied, made, atol=1e-12)
    assert shapes(varied, "a1") == shapes(made, "a1")
    assert [e.tag for e in elements(varied, "a1").iterfind("collision/geometry/*")] == ["cylinder", "sphere", "sphere"]


# ---------------------------------------------------------------- errors
@pytest.mark.parametrize(("changes", "message"), [
    ({"finger_1_distl.length": 0.03}, r"did you mean 'finger_1_distal.length'"),
    ({"finger_1_distal.lenght": 0.03}, r"did you mean 'finger_1_distal.length'"),
    ({"finger_1_tp.radius": 0.01}, r"did you mean 'finger_1_tip.radius'"),
    ({"palm.radius": 0.01}, "finger_3_tip.radius"),
    ({"joint_stifness": 4.0}, "did you mean 'joint_stiffness'"),
    ({"fingertips": ["finger_1_tip"]}, "argument of Hand.replace"),
    ({3: 4.0}, "argument of Hand.replace"),
])  # fmt: skip
def test_a_name_that_does_not_exist_is_answered_with_those_that_are_near(changes, message):
    with pytest.raises(UnknownName, match=message):
        hl.finger_hand().vary(changes)


@pytest.mark.parametrize(("changes", "message"), [
    ([("joint_stiffness", 4.0)], "a mapping by name"),
    ({"finger_1_distal.length": 0.0}, r"changes\['finger_1_distal.length'\].*> 0"),
    ({"finger_1_distal.length": "long"}, r"changes\['finger_1_distal.length'\]"),
    ({"finger_1_distal.length": 40.0}, "metres"),
    ({"finger_1_distal.axis": (0, 0, 0)}, r"changes\['finger_1_distal.axis'\].*a direction"),
    ({"finger_1_distal.position": 0.1}, r"changes\['finger_1_distal.position'\]"),
    ({"finger_1_tip.radius": -0.01}, "tip_radius"),
    ({"finger_1_distal.stiffness": 0.0}, r"changes\['finger_1_distal.stiffness'\]"),
    ({"finger_1_distal.motor": 0.5}, "a Motor"),
    ({"finger_1_distal.motor": hl.Motor(0.5), "finger_1_distal.torque_limit": 0.4}, "no limit of a joint with a motor"),
])  # fmt: skip
def test_a_number_that_cannot_be_is_refused_by_its_name(changes, message):
    with pytest.raises(InputError, match=message):
        hl.finger_hand().vary(changes)


def test_a_joint_that_carries_several_or_stands_where_the_next_one_does_has_no_length():
    joint = ('<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="{3} 0 0"/>'
             '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')  # fmt: skip
    links = "".join(f'<link name="{name}"/>' for name in ("palm", "w", "s", "a_tip", "b_tip"))
    joints = [("wrist", "palm", "w", 0), ("a", "w", "s", 0.1), ("b", "w", "b_tip", 0.2), ("c", "s", "a_tip", 0)]
    text = f'<robot name="r">{links}{"".join(joint.format(*j) for j in joints)}</robot>'
    hand = hl.Hand.from_urdf(text, joint_stiffness=1.0)
    for name, message in (("wrist", "carries a, b"), ("a", "c in the same place"), ("c", "a_tip in the same place")):
        with pytest.raises(InputError, match=message):
            hand.vary({f"{name}.length": 0.03})
