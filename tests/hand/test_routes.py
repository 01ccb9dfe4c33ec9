"""Tendons in space: closed forms, MuJoCo's lengths and arms, central differences, and what is no route."""

from functools import cache
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.actuation import Around, Pulley, Route, Site
from handlcp.errors import InputError, UnknownName
from handlcp.hand import Hand, example_hand
from handlcp.kinematics.cable_kinematics import CablePosture, lay_tendons, tendon_arm_rates
from handlcp.robot.mjcf_cable import read_routes
from tests.support.kernels import interpreted

from .chains import chain_hand
from .conftest import inside

STEP = 1e-6
Y = (0.0, 1.0, 0.0)


@cache
def of_mjcf(text, tip):
    return Hand.from_mjcf(text, [tip], joint_stiffness=1.0, tip_radius=0.005)


def postures(hand, n):
    return np.random.default_rng(0).uniform(hand.lower, hand.upper, (n, hand.nv))


def differences(bound, q, of, step=STEP):
    """(nv, …) how what the path has `of` name changes with the joints, by central differences."""
    ends = [(getattr(bound.at(q + d), of), getattr(bound.at(q - d), of)) for d in step * np.eye(len(q))]
    return np.array([(ahead - behind) / (2 * step) for ahead, behind in ends])


# ---------------------------------------------------------------- closed forms
@pytest.fixture
def chains(write):
    """Two fingers of two joints about y; link left_1 begins at (-0.01, 0, 0), and left_2 at its top."""
    return chain_hand(write, joint_stiffness=1.0, tip_radius=0.005)


def left(hand, root=0.0, end=0.0):
    return {name: {"left_root": root, "left_end": end}.get(name, 0.0) for name in hand.joint_names}


def arm_of(hand, path, joint):
    return float(path.arms[hand.joint_names.index(joint)])


@pytest.mark.parametrize("angle", [-1.1, 0.0, 0.4, 1.5])
def test_the_arm_of_a_straight_cable_is_its_distance_from_the_axis(chains, angle):
    """From the palm to the first link: length by the law of cosines, arm |p × u| about the hinge; no other joint."""
    p, r = np.array([0.02, 0.0, -0.01]), np.array([0.012, 0.0, 0.03])  # seen from the hinge; the second on the link
    bound = Route([Site("palm", p + np.array([-0.01, 0, 0])), Site("left_1", r)]).bound(chains.kinematics)
    path = bound.at(left(chains, angle))
    turned = np.array(pin.rpy.rpyToMatrix(0.0, angle, 0.0)) @ r
    u = (turned - p) / np.linalg.norm(turned - p)
    assert path.length == pytest.approx(np.linalg.norm(turned - p), abs=1e-15)
    assert arm_of(chains, path, "left_root") == pytest.approx(-np.cross(p, u)[1], abs=1e-15)
    assert [arm_of(chains, path, name) for name in chains.joint_names if name != "left_root"] == [0.0, 0.0, 0.0]
    assert path.angles.shape == (0,)


R = 0.006


def on_pulley(top=0.03):
    """Up the back of the finger, on a pulley of radius R about the first hinge; sites below and above its edge."""
    pulley = Around("palm", ((-0.01, 0.0, 0.0), Y), R, side=(-0.011, 0.0, 0.02))
    return Route([Site("palm", (-0.01 - R, 0.0, -0.03)), pulley, Site("left_1", (-R, 0.0, top))])


@pytest.mark.parametrize("angle", [0.05, 0.7, 1.9])
def test_on_a_pulley_the_arm_is_its_radius_and_the_angle_that_of_the_joint(chains, angle):
    """Sites on the tangents: the cable lies on the pulley over exactly the angle of the joint, and lengthens by r θ."""
    path = on_pulley().bound(chains.kinematics).at(left(chains, angle))
    assert path.angles == pytest.approx([angle], abs=1e-15)
    assert arm_of(chains, path, "left_root") == pytest.approx(-R, abs=1e-15)
    assert path.length == pytest.approx(0.06 + R * angle, abs=1e-15)


def test_a_cable_leaves_a_pulley_that_is_not_in_its_way(chains):
    """Bent the other way it is straight, between the sites and on the right side of the axis."""
    path = on_pulley().bound(chains.kinematics).at(left(chains, -0.3))
    assert path.angles == [0.0]
    assert len(path.pieces) == 1
    assert path.length == pytest.approx(np.linalg.norm(path.pieces[0].end - path.pieces[0].start), abs=1e-15)
    assert abs(arm_of(chains, path, "left_root")) > R


def test_without_a_side_the_cable_goes_round_where_that_is_shorter(chains):
    """One site on each side of the plane through the axis: the cable passes on the side of both."""
    for x in (-0.002, 0.002):
        pulley = Around("palm", ((-0.01, 0.0, 0.0), Y), R)
        route = Route([Site("palm", (-0.01 + x, 0, -0.03)), pulley, Site("palm", (-0.01 + x, 0, 0.03))])
        path = route.bound(chains.kinematics).at(left(chains))
        assert np.sign(path.pieces[0].end[0] + 0.01) == np.sign(x)
        d = np.hypot(0.03, x)
        turn = np.pi - 2 * np.arctan2(abs(x), 0.03) - 2 * np.arccos(R / d)  # between the tangents from both
        assert path.angles == pytest.approx([turn], abs=1e-14)
        assert path.length == pytest.approx(2 * np.sqrt(d**2 - R**2) + R * turn, abs=1e-15)
        assert not path.arms.any()


def test_on_a_cylinder_a_cable_with_a_slope_is_straight_once_unrolled(chains):
    """Rise h over the flat length F: √(F² + h²), pieces of one slope, and the angle θ F/√(F² + h²) of the capstan."""
    h, angle = 0.02, 0.9
    flat = on_pulley().bound(chains.kinematics).at(left(chains, angle)).length
    first, body, last = on_pulley().places
    risen = Route([first, body, Site("left_1", last.point + np.array([0, h, 0]))])
    path = risen.bound(chains.kinematics).at(left(chains, angle))
    assert path.length == pytest.approx(np.hypot(flat, h), abs=1e-15)
    assert path.angles == pytest.approx([angle * flat / np.hypot(flat, h)], abs=1e-14)
    ways = [(s.end - s.start) / np.linalg.norm(s.end - s.start) for s in path.pieces]
    assert [way[1] for way in ways] == pytest.approx([h / np.hypot(flat, h)] * 2, abs=1e-14)


def test_a_ball_through_whose_centre_the_line_goes(chains):
    """Any plane is as good, the side's where there is one; length 2 √(d² - r²) + r (π - 2 arccos(r/d))."""
    d, r = 0.03, 0.008
    for side in (None, (-0.01, 0.05, 0.0)):
        route = Route([Site("palm", (-0.01, 0, -d)), Around("palm", (-0.01, 0, 0), r, "sphere", side),
                       Site("palm", (-0.01, 0, d))])  # fmt: skip
        path = route.bound(chains.kinematics).at(left(chains))
        turn = np.pi - 2 * np.arccos(r / d)
        assert path.length == pytest.approx(2 * np.sqrt(d**2 - r**2) + r * turn, abs=1e-15)
        assert path.angles == pytest.approx([turn], abs=1e-14)
        if side:
            assert path.pieces[0].end[1] > 0.0


def test_a_placement_is_one_however_it_is_said(chains):
    """A pin.SE3 whose z is the axis, and a point with the axis."""
    first, body, last = on_pulley().places
    turned = pin.SE3(np.array(pin.rpy.rpyToMatrix(-np.pi / 2, 0.0, 0.0)), np.array([-0.01, 0.0, 0.0]))
    other = Route([first, Around("palm", turned, body.radius, side=body.side), last])
    q = left(chains, 0.8)
    ours, theirs = (route.bound(chains.kinematics).at(q) for route in (on_pulley(), other))
    assert ours.length == pytest.approx(theirs.length, abs=1e-16)
    np.testing.assert_allclose(ours.arms, theirs.arms, atol=1e-16)


# ---------------------------------------------------------------- against MuJoCo
def finger(name, at, links=3, spread=False, ball=False):
    """A finger along z of links 40 mm long: its <body>, and <spatial> tendons on both sides of its joints.

    A joint carries a cylinder, or a ball, whose side sites are flexor and extensor; with spread the first has two axes.
    """
    shape = 'type="sphere" size="0.006"' if ball else 'type="cylinder" size="0.006 0.02" euler="1.5707963 0 0"'
    body, tail, flexor, extensor = "", "", "", ""
    for k in range(links):
        pos = f'pos="{at}"' if k == 0 else 'pos="0 0 0.04"'
        off = 'pos="0.001 0 -0.002" ref="0.1"' if spread and k < 2 else ""  # beside its body's origin
        wide = f'<joint name="{name}_spread" axis="1 0 0" range="-0.4 0.4"/>' if spread and k == 0 else ""
        body += f"""<body name="{name}_{k}" {pos}>{wide}<joint name="{name}_j{k}" axis="0 1 0" range="-0.6 1.4" {off}/>
          <geom name="{name}_w{k}" {shape} contype="0" conaffinity="0" mass="0.01"/>
          <geom type="capsule" size="0.004" fromto="0 0 0.005 0 0 0.03" mass="0.01"/>
          <site name="{name}_in{k}" pos="0.02 0.001 0"/><site name="{name}_out{k}" pos="-0.02 0.002 0"/>
          <site name="{name}_f{k}" pos="0.008 0.002 0.02"/><site name="{name}_e{k}" pos="-0.007 -0.001 0.021"/>"""
        tail += "</body>"
        flexor += f'<geom geom="{name}_w{k}" sidesite="{name}_in{k}"/><site site="{name}_f{k}"/>'
        extensor += f'<geom geom="{name}_w{k}" sidesite="{name}_out{k}"/><site site="{name}_e{k}"/>'
    tendons = "".join(
        f'<spatial name="{name}_{kind}"><site site="{name}_{kind}_root"/>{way}</spatial>'
        for kind, way in (("flexor", flexor), ("extensor", extensor))
    )
    x, y, z = (float(v) for v in at.split())
    roots = (f'<site name="{name}_flexor_root" pos="{x + 0.009} {y} {z - 0.02}"/>'
             f'<site name="{name}_extensor_root" pos="{x - 0.008} {y} {z - 0.03}"/>')  # fmt: skip
    return roots + body + tail, tendons


def mjcf(bodies, tendons):
    return f"""<mujoco model="cabled"><compiler angle="radian" autolimits="true"/><worldbody>
      <body name="palm"><geom type="box" size="0.03 0.04 0.005" pos="0 0 -0.05" mass="0.1"/>{bodies}</body></worldbody>
      <tendon>{tendons}</tendon></mujoco>"""


def planar():
    """Three joints, cylinders at them; beside the flexor and the extensor a cable without side sites."""
    bodies, tendons = finger("f", "0 0 0")
    free = '<spatial name="free"><site site="f_extensor_root"/><geom geom="f_w0"/><site site="f_f0"/></spatial>'
    return mjcf(bodies, tendons + free)


def spatial():
    """Two axes at the root; balls at one finger's joints, oblique cables round a cylinder of the other, and free ones
    round a ball.
    """
    balls, first = finger("b", "0 0.02 0", spread=True, ball=True)
    rods, second = finger("c", "0.01 -0.02 0", spread=True)
    across = """<spatial name="across"><site site="b_extensor_root"/><geom geom="b_w0"/><site site="b_f1"/></spatial>
      <spatial name="oblique"><site site="far"/><geom geom="c_w0" sidesite="c_in0"/><site site="c_f0"/>
      </spatial>"""
    far = '<site name="far" pos="0.03 -0.045 -0.03"/>'
    return mjcf(far + balls + rods, first + second + across)


def whole_hand():
    """Five fingers of three or four joints and twenty tendons: two sided ones a finger, a free one, a differential."""
    at = ["0.05 0.03 -0.02", "0 0.03 0", "0 0.01 0.003", "0 -0.01 0", "0 -0.03 -0.004"]
    made = [finger(f"f{i}", place, spread=i != 2, ball=i in (0, 3)) for i, place in enumerate(at)]
    tendons = "".join(part for _, part in made)
    for i in range(5):
        other = (i + 1) % 5
        tendons += f"""<spatial name="free{i}"><site site="f{i}_extensor_root"/><geom geom="f{i}_w0"/>
          <site site="f{i}_f0"/><site site="f{i}_e1"/><geom geom="f{i}_w2"/><site site="f{i}_f2"/></spatial>
          <spatial name="pair{i}"><site site="f{i}_flexor_root"/><site site="f{i}_f0"/>
          <pulley divisor="2"/><site site="f{i}_flexor_root"/><geom geom="f{i}_w0" sidesite="f{i}_in0"/>
          <site site="f{i}_f0"/><pulley divisor="3"/><site site="f{other}_flexor_root"/>
          <geom geom="f{other}_w0" sidesite="f{other}_in0"/><site site="f{other}_f0"/></spatial>"""
    return mjcf("".join(part for part, _ in made), tendons)


HANDS = [(planar, "f_2", 3), (spatial, "b_2", 6), (whole_hand, "f0_2", 20)]


def arms_of_mujoco(mujoco, model, data):
    """(tendons, dofs) -dL/dq."""
    J = np.zeros((model.ntendon, model.nv))
    mujoco.mju_sparse2dense(J, data.ten_J.ravel(), model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind.ravel())
    return -J


@pytest.mark.parametrize(("write_hand", "tip", "n"), HANDS)
def test_lengths_and_arms_are_those_of_mujoco(write_hand, tip, n):
    """In 100 postures to 1e-9; at least as many wraps as there are tendons touch in some of them and not in others."""
    mujoco = pytest.importorskip("mujoco")
    text = write_hand()
    model = mujoco.MjModel.from_xml_string(text)
    data, hand = mujoco.MjData(model), of_mjcf(text, tip)
    read, refused = read_routes(model)
    assert len(read) == n
    assert refused == {}
    bounds = [(model.tendon(name).id, route.bound(hand.kinematics, name)) for name, route in read.items()]
    dofs = [int(model.jnt_dofadr[model.joint(name).id]) for name in hand.joint_names]
    touched = []
    for q in postures(hand, 100):
        data.qpos[dofs] = q
        mujoco.mj_fwdPosition(model, data)
        arms = arms_of_mujoco(mujoco, model, data)[:, dofs]
        paths = [(t, bound.at(q)) for t, bound in bounds]
        for t, path in paths:
            assert path.length == pytest.approx(data.ten_length[t], abs=1e-9)
            np.testing.assert_allclose(path.arms, arms[t], atol=1e-9, rtol=0)
        touched.append(np.concatenate([path.angles for _, path in paths]) > 0)
    shares = np.mean(touched, axis=0)
    assert np.count_nonzero((shares > 0.02) & (shares < 0.98)) >= n


def test_a_side_chooses_the_way_that_mujoco_chooses(chains):
    """Points, side and shape at random about one circle: arcs up to more than half a turn, and straight cables."""
    mujoco = pytest.importorskip("mujoco")
    rng, more_than_half = np.random.default_rng(3), 0
    for shape in ("cylinder", "sphere"):
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody><site name="a" pos="1 0 0"/>
          <site name="b" pos="2 0 0"/><site name="s" pos="3 0 0"/>
          <geom name="g" type="{shape}" size="0.01 0.02"/><body><joint/><geom size="0.01"/></body></worldbody>
          <tendon><spatial><site site="a"/><geom geom="g" sidesite="s"/><site site="b"/></spatial></tendon></mujoco>""")
        data = mujoco.MjData(model)
        for _ in range(150):
            angles, away = rng.uniform(-np.pi, np.pi, 3), rng.uniform(0.0101, 0.04, 3)
            points = np.array([away * np.cos(angles), away * np.sin(angles), rng.uniform(-0.01, 0.01, 3)]).T
            model.site_pos[:] = points
            mujoco.mj_fwdPosition(model, data)
            around = Around("palm", (np.zeros(3), (0.0, 0.0, 1.0)), 0.01, shape, points[2])
            route = Route([Site("palm", points[0]), around, Site("palm", points[1])])
            path = route.bound(chains.kinematics).at(left(chains))
            assert path.length == pytest.approx(data.ten_length[0], abs=1e-9)
            more_than_half += path.angles[0] > np.pi
    assert more_than_half > 5


# ---------------------------------------------------------------- differences
@pytest.mark.parametrize(("write_hand", "tip", "n"), HANDS)
def test_arms_are_the_derivatives_of_the_length(write_hand, tip, n):
    """Central differences; postures in which a wrap comes or goes within a step are rare and left out."""
    mujoco = pytest.importorskip("mujoco")
    text = write_hand()
    hand = of_mjcf(text, tip)
    read, _ = read_routes(mujoco.MjModel.from_xml_string(text))
    for name, route in read.items():
        bound = route.bound(hand.kinematics, name)
        for q in postures(hand, 3):
            np.testing.assert_allclose(bound.at(q).arms, -differences(bound, q, "length"), atol=1e-9)


OVER_MIMICS = Route([
    Site("palm", (0.0, 0.03, 0.0)), Site("a", (0.02, 0.0, 0.01)),
    Around("b", ((0.02, 0.0, 0.0), (0.0, 0.0, 1.0)), 0.004), Site("c", (0.02, 0.01, 0.0)),
    Pulley(1.5), Site("c", (0.0, 0.0, 0.02)), Site("d", (0.03, 0.0, 0.0)),
])  # fmt: skip


def test_arms_of_joints_that_others_follow(coupled):
    """Mimic joints, a mimic of a mimic and a continuous joint: arms over the independent joints only."""
    bound = OVER_MIMICS.bound(coupled.kinematics)
    touched = 0
    for seed in range(5):
        q = inside(coupled, seed)
        path = bound.at(q)
        assert path.arms.shape == (2,)
        np.testing.assert_allclose(path.arms, -differences(bound, q, "length"), atol=1e-9)
        np.testing.assert_allclose(np.sum([piece.arms for piece in path.pieces], axis=0), path.arms, atol=1e-15)
        touched += np.count_nonzero(path.angles)
    assert touched


def test_pieces_and_arcs_make_up_the_path(chains):
    """They follow each other, touch the cylinder along its tangents, and make up the length."""
    path = on_pulley().bound(chains.kinematics).at(left(chains, 0.8))
    first, last = path.pieces
    straight = sum(float(np.linalg.norm(piece.end - piece.start)) for piece in path.pieces)
    assert straight + R * path.angles[0] == pytest.approx(path.length, abs=1e-15)
    for piece, point in ((first, first.end), (last, last.start)):
        radial = point - np.array([-0.01, 0.0, 0.0])
        assert np.linalg.norm(radial) == pytest.approx(R, abs=1e-16)
        assert radial @ (piece.end - piece.start) == pytest.approx(0.0, abs=1e-16)
    assert (first.turned, last.turned) == (0.0, path.angles[0])


# ---------------------------------------------------------------- what is no route
SITE = Site("palm", (0, 0, 0))
BALL = Around("palm", (0, 0, 0.1), 0.01, "sphere")


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Site("palm", (0, 0)), r"Site.point: expected metres in the link's frame of shape .3,., got shape"),
        (lambda: Around("palm", (0, 0, 0), 0.0, "sphere"), "Around.radius: expected a finite number > 0"),
        (lambda: Around("palm", (0, 0, 0), 0.01), "Around.placement: expected a pin.SE3"),
        (lambda: Around("palm", (0, 0, 0), 0.01, "cone"), 'Around.shape: expected "cylinder" or "sphere", got'),
        (lambda: Around("palm", ((0, 0, 0), Y), 0.01, side=(0, 1, 0)), "Around.side: expected a point beside the axis"),
        (lambda: Pulley(-1), "Pulley.divisor: expected a finite number > 0"),
        (lambda: Route([SITE]), r"Route.places\[0\]: expected a branch of at least two Sites"),
        (lambda: Route([SITE, BALL]), r"Route.places\[1\]: expected an Around between two Sites, got Site before"),
        (lambda: Route([SITE, SITE, Pulley(2)]), r"Route.places\[2\]: expected a Pulley that a Site follows"),
    ],
)
def test_what_is_no_route_is_refused_by_name(make, named):
    with pytest.raises(InputError, match=named):
        make()


def test_a_link_that_is_not_there_is_named(chains):
    with pytest.raises(UnknownName, match=r"pull.places\[1\].link: .*'left_3'; did you mean 'left_") as found:
        Route([SITE, Site("left_3", (0, 0, 0))]).bound(chains.kinematics, "pull")
    assert "left_2" in found.value.valid


def test_a_site_inside_what_the_tendon_goes_round_is_named_with_its_posture(chains):
    """On the surface is outside: there the cable begins on the body. Deeper, the depth is said."""
    for depth, fails in ((0.0, False), (1e-4, True)):
        route = Route([SITE, Around("left_1", ((0, 0, 0.05), Y), 0.01), Site("left_1", (0, 0, 0.04 + depth))])
        bound = route.bound(chains.kinematics, "pull")
        if not fails:
            assert np.isfinite(bound.at(left(chains, 0.2)).arms).all()
            continue
        with pytest.raises(InputError, match=r"pull.places\[2\]: expected a site outside the cylinder.*0.1 mm inside"):
            bound.at(left(chains, 0.2))


def test_a_tendon_of_an_mjcf_file_that_cannot_be_read_is_told_why():
    """A side site inside its geom, and one on another body; the rest is read, and sums of joint angles are left out."""
    mujoco = pytest.importorskip("mujoco")
    inside = '<site name="f_mid" pos="0.001 0 0"/>'
    bodies = finger("f", "0 0 0")[0].replace('<site name="f_in0"', f'{inside}<site name="f_in0"')
    ends = '<site site="f_flexor_root"/>{}<site site="f_f0"/>'
    tendons = '<fixed name="sum"><joint joint="f_j0" coef="0.01"/></fixed>'
    for name, side in (("good", "f_in0"), ("through", "f_mid"), ("other", "f_in1")):
        around = f'<geom geom="f_w0" sidesite="{side}"/>'
        tendons += f'<spatial name="{name}">{ends.format(around)}</spatial>'
    text = mjcf(bodies, tendons)
    read, refused = read_routes(mujoco.MjModel.from_xml_string(text))
    assert list(read) == ["good"]
    assert refused["through"] == "geom 'f_w0': its side site is inside, and the tendon with it"
    assert refused["other"] == "site 'f_in1' is the side site of a geom on 'f_0', and on another body"


# ---------------------------------------------------------------- all tendons of a hand in one call: each as if alone
@cache
def cabled(friction=0.0):
    """Two flexors round cylinders, an extensor round a ball on the other side, and a differential."""
    routes = dict[str, Route]()
    for k, a in ((1, 0.0), (2, 2 * np.pi / 3), (3, -2 * np.pi / 3)):
        near, far, s = f"finger_{k}_proximal_link", f"finger_{k}_distal_link", 1.0 if k == 3 else -1.0
        r = 0.045 + s * 0.012
        shape = "sphere" if k == 3 else "cylinder"
        at = (0, 0, 0.05) if k == 3 else ((0, 0, 0.05), Y)
        routes[f"cable {k}"] = Route([
            Site("palm", (r * np.cos(a), r * np.sin(a), -0.005)), Site(near, (s * 0.009, 0.002, 0.02)),
            Around(near, at, 0.006, shape, (s * 0.02, 0, 0.05)), Site(far, (s * 0.004, -0.001, 0.015)),
        ])  # fmt: skip
    if not friction:
        first, second = (routes[f"cable {k}"].places[:2] for k in (1, 2))
        routes["pair"] = Route([Pulley(2), *first, Pulley(2), *second])
    return example_hand("three_finger", joint_stiffness=hl.Tendons(routes, 3e4, 1.0, pretension=2.0, friction=friction))


def random_postures(hand, n):
    return np.random.default_rng(1).uniform(-0.5, 0.9, (n, hand.nv))


def alone(hand):
    return [route.bound(hand.kinematics) for route in hand.stiffness.routes.values()]


def test_a_hand_has_the_arms_and_lengths_of_each_route():
    hand = cabled()
    wraps = 0
    for q in random_postures(hand, 5):
        there, paths = hand.posed(q).stiffness, [bound.at(q) for bound in alone(hand)]
        np.testing.assert_array_equal(there.arms, [path.arms for path in paths])
        lengths = -there.cables.shift - there.arms @ q
        np.testing.assert_allclose(lengths, [path.length for path in paths], rtol=0.0, atol=1e-16)
        wraps += sum(int(np.count_nonzero(path.angles)) for path in paths)
    assert 0 < wraps < 15


def test_posts_are_the_round_bodies_in_their_order_whether_touched_or_not():
    """μ θ, and the arms of what comes after."""
    hand = cabled(0.2)
    for q in random_postures(hand, 5):
        cables = hand.posed(q).stiffness.cables
        assert cables.post_tendon.tolist() == [0, 1, 2]
        for bound, grip, row in zip(alone(hand), cables.wrap_friction, cables.arms_beyond, strict=True):
            path = bound.at(q)
            assert grip == pytest.approx(0.2 * path.angles[0], abs=1e-16)
            if grip:
                np.testing.assert_allclose(row, path.pieces[-1].arms, atol=1e-17)


def test_compiled_or_not_it_is_the_same():
    hand = cabled()
    for q in random_postures(hand, 2):
        for bound in alone(hand):
            compiled, slope = bound.at(q), bound.slope(q)
            with interpreted():
                plain = bound.at(q)
                np.testing.assert_allclose(bound.slope(q), slope, atol=1e-9)
            assert plain.length == pytest.approx(compiled.length, rel=1e-15)
            np.testing.assert_allclose(plain.arms, compiled.arms, atol=1e-16)
            np.testing.assert_allclose(plain.angles, compiled.angles, atol=1e-14)


def test_how_arms_change_is_what_central_differences_of_them_say(coupled):
    """Also of joints that others follow."""
    hand = cabled()
    for q in random_postures(hand, 3):
        for bound in alone(hand):
            np.testing.assert_allclose(bound.slope(q), differences(bound, q, "arms"), atol=1e-9)
    bound = OVER_MIMICS.bound(coupled.kinematics)
    for seed in range(4):
        q = inside(coupled, seed)
        np.testing.assert_allclose(bound.slope(q), differences(bound, q, "arms"), atol=1e-9)


def test_tensions_weigh_how_arms_change_and_rigid_joints_feel_none_of_it():
    hand = cabled()
    q, T = random_postures(hand, 1)[0], np.array([3.0, 0.0, 1.0, 2.0])
    slopes = np.array([bound.slope(q) for bound in alone(hand)])
    rates = hand.posed(q).stiffness.cables.arm_rates
    np.testing.assert_allclose(np.tensordot(T, rates(), 1), np.tensordot(T, slopes, 1), atol=1e-12)
    first = hand.joint_names[0]
    springs = {name: np.inf if name == first else 1.0 for name in hand.joint_names}
    rigid = hand.replace(joint_stiffness=hl.Tendons(hand.stiffness.routes, 3e4, springs)).posed(q).stiffness.cables
    expected = np.tensordot(T, slopes, 1)
    expected[0] = expected[:, 0] = 0.0
    np.testing.assert_allclose(np.tensordot(T, rigid.arm_rates(), 1), expected, atol=1e-12)


def test_compiled_code_lays_tendons_from_placements_and_columns_alone():
    """What a compiled step asks for has the arms, lengths and rates that a route has by itself."""
    hand = cabled()
    q = random_postures(hand, 1)[0]
    tendons, frames = hand.stiffness.routed_tendons
    placements, J = hand.kinematics.frames_at(q, frames)
    posed = CablePosture(placements, J.T.copy())
    laid, _, wrong, _ = lay_tendons(tendons, posed, q)
    assert wrong < 0
    paths = [bound.at(q) for bound in alone(hand)]
    np.testing.assert_allclose(laid.arms, [path.arms for path in paths], atol=1e-14)
    np.testing.assert_allclose(laid.shift + laid.arms @ q, [-path.length for path in paths], atol=1e-14)
    slopes = [bound.slope(q) for bound in alone(hand)]
    np.testing.assert_allclose(tendon_arm_rates(tendons, posed), slopes, atol=1e-12)


def test_what_joints_have_drawn_in_of_a_cable_is_what_it_is_shorter_by_over_rigid_joints_too():
    """L = -L in every posture, so that a rigid joint whose arm changes with the others' angles draws nothing in."""
    plain = cabled()
    rigid = dict.fromkeys(plain.joint_names, 1.0) | {plain.joint_names[0]: np.inf}
    hand = plain.replace(joint_stiffness=hl.Tendons(plain.stiffness.routes, 3e4, rigid))
    for q in random_postures(hand, 2):
        assert abs(q[0]) > 1e-2
        cables = hand.posed(q).stiffness.cables
        lengths = [bound.at(q).length for bound in alone(hand)]
        np.testing.assert_allclose(cables.shift + cables.arms @ q, np.negative(lengths), rtol=1e-12)


def test_friction_at_posts_of_several_branches_is_refused():
    """Also where they share the tension alike: what one branch loses the other does not miss."""
    routes = [cabled().stiffness.routes[f"cable {k}"].places for k in (1, 2)]
    pair = Route([Pulley(2), *routes[0], Pulley(2), *routes[1]])
    with pytest.raises(InputError, match="0 for 'pair', which a pulley divides"):
        example_hand("three_finger", joint_stiffness=hl.Tendons({"pair": pair}, 3e4, 1.0, friction=0.1))
    assert all(a.leg < b.leg for a, b in pairwise(pair.bound(cabled().kinematics).at(cabled().neutral).pieces[::3]))
