"""Shapes in other units: millimetres without a scale are refused at once, and doubted; those of Collada are read."""

import time

import numpy as np
import pytest

import handlcp as hl

CORNERS = np.array([(0, 0, 0), (20, 0, 0), (0, 10, 0), (0, 0, 40)], dtype=float)  # a wedge, in millimetres
FACES = (0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)
TIP = '<collision><origin xyz="0 0 0.02"/><geometry>{}</geometry></collision>'
HAND = """<robot name="mm"><link name="palm"/><link name="l">{tip}</link><link name="r">{tip}</link>
<joint name="a" type="revolute"><parent link="palm"/><child link="l"/><origin xyz="0.04 0 0"/><axis xyz="0 -1 0"/>
<limit lower="-0.5" upper="1.2" effort="0.8" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="palm"/><child link="r"/><origin xyz="-0.04 0 0"/><axis xyz="0 1 0"/>
<limit lower="-0.5" upper="1.2" effort="0.8" velocity="1"/></joint></robot>"""
BOX = hl.Box(0.05, (0, 0, 0.03), mass=0.1)


def stl():
    corners = [" ".join(f"vertex {x:g} {y:g} {z:g}" for x, y, z in CORNERS[list(face)]) for face in FACES]
    facets = [f"facet normal 0 0 0 outer loop {each} endloop endfacet\n" for each in corners]
    return f"solid tip\n{''.join(facets)}endsolid tip\n"


def dae(unit, axis="Z_UP"):
    numbers, faces = " ".join(f"{x:g}" for x in CORNERS.ravel()), " ".join(str(k) for face in FACES for k in face)
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>{axis}</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="12">{numbers}</float_array><technique_common><accessor source="#pa" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def written(folder, shape):
    (folder / "tip.stl").write_text(stl())
    file = folder / "hand.urdf"
    file.write_text(HAND.format(tip=TIP.format(shape)))
    return file


def hand_of(file):
    return hl.Hand.from_urdf(file, ["l", "r"], joint_stiffness=3.0)


def corners(hand, link="l"):
    """Of the mesh of a link, in its collision's axes [m]."""
    (part,) = (p for p in hand.description.load_shapes("collision") if hand.model.frames[p.frame].name == link)
    return np.unique(np.array(part.shape.vertices()), axis=0)


@pytest.mark.parametrize(
    ("shape", "cause"),
    [('<mesh filename="tip.stl"/>', 'scale="0.001 0.001 0.001"'), ('<box size="20 10 46"/>', "multiply them by 0.001")],
)
def test_links_in_millimetres_are_refused_in_a_sentence_and_doubted_at_once(tmp_path, shape, cause):
    """Of a mesh in a second, where a check took 72 s to find a joint 15228° past its range."""
    file = written(tmp_path, shape)
    begun = time.perf_counter()
    (doubt,) = (d for d in hl.audit_urdf(file).serious if d.about == "shape")
    assert doubt.joint == "l, r"
    assert "as if millimetres were taken for metres" in doubt.what
    hand = hand_of(file)
    assert doubt in hand.audit().serious
    with pytest.raises(hl.URDFError, match=r"on a skeleton 0\.08 m wide") as refused:
        hand.at(hand.neutral).grasp(BOX, max_gap=50.0)
    assert cause in str(refused.value)
    with pytest.raises(hl.URDFError, match="in metres"):
        hand.close_on(BOX)
    assert time.perf_counter() - begun < 5.0


def test_a_mesh_that_is_scaled_twice_is_doubted(tmp_path):
    file = written(tmp_path, '<mesh filename="tip.stl" scale="1e-6 1e-6 1e-6"/>')
    (doubt,) = (d for d in hl.audit_urdf(file).serious if d.about == "shape")
    assert "scaled from millimetres twice" in doubt.what


def test_a_table_under_a_small_hand_is_no_doubt(tmp_path):
    """Large shapes that nothing moves may be furniture."""
    file = written(tmp_path, '<sphere radius="0.01"/>')
    table = '<link name="palm"><collision><geometry><box size="3 2 0.05"/></geometry></collision></link>'
    file.write_text(file.read_text().replace('<link name="palm"/>', table))
    assert not [d for d in hl.audit_urdf(file) if d.about == "shape"]


def test_shapes_of_mjcf_files_are_measured_alike():
    pytest.importorskip("mujoco")
    text = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .02 .01"/>
    <body name="l" pos="0.03 0 0"><joint name="lj" axis="0 1 0" range="-30 70"/>
    <geom type="capsule" size="6 20" mass="0.1"/></body>
    <body name="r" pos="-0.03 0 0"><joint name="rj" axis="0 1 0" range="-30 70"/>
    <geom type="sphere" size=".01"/></body></body></worldbody>
    <actuator><position joint="lj" kp="3"/><position joint="rj" kp="3"/></actuator></mujoco>"""
    (doubt,) = (d for d in hl.audit_urdf(text).serious if d.about == "shape")
    assert doubt.joint == "l"


@pytest.mark.parametrize(
    ("unit", "metres"),
    [('<unit meter="0.001" name="mm"/>', 1e-3), ('<unit meter="0.0254"/>', 0.0254), ("<unit/>", 1.0), ("", 1.0)],
)
@pytest.mark.parametrize("axis", ["Z_UP", "Y_UP"])
def test_the_unit_of_a_collada_file_counts_and_its_up_axis_does_not(tmp_path, unit, metres, axis):
    """As in RViz and Gazebo: before the scale of the URDF, in the axes of the link."""
    (tmp_path / "tip.dae").write_text(dae(unit, axis))
    hand = hand_of(written(tmp_path, '<mesh filename="tip.dae" scale="0.5 0.5 0.5"/>'))
    assert bool([d for d in hand.audit().serious if d.about == "shape"]) is (metres == 1.0)
    if metres < 1.0:
        np.testing.assert_allclose(corners(hand), np.unique(0.5 * metres * CORNERS, axis=0), rtol=1e-6)


@pytest.mark.parametrize("metres", ["nan", "0", "1e30"])
def test_a_unit_that_is_no_length_is_refused(tmp_path, metres):
    (tmp_path / "tip.dae").write_text(dae(f'<unit meter="{metres}"/>'))
    with pytest.raises(hl.InputError, match=r"unit of 1e-09 to 1000 m in <unit meter"):
        hl.Mesh(tmp_path / "tip.dae")


@pytest.mark.parametrize("scale", ["0 1 1", "1e-300 1 1", "1e30 1 1", "nan 1 1"])
def test_a_scale_that_leaves_nothing_of_a_mesh_is_refused_with_what_may_be(tmp_path, scale):
    (tmp_path / "tip.dae").write_text(dae(""))
    with pytest.raises(hl.URDFError, match=r"3 numbers of at most ±1e\+06, at least ±1e-09, in <mesh scale=…>"):
        hand_of(written(tmp_path, f'<mesh filename="tip.dae" scale="{scale}"/>'))


def test_an_object_from_a_collada_file_has_its_unit_unless_a_scale_is_passed(tmp_path):
    (tmp_path / "tip.dae").write_text(dae('<unit meter="0.001"/>'))
    volume = 20e-3 * 10e-3 * 40e-3 / 6
    assert hl.Mesh(tmp_path / "tip.dae").volume == pytest.approx(volume, rel=1e-5)
    assert hl.Mesh(tmp_path / "tip.dae", scale=2e-3).volume == pytest.approx(8 * volume, rel=1e-5)


def test_a_mesh_beside_its_file_is_taken_wherever_the_process_stands(tmp_path, monkeypatch):
    """And not another of the same name in the working directory."""
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    file = written(tmp_path / "there", '<mesh filename="tip.stl" scale="0.001 0.001 0.001"/>')
    (tmp_path / "here" / "tip.stl").write_text(stl().replace("vertex 0 0 40", "vertex 0 0 80"))
    monkeypatch.chdir(tmp_path / "here")
    assert np.ptp(corners(hand_of(file)), axis=0) == pytest.approx([0.02, 0.01, 0.04])
    (tmp_path / "there" / "tip.stl").unlink()
    assert any("are not found: tip.stl" in d.what for d in hl.audit_urdf(file))
    text = hl.audit_urdf(file.read_text())  # a text has no folder: its meshes are those of the working directory
    assert not [d for d in text if "are not found" in d.what]
