"""How hard a hand closes: commands of joints, of depths and of forces, and what of them no joint can make."""

import pickle

import numpy as np
import pytest

from handlcp import Contact, Coulomb, Environment, GraspStream, Synergies, Tendons
from handlcp.errors import InputError, UnknownName
from handlcp.geometry import Box, Sphere
from handlcp.hand import example_hand
from handlcp.scene import read
from tests.support.hand import gaps
from tests.support.refusals import refused
from tests.support.scene_texts import BOX_IN_TWO_FINGERS

from .chains import A, B, chain_hand
from .levers import PAD, C, K, L, lever_hand, lever_pinch

BALL = Sphere(0.03, (0.001, -0.002, 0.09), mass=0.03)
CUBE = Box(0.05, (0, 0, 0.08), mass=0.2)
STICKY = Coulomb(3.0)


def vice(obj):
    """What holds an object still: six contacts all around, ten times stiffer than any pad and pressed together."""
    c, axes = obj.center_of_mass, np.concatenate([np.eye(3), -np.eye(3)])
    return Environment([Contact(c - 0.1 * n, n, Coulomb(1.0)) for n in axes], 1e-9, -1e-6)


def of(hand, obj, **more):
    return hand.at(hand.close_on(obj)).grasp(obj, STICKY, **more)


def leaning(write, degrees, **more):
    """The left lever, whose tip moves along x, against a wall whose normal leans out of the lever's plane."""
    t = np.radians(degrees)
    wall = Contact((-0.01, 0, L), (np.cos(t), np.sin(t), 0), STICKY, tangent=(0, 0, 1))
    return lever_hand(write).at([0.0, 0.0]).grasp({"left_tip": wall}, **more)


# ---------------------------------------------------------------- closed forms
def test_two_joints_press_on_a_wall_with_the_torques_of_that_force(write):
    """Without pads δq = K⁻¹ Jᵀ n f; J of bent links A and B is written down."""
    stiffness, q = np.array([3.0, 5.0, 3.0, 5.0]), np.array([0.3, 0.7, 0.0, 0.0])
    hand = chain_hand(write, joint_stiffness=stiffness)
    x, z = A * np.sin(q[0]) + B * np.sin(q[0] + q[1]), A * np.cos(q[0]) + B * np.cos(q[0] + q[1])
    J = np.array([[z, B * np.cos(q[0] + q[1])], [-x, -B * np.sin(q[0] + q[1])]])  # of x and z
    n = np.array([np.cos(0.2), np.sin(0.2)])
    wall = Contact((-0.01 + x, 0, z), (n[0], 0, n[1]), STICKY)
    assert hand.joint_names[:2] == ("left_root", "left_end")
    grasp = hand.at(q).grasp({"left_tip": wall}, grip_force=4.0)
    np.testing.assert_allclose(grasp.joint_offset[:2], J.T @ n * 4.0 / stiffness[:2], rtol=1e-9)
    g, squeezed = J.T @ n, grasp.replace(squeeze=1e-3)  # the smallest δq with n·J δq = s
    np.testing.assert_allclose(squeezed.joint_offset, [*1e-3 * g / (g @ g), 0.0, 0.0], rtol=1e-9)
    assert squeezed.out_of_reach == grasp.out_of_reach == ()


def test_pads_give_way_beside_the_joints(write):
    """N = L δq / C of a lever with a pad against a wall: to press with f it is told L δq = C f."""
    grasp = leaning(write, 0.0, grip_force=2.0)
    assert grasp.joint_offset @ grasp.joint_offset == pytest.approx((C * 2.0 / L) ** 2, rel=1e-9)


@pytest.mark.parametrize("degrees", [10.0, 60.0])
def test_a_normal_that_leans_out_of_the_plane_is_met_sideways(write, degrees):
    """The tip moves along x alone: by s deeper it moves s / cos θ, s tan θ along the wall; the force is along x."""
    t, s, f = np.radians(degrees), 1e-3, 2.0
    squeezed, gripped = leaning(write, degrees, squeeze=s), leaning(write, degrees, grip_force=f)
    moved = squeezed.jacobian @ squeezed.joint_offset
    assert moved[2] == pytest.approx(s, rel=1e-9)
    assert np.hypot(*moved[:2]) == pytest.approx(s * np.tan(t), rel=1e-9)
    assert abs(gripped.joint_offset).max() == pytest.approx(f / np.cos(t) * (L / K + PAD / L), rel=1e-9)
    (wedge,) = leaning(write, degrees, preload=s).out_of_reach
    assert (wedge.what, wedge.carried, wedge.unit) == ("preload", True, "m")
    np.testing.assert_allclose(wedge.missing, s * np.sin(t), rtol=1e-9)
    np.testing.assert_allclose(wedge.share, np.sin(t), rtol=1e-9)


def test_across_the_plane_nothing_is_within_reach(write):
    squeezed, gripped = leaning(write, 90.0, squeeze=1e-3), leaning(write, 90.0, grip_force=2.0)
    for grasp, what, asked in ((squeezed, "squeeze", 1e-3), (gripped, "grip force", 2.0)):
        (reach,) = grasp.out_of_reach
        assert (reach.what, reach.carried) == (what, False)
        np.testing.assert_allclose(reach.missing, asked, rtol=1e-9)
        np.testing.assert_allclose(reach.share, 1.0, rtol=1e-9)
    assert not squeezed.joint_offset.any()


# ---------------------------------------------------------------- against the forward kinematics
@pytest.mark.parametrize("name", ["three_finger", "five_finger", "allegro"])
def test_to_first_order_a_squeeze_takes_the_tips_so_much_deeper(name):
    hand = example_hand(name)
    fingers = ["link_3.0_tip", "link_7.0_tip", "link_11.0_tip"] if name == "allegro" else list(hand.fingertips)
    obj = {"three_finger": CUBE, "five_finger": BALL, "allegro": Sphere(0.035, (0.06, 0, 0.07))}[name]
    q = hand.close_on(obj, np.zeros(hand.nv), fingers=fingers)
    depth = np.array([1.0, 0.5, 0.8, 0.0, 0.2])[: len(fingers)] * 1e-3
    tips = [hand.fingertips.index(f) for f in fingers]
    missed = []
    for h in (1.0, 0.5):
        command = hand.at(q).grasp(obj, squeeze=h * depth, fingers=fingers).joint_offset
        missed.append(abs(gaps(hand, q + command, obj)[tips] + h * depth).max())
    assert missed[0] < 0.06 * depth.max()
    assert missed[1] < 0.3 * missed[0] + 1e-6


def test_gaps_and_overlaps_count(three):
    """A squeeze says how deep the tips are told to go in all, wherever the posture has them."""
    q = three.close_on(CUBE)
    apart, inside = three.at(q - 0.002), three.at(three.close_on(CUBE, squeeze=1e-3))
    assert apart.grasp(CUBE).offset[:, 2].min() > 1e-4
    for state in (three.at(q), apart, inside):
        np.testing.assert_allclose(state.grasp(CUBE, squeeze=3e-3).offset[:, 2], -3e-3, atol=1e-9)
        none = state.grasp(CUBE, squeeze=0.0)
        np.testing.assert_allclose(none.offset[:, 2], 0.0, atol=1e-9)
        assert none.out_of_reach == ()
    np.testing.assert_allclose(inside.grasp(CUBE, squeeze=0.0).offset, 0.0, atol=1e-9)


def test_the_readmes_cube_is_squeezed_as_a_simulator_of_its_joints_says(three):
    """MuJoCo, joints commanded 5 mm deeper: 3.2, 3.1, 3.1 N and 0.14 mm. As a preload half of it is a wedge."""
    grasp = three.at(three.close_on(CUBE)).grasp(CUBE, Coulomb(0.8), squeeze=5e-3)
    s = grasp.solve("cone")
    np.testing.assert_allclose(s.normal_force, [3.2, 3.1, 3.1], rtol=0.01)
    assert np.linalg.norm(s.object_displacement[:3]) == pytest.approx(0.14e-3, abs=0.005e-3)
    (wedge,) = grasp.replace(preload=5e-3).out_of_reach
    np.testing.assert_allclose(wedge.share, [0.0, 0.5, 0.5], atol=1e-6)
    np.testing.assert_allclose(wedge.missing, [0.0, 2.5e-3, 2.5e-3], atol=1e-8)


# ---------------------------------------------------------------- a grip force, with the object held still
@pytest.mark.parametrize("weighed", [False, True])
@pytest.mark.parametrize("name", ["three_finger", "five_finger"])
def test_on_an_object_that_stays_where_it_is_the_tips_press_as_hard_as_told(name, weighed):
    hand = example_hand(name, joint_stiffness=6.0)
    obj = CUBE if name == "three_finger" else Sphere(0.03, (0, 0, 0.09), mass=0.03)
    force = np.array([3.0, 2.0, 1.0, 0.5, 2.5])[: len(hand.fingertips)]
    grasp = of(hand, obj, grip_force=force, environment=vice(obj), finger_weight=weighed)
    s = grasp.solve("cone")
    assert abs(s.object_displacement).max() < 1e-6
    np.testing.assert_allclose(s.normal_force[: len(force)], force, rtol=1e-4)
    (effect,) = [e for e in grasp.spec.effects if getattr(e, "reach", None) is not None]
    sideways = np.linalg.norm(s.tangential_force[: len(force)], axis=1)
    np.testing.assert_allclose(effect.reach.sideways, sideways, atol=1e-3)
    assert effect.reach.complete
    lean = np.tan(np.radians(30)) if name == "three_finger" else 0.0  # of the flanks' normals, out of the planes
    np.testing.assert_allclose(sideways[1:], lean * force[1:], atol=2e-3)


# ---------------------------------------------------------------- what actuators can command
def test_rigid_joints_are_commanded_all_the_same(write):
    hand = chain_hand(write, joint_stiffness=np.inf, pad_flexibility=PAD)
    z = A + B * np.cos(0.5)
    wall = Contact((-0.01 + B * np.sin(0.5), 0, z), (1, 0, 0), STICKY)
    q = dict.fromkeys(hand.joint_names, 0.0) | {"left_end": 0.5}
    state = hand.at(q)
    grasp = state.grasp({"left_tip": wall}, squeeze=1e-3)
    assert (grasp.jacobian @ grasp.joint_offset)[2] == pytest.approx(1e-3, rel=1e-9)
    gripped = state.grasp({"left_tip": wall}, grip_force=3.0)
    np.testing.assert_allclose(gripped.jacobian @ gripped.joint_offset, [0, 0, 3.0 * PAD], atol=1e-12)
    bare = chain_hand(write, joint_stiffness=np.inf).at(q)
    refused("grip_force", bare.grasp, {"left_tip": wall}, match="left_tip, which is rigid", grip_force=3.0)


def test_tendons_command_what_drawing_them_in_does(three):
    R = np.random.default_rng(0).uniform(0.005, 0.01, (2, three.nv))
    hand = example_hand("three_finger", joint_stiffness=Tendons(R, [4e4, 5e4], 2.0))
    for asked in ({"squeeze": 2e-3}, {"grip_force": 2.0}):
        grasp = of(hand, CUBE, **asked)
        pull = np.linalg.solve(hand.joint_stiffness, R.T)
        drawn, _, rank, _ = np.linalg.lstsq(pull, grasp.joint_offset, rcond=None)
        assert rank == 2
        np.testing.assert_allclose(pull @ drawn, grasp.joint_offset, atol=1e-9 * abs(grasp.joint_offset).max())
        assert abs(drawn).max() > 0
        (reach,) = grasp.out_of_reach
        assert reach.what.replace(" ", "_") in asked
        assert (reach.share <= 1.0).all()


def test_one_synergy_squeezes_all_fingers_alike():
    """Five fingers on a ball at the middle are told one depth, and one actuator makes it; of one alone it cannot."""
    curl = np.tile([1.0, 0.5], 5)[:, None]
    hand = example_hand("five_finger", joint_stiffness=Synergies(curl, 20.0, 6.0))
    ball = Sphere(0.035, (0, 0, 0.07))
    grasp = of(hand, ball, squeeze=2e-3)
    assert grasp.out_of_reach == ()
    np.testing.assert_allclose(grasp.joint_offset, curl[:, 0] * grasp.joint_offset[0], rtol=1e-9)
    (reach,) = grasp.replace(squeeze={"finger_1_tip": 2e-3}).out_of_reach
    # Least squares of five equations 0 = s_i - s: the mean
    np.testing.assert_allclose(reach.missing, [1.6e-3, 0.4e-3, 0.4e-3, 0.4e-3, 0.4e-3], rtol=1e-3)
    np.testing.assert_allclose(reach.share, [0.8, 1, 1, 1, 1], rtol=1e-3)


# ---------------------------------------------------------------- doors
def test_a_number_an_array_and_a_mapping_say_the_same(three):
    state = three.at(three.close_on(CUBE))
    for argument, value in (("squeeze", 2e-3), ("grip_force", 1.5)):
        one = state.grasp(CUBE, **{argument: value}).joint_offset
        for given in ([value] * 3, dict.fromkeys(three.fingertips, value), np.full(3, value)):
            np.testing.assert_array_equal(state.grasp(CUBE, **{argument: given}).joint_offset, one)
            np.testing.assert_array_equal(state.grasp(CUBE).replace(**{argument: given}).joint_offset, one)
    closed = three.close_on(CUBE, squeeze={"finger_1_tip": 2e-3})
    np.testing.assert_allclose(gaps(three, closed, CUBE), [-2e-3, 0, 0], atol=1e-6)


@pytest.mark.parametrize("force", [[0.5, 0.6, 0.6], {"finger_1_tip": 0.5, "finger_2_tip": 0.6, "finger_3_tip": 0.6}])
def test_advice_to_press_harder_says_with_how_many_newtons(three, force):
    grasp = three.at(three.close_on(CUBE)).grasp(CUBE, 0.5, grip_force=force)
    said = [advice.sentence for advice in grasp.check().about("advice")]
    assert said[0].startswith("500 % of the grip force (2.5 to 3 N) would hold it")


def test_a_preload_comes_beside_a_squeeze_and_another_squeeze_in_its_place(three):
    first = three.at(three.close_on(CUBE)).grasp(CUBE, squeeze=2e-3)
    np.testing.assert_allclose(first.replace(squeeze=0.0).offset, 0.0, atol=2e-6)
    beside = first.replace(preload=1e-3)  # of tips without a gap, beside the command
    np.testing.assert_allclose(beside.offset[:, 2], -3e-3, atol=2e-6)
    np.testing.assert_allclose(beside.replace(squeeze=1e-3).offset[:, 2], -2e-3, atol=1e-12)


def test_a_stream_tells_gaps_from_preloads(three):
    """The posture moves and the gaps stay; an offset that is passed takes their place."""
    q = three.close_on(CUBE, squeeze=4e-3)
    stream = GraspStream(three.at(q).grasp(CUBE, Coulomb(0.8)))
    stream.update(q + 0.02)
    assert stream.grasp.out_of_reach == ()
    stream.update(offset=[[0, 0, -4e-3]] * 3)
    (wedge,) = stream.grasp.out_of_reach
    np.testing.assert_allclose(wedge.share, [0, 0.5, 0.5], atol=1e-6)


BAD_OFFSETS = [
    ({"joint_offset": [0.1] * 5 + [np.nan]}, InputError, "joint_offset"),
    ({"joint_offset": {"finger_1_distal": "a"}}, InputError, "joint_offset['finger_1_distal']"),
    ({"joint_offset": {"thumb": 0.1}}, UnknownName, "joint_offset"),
]


@pytest.mark.parametrize(
    ("bad", "kind", "argument"),
    [
        *BAD_OFFSETS,
        ({"squeeze": [1e-3, 1e-3, -1e-3]}, InputError, "squeeze"),
        ({"squeeze": {"thumb": 1e-3}}, UnknownName, "squeeze"),
        ({"squeeze": {"finger_1_tip": "a"}}, InputError, "squeeze['finger_1_tip']"),
        ({"grip_force": np.nan}, InputError, "grip_force"),
        ({"squeeze": 1e-3, "grip_force": 1.0}, InputError, "grip_force"),
        ({"squeeze": 1e-3, "joint_offset": [0.0] * 6}, InputError, "joint_offset"),
    ],
)
def test_what_makes_no_sense_is_named(three, bad, kind, argument):
    state = three.at(three.close_on(CUBE))
    refused(argument, state.grasp, CUBE, error=kind, **bad)
    refused(argument, state.grasp(CUBE).replace, error=kind, **bad)


@pytest.mark.parametrize(("bad", "kind", "argument"), BAD_OFFSETS)
def test_a_stream_refuses_the_same_offsets(three, bad, kind, argument):
    stream = GraspStream(three.at(three.close_on(CUBE)).grasp(CUBE, preload=1e-3))
    refused(argument, stream.update, error=kind, **bad)


# ---------------------------------------------------------------- squeeze given in joint space: its sign, its size
EXACT = {"rtol": 1e-9, "atol": 1e-15}


@pytest.mark.parametrize("faces", [8, "cone"])
def test_flexing_a_pinch_inwards_preloads_it(write, faces):
    """Either tip would go L δq inwards; the springs K behind lever L and the pads take that up: N = L δq / C."""
    s = lever_pinch(lever_hand(write), joint_offset=[0.1, 0.1]).solve(faces)
    np.testing.assert_allclose(s.normal_force, L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.torques, L * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.joint_deflection, L * L * 0.1 / C / K, **EXACT)
    np.testing.assert_allclose(s.object_displacement, [0, 0, -0.5 * PAD, 0, 0, 0], atol=1e-15)


def test_one_joint_squeezes_both_and_moves_the_object(write):
    """N = L δq / (2 C) on both sides, and the object gives way to the finger that pushes, by C N."""
    s = lever_pinch(lever_hand(write), joint_offset={"left_joint": 0.1}).solve()
    np.testing.assert_allclose(s.normal_force, 0.5 * L * 0.1 / C, **EXACT)
    np.testing.assert_allclose(s.object_displacement[0], 0.5 * L * 0.1, **EXACT)


@pytest.mark.parametrize("nothing", [{}, [0.0, 0.0]])
def test_none_changes_no_bit(write, nothing):
    hand = lever_hand(write)
    a, b = lever_pinch(hand, preload=1e-3).problem(), lever_pinch(hand, preload=1e-3, joint_offset=nothing).problem()
    np.testing.assert_array_equal(a.scaled.M, b.scaled.M)
    np.testing.assert_array_equal(a.scaled.q, b.scaled.q)


def test_replacing_keeps_it_or_changes_it(write):
    hand = lever_hand(write)
    g = lever_pinch(hand, joint_offset=[0.1, 0.1])
    lifted = pickle.loads(pickle.dumps(g)).replace(wrench=(0, 0, -2, 0, 0, 0))
    np.testing.assert_allclose(lifted.solve().normal_force, L * 0.1 / C, **EXACT)
    more = g.replace(preload=1e-3)  # comes beside it, as in state.grasp
    np.testing.assert_allclose(more.offset, lever_pinch(hand, joint_offset=[0.1, 0.1], preload=1e-3).offset)
    half = more.replace(joint_offset={"left_joint": 0.05, "right_joint": 0.05})
    np.testing.assert_allclose(half.offset[:, 2], -1e-3 - 0.05 * L, **EXACT)
    np.testing.assert_allclose(half.tip_offset[:, 2], -1e-3, **EXACT)
    none = half.replace(joint_offset=[0, 0])
    np.testing.assert_allclose(none.offset[:, 2], -1e-3, **EXACT)
    extra = lever_pinch(hand, joint_offset=[0.01, 0.01], force=(0, 0, -8.0)).required_preload()
    # Followed, the levers turn a little; by hand they do not
    np.testing.assert_allclose(extra.value, 8 / (2 * 0.5) * C - 0.01 * L, rtol=1e-2)


SCENE = f"""
{BOX_IN_TWO_FINGERS}
[grasp]
joint_offset_rad = {{finger_1_distal = 0.1, finger_2_distal = 0.1}}
"""


def test_a_scene_file_says_it_by_joint():
    grasp = read(SCENE).build()
    hand = grasp.state.hand
    assert dict(zip(hand.joint_names, grasp.joint_offset.tolist(), strict=True))["finger_2_distal"] == 0.1
    assert read(SCENE).solve().held
    refused("grasp.joint_offset_rad", read(SCENE.replace("finger_2_distal", "thumb")).build, error=UnknownName)
    contact = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[grasp]\njoint_offset_rad = [0.1]"
    with pytest.raises(InputError, match=r"grasp\.joint_offset_rad: .*\[hand\]"):
        read(contact)
