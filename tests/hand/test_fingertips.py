"""Fingertips: named, named with points on links, found at the ends of fingers or by their names, or proposed."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand.library import psyonic
from tests.support.texts import says


def finger(name, at, geometry="", kind="collision", more=""):
    """Two links in a row along x, the second with some geometry, and joints about y."""
    limit = '<limit lower="-1" upper="1" effort="0.5" velocity="1"/>'
    shape = f"<{kind}>{geometry}</{kind}>" if geometry else ""
    return (
        f'<link name="{name}_1"/><link name="{name}_2">{shape}</link>'
        f'<joint name="{name}_a" type="revolute"><parent link="palm"/><child link="{name}_1"/><origin xyz="{at}"/>'
        f'<axis xyz="0 1 0"/>{limit}</joint><joint name="{name}_b" type="revolute"><parent link="{name}_1"/>'
        f'<child link="{name}_2"/><origin xyz="0.04 0 0"/><axis xyz="0 1 0"/>{limit}</joint>{more}'
    )


BOX = '<origin xyz="0.02 0 0"/><geometry><box size="0.04 0.012 0.01"/></geometry>'
BALL_END = '<origin xyz="0.03 0.001 0"/><geometry><sphere radius="0.006"/></geometry>'


def robot(*fingers):
    """As text: a palm and fingers."""
    return f'<robot name="r"><link name="palm"/>{"".join(fingers)}</robot>'


def two(geometry="", kind="collision", more=""):
    return robot(finger("f", "0 0 0.02", geometry, kind), finger("g", "0 0 -0.02", geometry, kind, more))


def hand_of(text, tips=None, **more):
    return hl.Hand.from_urdf(text, tips, joint_stiffness=1.0, **more)


# ---------------------------------------------------------------- found
def test_the_far_end_of_the_last_link_is_taken_where_nothing_is_called_a_tip():
    """A box 40 mm long and 10 mm thick: 5 mm below its end, in the middle of its width."""
    hand = hand_of(two(BOX))
    assert hand.fingertips == ("f_2", "g_2")
    np.testing.assert_allclose(hand.at([0.0] * 4).tip_positions, [[0.075, 0, 0.02], [0.075, 0, -0.02]], atol=1e-12)
    assert "far end" in " ".join(str(hand.describe()).split())


def test_the_far_end_of_a_ball_is_its_middle():
    hand = hand_of(two(BALL_END))
    np.testing.assert_allclose(hand.at([0.0] * 4).tip_positions[0], [0.07, 0.001, 0.02], atol=2e-4)


@pytest.mark.parametrize("turn", ["0 0 0", "0 0.4 0"])
def test_a_link_that_its_joint_turns_about_its_length_ends_far_from_the_joint(turn):
    """A cylinder along x on a joint about x."""
    shape = '<origin xyz="0.03 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.005" length="0.06"/></geometry>'
    text = two(shape).replace('<axis xyz="0 1 0"/>', '<axis xyz="1 0 0"/>')
    (place, _) = hand_of(text.replace("0.04 0 0", f'0.04 0 0" rpy="{turn}')).tips.places
    np.testing.assert_allclose(place.placement.translation, [0.055, 0, 0], atol=3e-4)


def test_what_is_drawn_makes_the_tip_where_nothing_collides_and_the_audit_says_so():
    hand = hand_of(two(BOX, "visual"))
    np.testing.assert_allclose(hand.at([0.0] * 4).tip_positions[0], [0.075, 0, 0.02], atol=1e-12)
    grasp = hand.at([0.0] * 4).grasp(hl.Box((0.1, 0.1, 0.03), (0.08, 0, 0)))
    np.testing.assert_allclose(grasp.spec.positions[:, 2], [0.015, -0.015], atol=1e-9)
    (doubt,) = (d for d in hand.audit() if "f_2" in d.joint)
    assert doubt.severity == "minor"
    says(doubt.what, "collides")
    assert not hand_of(two(BOX, "visual"), tip_radius=0.005).audit().about("f_2")


def test_a_marker_frame_is_taken_before_the_far_end():
    """A link without geometry, fixed to the last one, is where its maker wants the fingertip."""
    more = "".join(
        f'<link name="{n}_mark"/><joint name="{n}_m" type="fixed"><parent link="{n}_2"/><child link="{n}_mark"/>'
        '<origin xyz="0.038 0 0"/></joint>'
        for n in "fg"
    )
    assert hand_of(two(BOX, more=more)).fingertips == ("f_mark", "g_mark")


def test_only_frames_that_a_joint_moves_are_taken_for_fingertips():
    """A camera called a tip on the palm is none."""
    fixed = '<joint name="c" type="fixed"><parent link="palm"/><child link="camera_tip"/></joint>'
    assert hand_of(two(BOX, more=f'<link name="camera_tip"/>{fixed}')).fingertips == ("f_2", "g_2")


@pytest.mark.parametrize("count", [1, 6])
def test_one_finger_or_six_are_proposed_and_not_taken(count):
    fingers = [finger(f"f{i}", f"0 {0.02 * i} 0", BOX) for i in range(count)]
    with pytest.raises(hl.UnknownName) as caught:
        hand_of(robot(*fingers))
    assert caught.value.valid == tuple(f"f{i}_2" for i in range(count))
    if count == 1:
        says(str(caught.value), "f0_2", "mm", "far end")


def test_a_hand_cut_out_of_a_robot_shows_its_fingertips():
    """The psyonic's anchors, without being named."""
    hand = hl.Hand.from_urdf(psyonic()[0], joint_stiffness=1.0, base="LeftPsyonicAbilityBaseLink")
    assert sorted(hand.fingertips) == sorted(f"Left_{n}_anchor" for n in ("thumb", "index", "middle", "ring", "pinky"))


# ---------------------------------------------------------------- named
def test_points_on_links_move_with_them():
    """R p + o of the link's frame, in the list and in the mapping, which brings names of its own."""
    point = (0.01, 0.002, -0.003)
    q = np.array([0.3, -0.4, 0.5, 0.6])
    frames = hand_of(two(BOX), ["f_2", "g_1"]).at(q)
    expected = frames.tip_positions[0] + frames.tip_rotations[0] @ point
    mapping = {"ring": ("f_2", point), "g_1": "g_1"}
    for tips, names in (([("f_2", point), "g_1"], ("f_2", "g_1")), (mapping, ("ring", "g_1"))):
        hand = hand_of(two(BOX), tips)
        assert hand.fingertips == names
        np.testing.assert_allclose(hand.at(q).tip_positions[0], expected, atol=1e-15)
        np.testing.assert_allclose(hand.at(q).tip_rotations, frames.tip_rotations, atol=1e-15)


def test_a_point_has_the_geometry_of_its_link():
    """The same contact wherever on the link the point is: contacts are found on its geometry."""
    box = hl.Box((0.1, 0.1, 0.03), (0.08, 0, 0))
    every = [None, {"a": ("f_2", (0.01, 0, 0)), "b": ("g_2", (0, 0, 0))}, {"a": "f_2", "b": "g_2"}]
    found = [hand_of(two(BOX), tips).at([0.0] * 4).grasp(box).spec for tips in every]
    for spec in found[1:]:
        np.testing.assert_allclose(spec.positions, found[0].positions, atol=1e-12)
        np.testing.assert_allclose(spec.flexibility, found[0].flexibility, atol=1e-15)


def test_a_radius_is_about_the_point():
    hand = hand_of(two(BOX), {"a": ("f_2", (0.03, 0, 0)), "b": ("g_2", (0.03, 0, 0))}, tip_radius=0.004)
    spec = hand.at([0.0] * 4).grasp(hl.Box((0.1, 0.1, 0.032), (0.08, 0, 0))).spec
    np.testing.assert_allclose(spec.positions, [[0.07, 0, 0.016], [0.07, 0, -0.016]], atol=1e-9)


@pytest.mark.parametrize(
    ("tips", "argument", "message"),
    [
        (["palm"], "fingertips", "environment="),
        ({"a": ("f_2", (30.0, 0, 0))}, "fingertips['a']", "millimetres"),
        ({"a": ("f_2", (0, 0))}, "fingertips['a']", r"\(3\)|\(3,\)"),
        ({"g_1": "f_2"}, "fingertips", "another frame"),
        ({3: ("f_2", (0, 0, 0.01))}, "fingertips", "a name of its own"),
        ({}, "fingertips", "at least one"),
    ],
)
def test_bad_fingertips_are_named(tips, argument, message):
    with pytest.raises(hl.InputError, match=message) as caught:
        hand_of(two(BOX), tips)
    assert caught.value.argument == argument


# ---------------------------------------------------------------- replaced
BY_NAME = {"f_a": 1.0, "f_b": 2.0, "g_a": 3.0, "g_b": 4.0}
NEW = {
    "joint_stiffness": [2.0, BY_NAME, hl.Tendons({"t": {"f_a": 0.01}}, 1e3, 0.1)],
    "pad_flexibility": [1e-4, [1e-4, 2e-4, 3e-4], {"f_2": 1e-3}],
    "torque_limits": [None, 0.3, {"g_b": 0.1}],
    "tip_radius": [None, 0.004, {"f_2": 0.003}],
    "fingertips": [["g_2", "f_2"], [("f_2", (0.01, 0, 0)), "g_2"]],
}


@pytest.mark.parametrize(("argument", "value"), [(a, v) for a, values in NEW.items() for v in values])
def test_replace_equals_a_hand_made_that_way(argument, value):
    """Every array of the two hands, to the last bit, and their verdict on what they touch."""
    start = {
        "joint_stiffness": 1.5,
        "pad_flexibility": 2e-4,
        "torque_limits": {"f_a": 0.2},
        "tip_radius": {"g_2": 0.005},
    }
    hand = hl.Hand.from_urdf(two(BOX), **start)
    made = hl.Hand.from_urdf(two(BOX), **(start | {argument: value}))
    replaced = hand.replace(**{argument: value})
    assert replaced.fingertips == made.fingertips
    q = np.array([0.1, -0.2, 0.05, 0.0])
    one, other = replaced.at(q), made.at(q)
    for name in ("tip_positions", "tip_rotations", "jacobian", "flexibility"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(replaced.torque_limits, made.torque_limits)
    assert str(replaced.audit()) == str(made.audit())
    for i in range(2):
        assert replaced.tip_kind(i) == made.tip_kind(i)
        assert [s.radius for s in replaced.tip_shapes(i)] == [s.radius for s in made.tip_shapes(i)]
    assert hand.fingertips == ("f_2", "g_2"), "the hand itself stays as it is"


# ---------------------------------------------------------------- what looks like a fingertip: names that say so
JOINT = """<joint name="{name}_j" type="revolute"><parent link="{parent}"/><child link="{name}"/><origin xyz="{at}"/>
<axis xyz="0 1 0"/><limit lower="-0.8" upper="0.8" effort="2" velocity="1"/>{mimic}</joint>
<link name="{name}"><collision><origin xyz="0 0 {half}"/><geometry><box size="0.008 0.01 {length}"/></geometry>
</collision></link>"""
PALM = '<link name="palm"><collision><geometry><box size=".1 .03 .02"/></geometry></collision></link>'


def link(name, parent, at, length, follows=None):
    mimic = "" if follows is None else f'<mimic joint="right_knuckle_j" multiplier="{follows}"/>'
    return JOINT.format(name=name, parent=parent, at=at, mimic=mimic, half=length / 2, length=length)


def gripper(bars=True, tip=""):
    """Two fingers that stay parallel: a knuckle and a bar of the same length turn alike, the finger turns back."""
    text = PALM
    for side, way in (("right", 1), ("left", -1)):
        own = None if way > 0 else -1.0
        text += link(f"{side}_knuckle", "palm", f"{0.03 * way} 0 0.01", 0.05, own)
        text += link(f"{side}_finger", f"{side}_knuckle", "0 0 0.05", 0.06, -way)
        if bars:
            text += link(f"{side}_bar", "palm", f"{0.015 * way} 0 0.02", 0.05, way)
        if tip:
            text += f'<joint name="{side}_fixed" type="fixed"><parent link="{side}_finger"/>'
            text += f'<child link="{side}{tip}"/><origin xyz="0 0 0.06"/></joint><link name="{side}{tip}"/>'
    return f'<robot name="g">{text}</robot>'


@pytest.mark.parametrize("tip", ["_tip", "_fingertip_link", "_tip_1", "Tip"])
def test_names_that_say_fingertip_are_taken(tip):
    """Beside bars, whose names do not."""
    hand = hl.Hand.from_urdf(gripper(tip=tip), joint_stiffness=3.0)
    assert hand.fingertips == (f"left{tip}", f"right{tip}")
    reason = 'its name ends in "tip"' if tip.lower().endswith("tip") else "its name says that it is a fingertip"
    assert [t.reason for t in hand.describe().fingertips] == [reason] * 2


@pytest.mark.parametrize("name", ["_stipulated", "_pad_link"])
def test_names_that_only_hold_the_letters_are_not(name):
    """Frames without geometry at the end of a finger are candidates on their own account."""
    found = hl.describe_urdf(gripper(tip=name)).fingertips
    assert all("without geometry" in tip.reason for tip in found)


def test_bars_of_a_linkage_are_no_fingertips():
    """A bar is pinned to the finger: its end is at one point of it in every posture."""
    for bars in (True, False):
        assert hand_of(gripper(bars=bars)).fingertips == ("left_finger", "right_finger")


def test_a_third_finger_that_follows_is_one():
    """Not pinned to anything, although its joint follows the same motor as the others."""
    third = link("third", "palm", "0 0.05 0.02", 0.09, 0.7)
    text = gripper().replace("</robot>", third + "</robot>")
    assert hand_of(text).fingertips == ("left_finger", "right_finger", "third")


LOOP = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .02 .01"/>
{sides}</body></worldbody><equality>{pins}</equality>
<actuator><position joint="right_knuckle" kp="3"/><position joint="left_knuckle" kp="3"/></actuator></mujoco>"""
SIDE = """<body name="{n}_knuckle" pos="{x} 0 .02"><joint name="{n}_knuckle" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".004" fromto="0 0 0 0 0 .05"/>
<body name="{n}_finger" pos="0 0 .05"><joint name="{n}_finger" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".005" fromto="0 0 0 0 0 .06"/></body></body>
<body name="{n}_bar" pos="{y} 0 .02"><joint name="{n}_bar" axis="0 1 0" range="-40 40" stiffness="1"/>
<geom type="capsule" size=".003" fromto="0 0 0 0 0 .05"/></body>"""


@pytest.mark.parametrize("order", ['body1="{n}_bar" body2="{n}_finger"', 'body1="{n}_finger" body2="{n}_bar"'])
def test_bars_that_a_constraint_pins_are_no_fingertips(order):
    pytest.importorskip("mujoco")
    anchor = "0 0 0.05" if '1="{n}_bar' in order else "{w} 0 0"
    sides = pins = ""
    for n, way in (("right", 1), ("left", -1)):
        sides += SIDE.format(n=n, x=0.03 * way, y=0.015 * way)
        pins += f'<connect {order.format(n=n)} anchor="{anchor.format(w=-0.015 * way)}"/>'
    hand = hl.Hand.from_mjcf(LOOP.format(sides=sides, pins=pins))
    assert hand.fingertips == ("left_finger", "right_finger")


def test_a_range_narrowed_to_a_point_is_serious_and_has_no_minus_zero():
    """A follower with multiplier -1 and its leader's range: the gripper cannot move at all."""
    ends = 'lower="-0.8" upper="0.8"', 'lower="0" upper="0.9"'
    text = gripper(bars=False).replace(*ends)
    (doubt,) = (d for d in hl.audit_urdf(text).serious if d.about == "range")
    assert doubt.joint == "right_knuckle_j"
    assert "it cannot move: its range [0, 0.9] is narrowed to 0 by the limits of" in doubt.what
    assert "-0" not in doubt.what
    some = gripper(bars=False).replace(ends[0], 'lower="-0.5" upper="0.8"')
    assert [d.severity for d in hl.audit_urdf(some) if "is narrowed to" in d.what] == ["minor"]


@pytest.mark.parametrize("ends", ['lower="0.3" upper="0.3"', 'lower="-0." upper="0"'])
def test_a_range_that_is_written_as_a_point_is_serious(ends):
    text = gripper(bars=False).replace('lower="-0.8" upper="0.8"', ends, 1)
    (doubt,) = (d for d in hl.audit_urdf(text) if d.about == "range" and "both limits are" in d.what)
    assert (doubt.joint, doubt.severity) == ("right_knuckle_j", "serious")
    assert "-0" not in doubt.what
