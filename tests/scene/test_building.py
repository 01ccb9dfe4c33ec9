"""From a scene file to the very grasp that the same calls in Python give."""

import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

from handlcp import (
    Contact,
    ContactCompliance,
    Coulomb,
    Environment,
    FingerForceBound,
    Frictionless,
    Grasp,
    PrescribedForce,
    SoftWrist,
    Table,
    TotalForceBound,
)
from handlcp.errors import InputError
from handlcp.geometry import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.hand import HandGrasp, example_hand
from handlcp.hand.library import urdf
from handlcp.scene import load, read
from tests.support import texts
from tests.support.grasp import arrays
from tests.support.scene_texts import TWO_CONTACTS

CUBE = """
[hand]
name = "three_finger"
joint_stiffness_Nm_per_rad = 6.0
pad_flexibility_m_per_N = 2e-4
torque_limits_Nm = 0.3
[object]
shape = "box"
size_m = 0.05
position_m = [0.0, 0.0, 0.08]
mass_kg = 0.2
[grasp]
friction = 0.8
preload_m = 0.005
finger_weight = true
[load]
force_N = [0.1, 0.0, -0.2]
torque_Nm = [0.0, 0.001, 0.0]
"""


def same(a, b):
    for name in ("positions", "frames", "mu", "flexibility", "offset", "force", "moment"):
        np.testing.assert_array_equal(getattr(arrays(a), name), getattr(arrays(b), name), err_msg=name)
    np.testing.assert_array_equal(a.reference, b.reference)


def test_a_hand_scene_is_the_grasp_that_the_calls_give():
    box = Box(0.05, (0, 0, 0.08), 0.2)
    hand = example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4, torque_limits=0.3)
    state = hand.at(hand.close_on(box))
    expected = state.grasp(
        box, Coulomb(0.8), (0.1, 0, -0.2, 0, 0.001, 0), preload=0.005, finger_weight=True, max_gap=1e-3
    )
    grasp = read(CUBE).build()
    assert isinstance(grasp, HandGrasp)
    same(grasp, expected)
    np.testing.assert_array_equal(grasp.jacobian, expected.jacobian)
    np.testing.assert_array_equal(grasp.gravity_torque, expected.gravity_torque)
    np.testing.assert_array_equal(grasp.state.hand.torque_limits, 0.3)


ON_TABLE = """
[[environment]]
point_m = [0.0, 0.0, 0.0545]
normal = [0.0, 0.0, 1.0]
friction = 0.3
flexibility_m_per_N = [1e-4, 1e-4, 2e-4]
name = "floor"
[[environment]]
position_m = [0.0, 0.0, 0.105]
normal = [0.0, 0.0, -1.0]
tangent = [0.0, 1.0, 0.0]
friction = "frictionless"
gap_m = 1e-4
"""


def test_a_table_and_a_contact_of_the_environment_are_those_that_the_calls_give():
    grasp = read(CUBE + ON_TABLE).build()
    box = Box(0.05, (0, 0, 0.08), 0.2)
    hand = example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4, torque_limits=0.3)
    above = Environment([Contact((0, 0, 0.105), (0, 0, -1), Frictionless(), (0, 1, 0))], 0.0, 1e-4)
    floor = Table((0, 0, 0.0545), (0, 0, 1), Coulomb(0.3), (1e-4, 1e-4, 2e-4), name="floor")
    expected = hand.at(hand.close_on(box)).grasp(
        box, Coulomb(0.8), (0.1, 0, -0.2, 0, 0.001, 0), preload=0.005, finger_weight=True, environment=[floor, above]
    )
    same(grasp, expected)
    assert grasp.names[3:] == (*(f"floor {k}" for k in (1, 2, 3, 4)), "environment 5")
    np.testing.assert_allclose(grasp.offset[3:, 2], [5e-4] * 4 + [1e-4], rtol=1e-9)


def test_a_scene_without_a_hand_rests_on_a_table_too():
    grasp = read("""
        [object]
        shape = "box"
        size_m = 0.04
        position_m = [0.0, 0.0, 0.02]
        mass_kg = 0.1
        [[contact]]
        position_m = [0.0, 0.0, 0.04]
        normal = [0.0, 0.0, -1.0]
        [[environment]]
        point_m = [0.0, 0.0, 0.0]
        normal = [0.0, 0.0, 1.0]
        [grasp]
        flexibility_m_per_N = 1e-4
        preload_m = 1e-3
        [effects]
        finger_force_bound_N = [5.0]
        [effects.contact_compliance_m_per_N]
        "finger 1" = 1e-5
    """).build()
    assert grasp.names == ("finger 1", "table 1", "table 2", "table 3", "table 4")
    assert [c.friction for c in grasp.contacts[1:]] == [Coulomb(0.5)] * 4
    assert grasp.solve().forces_world[1:, 2].sum() == pytest.approx(0.1 * 9.81 + 5.0, rel=1e-9)
    assert not arrays(grasp).flexibility[3:].any()


def test_a_urdf_is_found_beside_the_scene_file_and_tables_by_name_arrive(tmp_path):
    (tmp_path / "hand.urdf").write_bytes(urdf("two_finger").read_bytes())
    file = tmp_path / "scene.toml"
    file.write_text("""
        [hand]
        urdf = "hand.urdf"
        [hand.joint_stiffness_Nm_per_rad]
        finger_1_proximal = 2.0
        finger_1_distal = 1.0
        finger_2_proximal = 2.0
        finger_2_distal = inf
        [hand.torque_limits_Nm]
        finger_2_distal = inf
        [posture]
        close = false
        [posture.q_rad]
        finger_1_distal = 0.2
        [object]
        shape = "box"
        size_m = [0.05, 0.05, 0.03]
        position_m = [0.0, 0.0, 0.09]
        [grasp]
        max_gap_m = 0.05
        [grasp.friction]
        finger_1_tip = 0.3
        finger_2_tip = "frictionless"
        [grasp.preload_m]
        finger_2_tip = 0.002
    """)
    grasp = load(file).build()
    hand = grasp.state.hand
    assert hand.joint_stiffness.diagonal().tolist() == [2.0, 1.0, 2.0, np.inf]
    assert hand.torque_limits.tolist() == [0.8, 0.4, 0.8, np.inf]
    assert grasp.state.q.tolist() == [0.0, 0.2, 0.0, 0.0], "joints left out are at the neutral posture"
    assert [c.friction for c in grasp.contacts] == [Coulomb(0.3), Frictionless()]
    other = load(file).model_copy(update={"grasp": load(file).grasp.model_copy(update={"preload_m": 0.0})})
    difference = grasp.offset - other.build().offset
    np.testing.assert_allclose(difference, [[0, 0, 0], [0, 0, -0.002]], atol=1e-15)


def test_a_scene_without_a_hand_is_the_grasp_that_the_calls_give():
    grasp = read("""
        [[contact]]
        position_m = [0.03, 0.0, 0.0]
        normal = [-1.0, 0.0, 0.0]
        tangent = [0.0, 0.0, 1.0]
        name = "thumb"
        [[contact]]
        position_m = [-0.03, 0.0, 0.01]
        normal = [1, 0, 0]
        friction = "frictionless"
        [grasp]
        friction = 0.4
        flexibility_m_per_N = [1e-3, 1e-3, 2e-3]
        preload_m = [0.001, 0.002]
        reference_m = [0.0, 0.0, 0.005]
        [load]
        force_N = [0.0, 0.0, -1.0]
        [effects]
        total_force_bound_N = 5
        [[effects.prescribed_force]]
        contact = "thumb"
        force_N = [0.0, 0.0, 2.0]
    """).build()
    expected = Grasp(
        [
            Contact((0.03, 0, 0), (-1, 0, 0), Coulomb(0.4), (0, 0, 1), "thumb"),
            Contact((-0.03, 0, 0.01), (1, 0, 0), Frictionless()),
        ],
        (0, 0, -1, 0, 0, 0),
        flexibility=(1e-3, 1e-3, 2e-3),
        preload=(0.001, 0.002),
        reference=(0, 0, 0.005),
    )
    same(grasp, expected)
    assert grasp.names == ("thumb", "finger 2")
    assert grasp.effects[0] == TotalForceBound(5.0)
    assert isinstance(grasp.effects[1], PrescribedForce)
    assert grasp.effects[1].contact == 0


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ('shape = "box"\nsize_m = [0.1, 0.2, 0.3]', Box((0.1, 0.2, 0.3), mass=0.5)),
        ('shape = "sphere"\nradius_m = 0.1', Sphere(0.1, mass=0.5)),
        ('shape = "cylinder"\nradius_m = 0.1\nlength_m = 1', Cylinder(0.1, 1.0, mass=0.5)),
        ('shape = "ellipsoid"\nradii_m = [1, 2, 3]', Ellipsoid((1, 2, 3), mass=0.5)),
    ],
)
def test_every_shape_arrives_where_it_was_put(table, expected):
    head = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[object]\n"
    shape = read(f"{head}{table}\nposition_m = [1, 2, 3]\nrpy_rad = [0.1, 0.2, 0.3]\nmass_kg = 0.5").shape()
    assert type(shape) is type(expected)
    assert shape.mass == 0.5
    np.testing.assert_allclose(shape.placement.rotation, pin.rpy.rpyToMatrix(0.1, 0.2, 0.3))
    np.testing.assert_allclose(shape.placement.translation, (1, 2, 3))
    assert repr(shape) == repr(expected.moved_to(shape.placement))


def test_a_mesh_is_found_beside_the_scene_file(tmp_path):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(1, 3, 2), (1, 2, 4), (2, 3, 4), (1, 4, 3)]
    lines = ["v {} {} {}".format(*c) for c in corners] + ["f {} {} {}".format(*f) for f in faces]
    (tmp_path / "tetra.obj").write_text("\n".join(lines) + "\n")
    head = "[[contact]]\nposition_m = [0, 0, 0]\nnormal = [0, 0, 1]\n[object]\n"
    mesh = read(f'{head}shape = "mesh"\nfile = "tetra.obj"\nscale = 0.01', tmp_path).shape()
    assert isinstance(mesh, Mesh)
    np.testing.assert_allclose(mesh.center_of_mass, [0.0025] * 3)


def test_hands_and_grasps_are_there_without_the_slow_parts_of_scipy():
    slow = "{'scipy.optimize', 'scipy.stats', 'scipy.spatial'}"
    code = f"import handlcp as hl, sys; hl.Hand, hl.Grasp, hl.solve_many; print(sorted({slow} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


SOFT = f"""
{TWO_CONTACTS}
[grasp]
flexibility_m_per_N = 1e-3
preload_m = 0.002
"""


def test_compliances_are_those_that_the_calls_give():
    grasp = read(
        SOFT
        + """
        [effects]
        contact_compliance_m_per_N = [1e-4, 2e-4, 3e-4]
        [effects.soft_wrist]
        translation_m_per_N = 1e-3
        rotation_rad_per_Nm = [0.1, 0.2, 0.0]
        at_m = [0.0, 0.0, -0.1]
    """
    ).build()
    effects = [
        ContactCompliance((1e-4, 2e-4, 3e-4)),
        SoftWrist((1e-3, 1e-3, 1e-3, 0.1, 0.2, 0.0), (0, 0, -0.1)),
    ]
    same(grasp, Grasp(grasp.contacts, flexibility=1e-3, preload=0.002, effects=effects))
    matrix = (np.eye(6) * 1e-3 + 1e-4).tolist()
    grasp = read(
        f"{SOFT}[effects.soft_wrist]\nflexibility = {matrix}\n[effects.contact_compliance_m_per_N]\nthumb = 1e-4"
    ).build()
    effects = [ContactCompliance([np.eye(3) * 1e-4, np.zeros((3, 3))]), SoftWrist(matrix)]
    same(grasp, Grasp(grasp.contacts, flexibility=1e-3, preload=0.002, effects=effects))


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[effects.contact_compliance_m_per_N]\nindex = 1e-4", "effects.contact_compliance_m_per_N"),
        (f"[effects.soft_wrist]\nflexibility = {(-np.eye(6)).tolist()}", "effects.soft_wrist.flexibility"),
        (
            f"[effects.soft_wrist]\nrotation_rad_per_Nm = 1\nflexibility = {np.eye(6).tolist()}",
            "effects.soft_wrist.rotation_rad_per_Nm",
        ),
    ],
)
def test_compliances_that_make_no_sense_name_the_key(text, key):
    with pytest.raises(InputError) as caught:
        read(SOFT + text).build()
    assert caught.value.argument == key


def test_a_density_stands_for_a_mass():
    text = CUBE.replace("mass_kg = 0.2", "density_kg_per_m3 = 1600.0")
    assert read(text).shape().mass == pytest.approx(0.2, rel=1e-9)
    same(read(text).build(), read(CUBE.replace("mass_kg = 0.2", f"mass_kg = {read(text).shape().mass!r}")).build())
    with pytest.raises(InputError) as caught:
        read(CUBE.replace("mass_kg = 0.2", "mass_kg = 0.2\ndensity_kg_per_m3 = 1600.0")).build()
    assert caught.value.argument == "object.density_kg_per_m3"
    texts.says(caught.value.expected, "given")


TWO = f"""
{TWO_CONTACTS}
[effects]
"""


@pytest.mark.parametrize(
    ("value", "expected"), [("5", 5.0), ("[5.0, inf]", (5.0, np.inf)), ("{thumb = 5.0}", (5.0, np.inf))]
)
def test_force_bounds_are_a_number_a_list_or_a_table(value, expected):
    grasp = read(f"{TWO}finger_force_bound_N = {value}").build()
    assert grasp.effects == (FingerForceBound(expected),)


@pytest.mark.parametrize("value", ["[5.0]", "{index = 5.0}"])
def test_force_bounds_of_other_fingers_are_named(value):
    with pytest.raises(InputError) as caught:
        read(f"{TWO}finger_force_bound_N = {value}").build()
    assert caught.value.argument == "effects.finger_force_bound_N"
