"""Objects as people have them, and contacts with them against closed forms: gap, point and normal on every kind."""

import pickle

import numpy as np
import pinocchio as pin
import pytest
import trimesh

import handlcp as hl
from handlcp.errors import InputError, NotReached
from handlcp.geometry import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.hand import example_hand
from tests.support import patches
from tests.support.grasp import arrays
from tests.support.hand import ball_near
from tests.support.texts import says

RADIUS = 0.01
PLACEMENT = pin.SE3(pin.exp3(np.array([0.3, -1.1, 0.7])), np.array([0.1, 0.2, 0.3]))
BOX, RADII = np.array([0.04, 0.05, 0.06]), np.array([0.02, 0.03, 0.04])


def _face(rng):
    i, x, n = rng.integers(3), rng.uniform(-0.4, 0.4, 3) * BOX, np.zeros(3)
    n[i] = rng.choice([-1.0, 1.0])
    x[i] = n[i] * BOX[i] / 2
    return x, n


def _mantle(rng):
    a = rng.uniform(0, 2 * np.pi)
    n = np.array([np.cos(a), np.sin(a), 0.0])
    return 0.02 * n + np.array([0, 0, rng.uniform(-0.03, 0.03)]), n


def _lid(rng):
    return np.array([*rng.uniform(-0.008, 0.008, 2), 0.05]), np.array([0.0, 0.0, 1.0])


def _ball(rng):
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    return 0.03 * n, n


def _egg(rng):
    u = rng.normal(size=3)
    u[rng.integers(3)] *= rng.integers(2)  # on planes of symmetry too
    u /= np.linalg.norm(u)
    n = u / RADII
    return RADII * u, n / np.linalg.norm(n)


def _written(path, mesh):
    mesh.export(path, digits=17)
    return path


def box_file(folder, size=BOX):
    """A box as a mesh file (OBJ)."""
    return _written(folder / "box.obj", trimesh.creation.box(size))


def angle_file(folder):
    """An L of unit squares, 10 mm each and 10 mm thick: a mesh that is not convex."""
    corners = 0.01 * np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    triangles = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)])
    return _written(folder / "angle.obj", trimesh.creation.extrude_triangulation(corners, triangles, 0.01))


@pytest.mark.parametrize(
    ("make", "surface", "deepest", "exact"),
    [
        (lambda _: Box(BOX, PLACEMENT), _face, -0.012, 1e-12),
        (lambda _: Cylinder(0.02, 0.1, PLACEMENT), _mantle, -0.012, 1e-12),
        (lambda _: Cylinder(0.02, 0.1, PLACEMENT), _lid, -0.012, 1e-12),
        (lambda _: Sphere(0.03, PLACEMENT), _ball, -0.012, 1e-12),
        (lambda _: Ellipsoid(RADII, PLACEMENT), _egg, -0.012, 1e-12),
        (lambda folder: Mesh(box_file(folder), 1.0, PLACEMENT), _face, -0.012, 1e-8),  # files hold single precision
    ],
    ids=["box", "cylinder", "cylinder end", "sphere", "ellipsoid", "convex mesh"],
)
def test_contact_of_a_spherical_tip_is_the_closed_form(make, surface, deepest, exact, tmp_path):
    """A ball centred gap + r above a surface point: the gap, that point, and the inward normal; overlapping too."""
    obj, rng = make(tmp_path), np.random.default_rng(4)
    for _ in range(100):
        x, n = surface(rng)
        gap = rng.uniform(deepest, 0.05)
        centre = PLACEMENT.act(x + n * (gap + RADIUS))
        found = ball_near(RADIUS, centre, obj)
        assert found.gap == pytest.approx(gap, abs=exact)
        np.testing.assert_allclose(found.position, PLACEMENT.act(x), atol=exact)
        np.testing.assert_allclose(found.normal, -PLACEMENT.rotation @ n, atol=1e-6)
        np.testing.assert_allclose(found.tip_point, centre + RADIUS * found.normal, atol=exact)


def test_a_mesh_that_is_not_convex_keeps_its_notch(tmp_path):
    """In the notch of an L the gap is to the faces there, not to the hull; overlap is signed right."""
    obj = Mesh(angle_file(tmp_path), 1.0, mass=0.3)
    assert not obj.convex
    np.testing.assert_allclose(obj.center_of_mass, [0.025 / 3, 0.025 / 3, 0.005], atol=1e-8)
    for height, gap in ((0.006, 0.004), (0.0015, -0.0005), (-0.001, -0.003)):
        found = ball_near(0.002, (0.014, 0.01 + height, 0.005), obj)
        expected = min(height, 0.004) if height > 0 else height  # the notch's other wall is 4 mm away
        assert found.gap == pytest.approx(expected - 0.002, abs=1e-8), gap
        normal = [0, -1, 0] if height < 0.004 else [-1, 0, 0]
        np.testing.assert_allclose(found.normal, normal, atol=1e-6)


def test_a_mesh_of_too_many_triangles_is_refused_with_advice(tmp_path, monkeypatch):
    patches.meshes_of_at_most(monkeypatch, 11)
    with pytest.raises(InputError, match=r"at most 11 triangles; simplify it, .* with 12$"):
        Mesh(box_file(tmp_path), mass=0.1)


def test_tips_can_be_the_urdf_s_collision_geometry():
    """Without a tip radius: the ball in the shipped URDF, and the hull of the psyonic's mesh."""
    own, given = example_hand("five_finger", tip_radius=None), example_hand("five_finger")
    ball = Sphere(0.03, (0, 0, 0.09))
    q = np.tile([0.2, 0.1], 5)
    a, b = own.at(q).grasp(ball, max_gap=1.0), given.at(q).grasp(ball, max_gap=1.0)
    np.testing.assert_allclose(a.offset, b.offset, atol=1e-15)
    hand = example_hand("psyonic", tip_radius=None, fingertips=["Left_index_anchor"])
    state = hand.at(hand.neutral)
    far = state.tip_positions[0] + np.array([0.0, 0.0, 1.0])
    gap = state.grasp(Sphere(0.02, far), max_gap=2.0).offset[0, 2]
    assert 0.9 < gap < 1.0


def test_penetration_is_preload(five):
    """A finger 2 mm inside an object, one that touches, one 0.5 mm away: offsets -2, 0 and +0.5 mm; preload adds."""
    state = five.at(np.tile([0.1, 0.1], 5))
    tips = state.tip_positions
    radius = float(np.hypot(*tips[0, :2])) - 0.008
    for shift, preload in ((-0.002, 0.0), (0.0, 0.001), (0.0005, 0.0)):
        drum = Cylinder(radius - shift, 1.0, (0.0, 0.0, tips[0, 2]))
        g = state.grasp(drum, preload=preload)
        np.testing.assert_allclose(g.offset[:, 2], shift - preload, atol=1e-12)
        expected = tips[:, :2] * (radius - shift) / (radius + 0.008)
        np.testing.assert_allclose(arrays(g).positions[:, :2], expected, atol=1e-12)


def test_fingers_that_do_not_touch_are_all_named(five):
    """NotReached lists every finger that is too far, with its gap, and none of the others."""
    state = five.at(np.tile([0.1, 0.1], 5))
    x = state.tip_positions[0]
    with pytest.raises(NotReached, match=r"close_on\(obj\).*find_grasp\(obj\).*finger_3_tip") as caught:
        state.grasp(Sphere(0.01, x + np.array([0.018, 0.0, 0.0])))
    assert set(caught.value.gaps) == {f"finger_{i}_tip" for i in (2, 3, 4, 5)}
    assert caught.value.gaps["finger_3_tip"] > 0.02
    alone = state.grasp(Sphere(0.01, x + np.array([0.018, 0.0, 0.0])), fingers=["finger_1_tip"])
    assert alone.names == ("finger_1_tip",)
    np.testing.assert_allclose(alone.contacts[0].normal, [1, 0, 0], atol=1e-12)


def test_objects_pickle_and_stay(tmp_path):
    """Objects survive pickle; what they hand out are copies."""
    box, ball, can = Box(0.1), Sphere(0.1, mass=1), Cylinder(0.1, 0.2)
    for obj in (box, ball, can, Ellipsoid(RADII, PLACEMENT), Mesh(box_file(tmp_path))):
        again = pickle.loads(pickle.dumps(obj))
        assert repr(again) == repr(obj)
        obj.placement.translation = np.ones(3)
        assert again.placement == obj.placement
        with pytest.raises(AttributeError, match="immutable"):
            obj.mass = 2.0
        moved = obj.moved_to((0.0, 0.0, 1.0))
        np.testing.assert_allclose(moved.center_of_mass[2], 1.0, atol=1e-9)


def _cells(path, faces):
    """The tetrahedron (0, a, b, c) with edges 1/2, 1/4 and 1/8 m along the axes, which single precision holds exactly,
    pushed off the origin; only the faces given.
    """
    corners = np.array([[0, 0, 0], [0.5, 0, 0], [0, 0.25, 0], [0, 0, 0.125]]) + np.array([1.0, 2.0, -0.5])
    return _written(path, trimesh.Trimesh(corners, faces, process=False))


TETRA = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def test_a_density_and_a_shape_make_a_mass(tmp_path):
    """Closed forms of the volume; weight at the centre of mass; scaled, moved and pickled alike."""
    cells = _cells(tmp_path / "tetra.obj", TETRA)
    for obj, volume in (
        (Box(BOX, density=800.0), 0.04 * 0.05 * 0.06),
        (Box(0.1, density=800.0), 1e-3),
        (Sphere(0.03, density=800.0), 4 / 3 * np.pi * 0.03**3),
        (Cylinder(0.02, 0.1, density=800.0), np.pi * 0.02**2 * 0.1),
        (Ellipsoid(RADII, PLACEMENT, density=800.0), 4 / 3 * np.pi * 0.02 * 0.03 * 0.04),
        (Mesh(cells, density=800.0), 0.5 * 0.25 * 0.125 / 6),
        (Mesh(cells, (1.0, 2.0, 4.0), density=800.0), 8 * 0.5 * 0.25 * 0.125 / 6),
    ):
        assert obj.volume == pytest.approx(volume, rel=1e-9)
        assert obj.mass == pytest.approx(800.0 * volume, rel=1e-9)
        assert obj.moved_to((0, 0, 1)).mass == pickle.loads(pickle.dumps(obj)).mass == obj.mass
        assert "mass=" in repr(obj)
    centre = [1 + 0.5 / 4, 2 + 0.25 / 4, -0.5 + 0.125 / 4]
    np.testing.assert_allclose(Mesh(cells, density=1.0).center_of_mass, centre, rtol=1e-9)
    assert Sphere(0.03).mass == Sphere(0.03, density=0.0).mass == 0.0


def test_a_mesh_with_holes_is_weighed_as_its_hull_if_convex_and_not_at_all_otherwise(tmp_path):
    """A lid left out in a plane through the origin costs the sum over triangles nothing; elsewhere it would."""
    corners = 0.25 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    hull = Mesh(_written(tmp_path / "open.obj", trimesh.Trimesh(corners, TETRA[1:], process=False)), density=600.0)
    assert hull.convex
    assert hull.mass == pytest.approx(600.0 * 0.25**3 / 6, rel=1e-9)
    np.testing.assert_allclose(hull.center_of_mass, 0.25 / 4 * np.ones(3), rtol=1e-9)
    holes = _cells(tmp_path / "holes.obj", TETRA[1:])
    error = refused(lambda: Mesh(holes, density=600.0))
    assert error.argument == "density"
    says(error.expected, "closed")
    assert Mesh(holes, mass=0.1).mass == 0.1


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda _: Box((0.1, 0.0, 0.1)), "size"),
        (lambda _: Sphere(-1.0), "radius"),
        (lambda _: Cylinder(0.1, 0), "length"),
        (lambda _: Ellipsoid((0.1, 0.1, np.inf)), "radii"),
        (lambda _: Box(0.1, density=-1), "density"),
        (lambda _: Sphere(0.1, mass=0.0, density=1.0), "density"),
        (lambda _: Box(0.1, "here"), "placement"),
        (lambda _: Box(0.1, pin.SE3(np.ones((3, 3)), np.zeros(3))), "placement"),
        (lambda folder: Mesh(folder / "none.stl"), "path"),
        (lambda folder: Mesh(_broken(folder)), "path"),
        (lambda folder: Mesh(box_file(folder), 0.0), "scale"),
    ],
)
def test_bad_objects_name_the_argument(make, argument, tmp_path):
    """One broken argument a time; each names itself."""
    assert refused(lambda: make(tmp_path)).argument == argument


def _broken(folder):
    path = folder / "broken.stl"
    path.write_text("no mesh at all")
    return path


# ---------------------------------------------------------------- matrices as placements
AT = (0, 0, 0.08)


@pytest.fixture(scope="module")
def hand():
    return hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)


def refused(call):
    with pytest.raises(hl.InputError) as info:
        call()
    return info.value


def test_a_placement_is_an_se3_a_matrix_or_a_position():
    boxes = [hl.Box(0.05, p) for p in (PLACEMENT, PLACEMENT.homogeneous, PLACEMENT.homogeneous.tolist())]
    for box in (*boxes, hl.Box(0.05).moved_to(PLACEMENT.homogeneous)):
        np.testing.assert_array_equal(box.placement.homogeneous, PLACEMENT.homogeneous)
    np.testing.assert_array_equal(hl.Box(0.05, AT).placement.translation, AT)


def test_single_precision_becomes_the_nearest_rotation():
    placement = hl.Sphere(0.05, PLACEMENT.homogeneous.astype(np.float32)).placement
    R = placement.rotation
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R, PLACEMENT.rotation, atol=1e-6)


def scaled(factor):
    T = PLACEMENT.homogeneous.copy()
    T[:3, 0] *= factor
    return T


@pytest.mark.parametrize(
    ("what", "bad"),
    [
        ("a scale", scaled(1.1)),
        ("a mirror", np.diag([1.0, 1.0, -1.0, 1.0])),
        ("transposed", PLACEMENT.homogeneous.T),
        ("a quaternion", [0, 0, 0, 1, 0, 0, 0]),
        ("an SE3 that is none", pin.SE3(2 * np.eye(3), np.zeros(3))),
    ],
)
def test_other_matrices_are_refused(what, bad):
    error = refused(lambda: hl.Box(0.05, bad))
    assert error.argument == "placement"
    if what != "an SE3 that is none":
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
