"""Meshes of MJCF files are those that MuJoCo compiles: every corner where its own kinematics have it."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.hand.test_from_mjcf import inside, placements, posed, simulated

mujoco = pytest.importorskip("mujoco")

WEDGE = """o wedge
v 0 0 0
v 0.04 0 0
v 0 0.02 0
v 0 0 0.01
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""
TWO_WEDGES = (
    WEDGE
    + """o other
v 0.1 0 0
v 0.14 0 0
v 0.1 0.02 0
v 0.1 0 0.01
f 5 7 6
f 5 6 8
f 5 8 7
f 6 7 8
"""
)
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
def folder(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(WEDGE)
    (tmp_path / "meshes" / "two.obj").write_text(TWO_WEDGES)
    return tmp_path


def hand_with(folder, mesh):
    file = folder / "hand.xml"
    file.write_text(FILE.format(meshes=mesh))
    return hl.Hand.from_mjcf(file, ["f1", "f2"]), file


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
def test_every_corner_of_a_mesh_is_where_mujoco_has_it(folder, mesh):
    """To float32's rounding, in three postures: a refpos or refquat that is left out is off by 18 to 40 mm."""
    hand, file = hand_with(folder, mesh)
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


def test_an_obj_file_with_several_objects_keeps_the_triangles_of_all(folder):
    """MuJoCo keeps their corners, and the triangles of the first alone."""
    hand, _ = hand_with(folder, MESHES["several objects"])
    (shape, *_) = (p.shape for p in hand.description.load_shapes("collision") if hasattr(p.shape, "num_tris"))
    assert shape.num_tris == 8
    assert not [d for d in hand.audit() if "first alone" in d.what]


def test_objects_that_are_read_in_part_are_said(folder):
    """Moved by a refpos, the file's own corners are no longer the compiled ones."""
    hand, _ = hand_with(folder, '<mesh name="m" file="two.obj" refpos="0.01 0.02 0.03"/>')
    assert [d.severity for d in hand.audit() if "the first alone is read: m" in d.what] == ["minor"]


def test_a_mesh_in_the_file_touches_as_one_from_a_file_does(folder):
    """It was dropped: "its link has no geometry"."""
    box = hl.Box(0.02, (0.0, 0.0, -0.02), mass=0.05)
    points = []
    for mesh in ('<mesh name="m" file="wedge.obj"/>', '<mesh name="m" vertex="0 0 0 .04 0 0 0 .02 0 0 0 .01"/>'):
        hand, _ = hand_with(folder, mesh)
        assert not [d for d in hand.audit() if "no geometry" in d.what or "left out" in d.what]
        points.append([np.sort(np.array(s.geometry.points()), axis=0) for i in (0, 1) for s in hand.tip_shapes(i)])
        assert hand.at(hand.neutral).grasp(box, max_gap=0.1).scene.n == 2
    np.testing.assert_allclose(points[0], points[1], atol=1e-8)


def test_a_primitive_fitted_to_a_mesh_and_a_capsule_from_end_to_end_are_the_compiled_ones(folder):
    text = FILE.format(meshes='<mesh name="m" file="wedge.obj"/>')
    text = text.replace('<geom type="mesh" mesh="m"/>', '<geom type="box" mesh="m"/>', 1)
    text = text.replace('<geom type="mesh" mesh="m" pos="0.01 0 0.002" euler="0.3 -0.2 0.1"/>',
                        '<geom type="capsule" size="0.004" fromto="0 0 0 0.01 0.02 0.03"/>', 1)  # fmt: skip
    (folder / "hand.xml").write_text(text)
    hand = hl.Hand.from_mjcf(folder / "hand.xml", ["f1", "f2"])
    model, data = simulated(folder / "hand.xml")
    posed(hand, hand.neutral, model, data)
    places, found = placements(hand, hand.neutral), []
    for part in hand.description.load_shapes("collision"):
        p, R = places[hand.model.frames[part.frame].name]
        found.append((type(part.shape).__name__, R @ part.position + p))
    for g in range(1, model.ngeom):
        kind = "Box" if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX else "Cylinder"
        assert min(np.linalg.norm(at - data.geom_xpos[g]) for name, at in found if name == kind) < 1e-12


def test_what_deforms_is_said_to_be_left_out(folder):
    """A flexible grid: nothing of it is read."""
    text = FILE.format(meshes='<mesh name="m" file="wedge.obj"/>').replace(
        "</worldbody>",
        '<flexcomp name="cloth" type="grid" count="3 3 1" spacing=".05 .05 .05" mass="0.1" dim="2" radius=".001"/>'
        "</worldbody>",
    )
    (folder / "hand.xml").write_text(text)
    hand = hl.Hand.from_mjcf(folder / "hand.xml", ["f1", "f2"])
    assert any("what deforms is left out: 1 flexible parts" in d.what for d in hand.audit())
    assert hand.joint_names == ("j1", "j2")
