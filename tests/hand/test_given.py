"""Objects as people have them: matrices as placements, meshes from trimesh, lengths in millimetres."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest
import trimesh

import handlcp as hl
from tests.support.texts import says

TURN = pin.SE3(pin.exp3(np.array([0.3, -1.1, 0.7])), np.array([0.1, 0.2, 0.3]))
AT = (0, 0, 0.08)


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)


def refused(call):
    with pytest.raises(hl.InputError) as info:
        call()
    return info.value


# ---------------------------------------------------------------- placements
def test_a_placement_is_an_se3_a_matrix_or_a_position():
    boxes = [hl.Box(0.05, p) for p in (TURN, TURN.homogeneous, TURN.homogeneous.tolist())]
    for box in (*boxes, hl.Box(0.05).moved_to(TURN.homogeneous)):
        np.testing.assert_array_equal(box.placement.homogeneous, TURN.homogeneous)
    np.testing.assert_array_equal(hl.Box(0.05, AT).placement.translation, AT)


def test_single_precision_becomes_the_nearest_rotation():
    placement = hl.Sphere(0.05, TURN.homogeneous.astype(np.float32)).placement
    R = placement.rotation
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R, TURN.rotation, atol=1e-6)


def scaled(factor):
    T = TURN.homogeneous.copy()
    T[:3, 0] *= factor
    return T


@pytest.mark.parametrize(
    ("what", "bad"),
    [
        ("a scale", scaled(1.1)),
        ("a mirror", np.diag([1.0, 1.0, -1.0, 1.0])),
        ("transposed", TURN.homogeneous.T),
        ("a quaternion", [0, 0, 0, 1, 0, 0, 0]),
        ("an SE3 that is none", pin.SE3(2 * np.eye(3), np.zeros(3))),
    ],
)
def test_other_matrices_are_refused(what, bad):
    error = refused(lambda: hl.Box(0.05, bad))
    assert error.argument == "placement"
    if what in ("a scale", "a mirror", "transposed", "a quaternion"):
        says(str(error), "got")


# ---------------------------------------------------------------- normals
@pytest.mark.parametrize("length", [1 - 0.9e-3, 1 + 0.9e-3])
def test_normals_that_are_nearly_unit_are_normalised(length):
    n = np.array([0.6, 0.0, 0.8])
    for z in (
        hl.Contact((0, 0, 0), length * n).normal,
        hl.Table((0, 0, 0), length * n).normal,
        hl.Grasp([hl.Contact((0, 0, 0), (0, 1.0, 0))], plane=length * n).scene.plane,
    ):
        np.testing.assert_allclose(z, n, atol=1e-15)


@pytest.mark.parametrize("length", [0.0, 1 - 1.1e-3, 2.0])
def test_other_lengths_are_refused_with_the_length_and_what_may_be_meant(length):
    n = length * np.array([0.6, 0.0, 0.8])
    for call in (
        lambda: hl.Contact((0, 0, 0), n),
        lambda: hl.Table((0, 0, 0), n),
        lambda: hl.Grasp([hl.Contact((0, 0, 0), (0, 1.0, 0))], plane=n),
    ):
        error = refused(call)
        assert error.argument in ("normal", "plane")
        assert f"length {length:g}" in str(error)
        assert ("[0.6, 0.0, 0.8] meant" in str(error)) == (length > 0)


# ---------------------------------------------------------------- meshes
def test_a_trimesh_is_grasped_as_the_box_that_it_is(hand):
    mesh, box = hl.Mesh(trimesh.creation.box((0.05,) * 3), placement=AT, mass=0.2), hl.Box(0.05, AT, 0.2)
    assert mesh.path is None
    assert mesh.convex
    np.testing.assert_allclose(mesh.volume, 0.05**3)
    forces = [hand.at(hand.close_on(obj)).grasp(obj, squeeze=4e-3).solve().forces for obj in (mesh, box)]
    np.testing.assert_allclose(*forces, rtol=1e-6, atol=1e-9)


def test_a_trimesh_that_is_not_convex_keeps_its_triangles_and_travels():
    given = trimesh.creation.annulus(0.01, 0.03, 0.02)
    mesh = hl.Mesh(given, density=1000.0)
    given.vertices *= 7.0  # of no concern any more
    again = pickle.loads(pickle.dumps(mesh))
    for one in (mesh, again, mesh.moved_to((0, 0, 0)), mesh.weighing(mesh.mass)):
        assert not one.convex
        assert one.mass == mesh.mass == pytest.approx(1000.0 * np.pi * (9e-4 - 1e-4) * 0.02, rel=0.01)
        assert one.closest(np.zeros(3))[0] == pytest.approx(0.01, rel=0.01), "the hole is outside"
    assert "triangles" in repr(mesh)


# ---------------------------------------------------------------- millimetres
def test_a_wide_mesh_is_asked_about_unless_its_scale_is_given(tmp_path):
    big = trimesh.creation.box((60.0, 20.0, 20.0))
    big.export(tmp_path / "part.stl")
    for source in (big, tmp_path / "part.stl"):
        error = refused(lambda source=source: hl.Mesh(source))
        assert error.argument == "scale"
        assert "60 m wide" in str(error)
        assert hl.Mesh(source, 0.001).volume == pytest.approx(24e-6)
        assert hl.Mesh(source, scale=1).volume == pytest.approx(24e3)
    says(str(refused(lambda: hl.Mesh(big))), "0.001", "1 to keep it")
    small = trimesh.creation.box((4.0, 4.0, 4.0))
    assert hl.Mesh(small).volume == pytest.approx(64.0)
    small.units = "mm"
    says(str(refused(lambda: hl.Mesh(small))), "'mm'")
    small.units = "meters"
    assert hl.Mesh(small).volume == pytest.approx(64.0)


def test_lengths_far_beyond_the_hand_are_asked_about(hand):
    state = hand.at(hand.neutral)
    for obj in (hl.Sphere(35), hl.Box((60, 30, 30)), hl.Cylinder(20, 80), hl.Ellipsoid((30, 20, 20))):
        assert refused(lambda obj=obj: hand.close_on(obj)).argument == "obj"
        assert refused(lambda obj=obj: state.grasp(obj)).argument == "target"
    says(str(refused(lambda: hand.close_on(hl.Sphere(35)))), "70 m", "millimetres")
    contacts = [hl.Contact((30 * x, 0, 80), (-x, 0, 0)) for x in (-1.0, 1.0)]
    error = refused(lambda: state.grasp(dict(zip(hand.fingertips, contacts, strict=False))))
    says(str(error), "millimetres")
    assert hl.Grasp(contacts, flexibility=1e-4, preload=1e-3).solve().held, "without a hand any length may be meant"
