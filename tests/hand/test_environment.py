"""Tables and walls: contacts found by geometry, and hands that hold what also rests on something."""

import pickle

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.errors import InputError, NotReached
from handlcp.geometry.table import RIM_POINTS
from tests.support.grasp import arrays
from tests.support.hand import points_needed
from tests.support.kernels import interpreted
from tests.support.refusals import refused
from tests.support.texts import says

G = 9.81
HALF = 0.025
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def held():
    """A 200 g cube between three fingers, its lower face 55 mm above the palm."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    box = hl.Box(2 * HALF, (0, 0, 0.08), 0.2)
    return hand.at(hand.close_on(box)), box


def turned(*rpy):
    return pin.rpy.rpyToMatrix(*rpy)


def table(flexibility=1e-3, **more):
    return hl.Table((0, 0, 0.055), friction=hl.Coulomb(0.3), flexibility=flexibility, **more)


def random_turn(rng):
    q = rng.normal(size=4)
    return pin.Quaternion(q / np.linalg.norm(q)).toRotationMatrix()


# ---------------------------------------------------------------- which points touch
def points(environment):
    return np.array([c.position for c in environment.contacts])


def test_a_box_on_its_face_an_edge_or_a_corner_has_four_two_or_one():
    flat = hl.Table((0, 0, -HALF)).under(hl.Box(2 * HALF))
    corners = [[x, y] for x in (-HALF, HALF) for y in (-HALF, HALF)]
    np.testing.assert_allclose(sorted(points(flat)[:, :2].tolist()), corners)
    np.testing.assert_allclose(flat.gap, 0.0, atol=1e-17)
    edge = hl.Box(2 * HALF, pin.SE3(turned(np.pi / 4, 0, 0), np.zeros(3)))
    below = hl.Table((0, 0, -HALF * np.sqrt(2))).under(edge)
    np.testing.assert_allclose(sorted(points(below)[:, 0]), [-HALF, HALF], atol=1e-15)
    np.testing.assert_allclose(points(below)[:, 1], 0, atol=1e-15)
    corner = hl.Box(2 * HALF, pin.SE3(turned(np.arctan(np.sqrt(0.5)), 0, 0) @ turned(0, np.pi / 4, 0), np.zeros(3)))
    assert len(hl.Table((0, 0, -HALF * np.sqrt(3))).under(corner).contacts) == 1


def test_a_cylinder_stands_on_its_rim_and_lies_on_a_line():
    can = hl.Cylinder(0.03, 0.1)
    rim = points(hl.Table((0, 0, -0.05)).under(can))
    assert len(rim) == RIM_POINTS
    np.testing.assert_allclose(np.hypot(rim[:, 0], rim[:, 1]), 0.03, rtol=1e-12)
    line = hl.Table((0, -0.03, 0), normal=(0, 1, 0)).under(can)
    np.testing.assert_allclose(sorted(points(line)[:, 2]), [-0.05, 0.05], rtol=1e-12)
    np.testing.assert_allclose(points(line)[:, :2], [[0, -0.03]] * 2, atol=1e-15)
    leaning = hl.Cylinder(0.03, 0.1, pin.SE3(turned(0.3, 0, 0), np.zeros(3)))
    lowest = 0.03 * np.sin(0.3) + 0.05 * np.cos(0.3)
    one = hl.Table((0, 0, -lowest)).under(leaning)
    assert len(one.contacts) == 1
    np.testing.assert_allclose(one.gap, 0, atol=1e-15)


@pytest.mark.parametrize("seed", range(2))
def test_a_ball_and_an_ellipsoid_touch_where_their_surface_has_the_planes_normal(seed):
    rng = np.random.default_rng(seed)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    place = pin.SE3(random_turn(rng), rng.normal(size=3))
    ball = hl.Table(place.translation - 0.0305 * n, n).under(hl.Sphere(0.03, place))
    np.testing.assert_allclose(points(ball)[0], place.translation - 0.03 * n, atol=1e-14)
    np.testing.assert_allclose(ball.gap, 5e-4, rtol=1e-10)
    radii = np.array([0.02, 0.03, 0.05])
    egg = hl.Ellipsoid(radii, place)
    reach = np.linalg.norm(radii * (place.rotation.T @ n))  # its support function
    one = hl.Table(place.translation - reach * n, n).under(egg)
    np.testing.assert_allclose(one.gap, 0.0, atol=1e-15)
    local = place.rotation.T @ (points(one)[0] - place.translation)
    assert (local**2 / radii**2).sum() == pytest.approx(1, rel=1e-12)
    outward = place.rotation @ (local / radii**2)
    np.testing.assert_allclose(outward / np.linalg.norm(outward), -n, atol=1e-12)


def write_mesh(path, corners, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(corners).tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines))
    return path


def test_a_mesh_rests_on_the_hull_of_its_lowest_face(tmp_path):
    """A prism over a square whose lower face has a grid of vertices: four of them are the patch."""
    from scipy.spatial import ConvexHull

    g = np.linspace(-1, 1, 5) * HALF
    bottom = [(x, y, 0.0) for x in g for y in g]
    roof = [(x, y, 0.03) for x in (-HALF, HALF) for y in (-HALF, HALF)]
    p = np.array(bottom + roof)
    hull = ConvexHull(p)
    faces = []
    for face, equation in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = p[face]
        faces.append(face if np.cross(b - a, c - a) @ equation[:3] > 0 else face[::-1])
    mesh = hl.Mesh(write_mesh(tmp_path / "prism.obj", p, faces), mass=0.1)
    feet = hl.Table((0, 0, 0)).under(mesh)
    assert len(feet.contacts) == 4
    np.testing.assert_allclose(abs(points(feet)[:, :2]), HALF, rtol=1e-6)
    np.testing.assert_allclose(feet.gap, 0, atol=1e-9)


@pytest.mark.parametrize("seed", range(2))
def test_no_small_motion_brings_a_point_left_out_below_the_plane_before_those_kept(seed):
    """Oracle: random points, random small motions h + a + b x + c y; whatever is left out never is the lowest alone."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(60, 3)) * (1, 1, 0.05)
    p[:20, 2] = p[20, 2]  # a flat part among them
    kept = points_needed(p, p[:, 2], UP)
    assert int(np.argmin(p[:, 2])) in kept or p[kept, 2].min() == p[:, 2].min()
    left = [i for i in range(len(p)) if i not in kept]
    assert left
    for a in rng.normal(size=(2000, 2)) * 0.2:
        height = p[:, 2] + p[:, :2] @ a
        assert height[left].min() >= height[kept].min() - 1e-9


def test_nothing_near_enough_says_how_far_and_an_overlap_is_a_squeeze():
    box = hl.Box(2 * HALF)
    info = refused("environment", hl.Table((0, 0, -HALF - 0.002), name="floor").under, box, error=NotReached)
    assert info.gaps["floor"] == pytest.approx(0.002)
    np.testing.assert_allclose(hl.Table((0, 0, -HALF - 0.002), max_gap=0.003).under(box).gap, 0.002)
    np.testing.assert_allclose(hl.Table((0, 0, -HALF + 0.001)).under(box).gap, -0.001)


# ---------------------------------------------------------------- a hand beside it
def test_a_hand_and_a_table_share_the_weight_and_the_table_has_no_joints(held):
    state, box = held
    g = state.grasp(box, hl.Coulomb(0.8), preload=0.006, environment=table())
    s = g.solve()
    assert s.names == (*state.hand.fingertips, "table 1", "table 2", "table 3", "table 4")
    assert g.fingertips == state.hand.fingertips
    np.testing.assert_array_equal(g.jacobian[9:], 0.0)
    plain = state.grasp(box, hl.Coulomb(0.8), preload=0.006)
    np.testing.assert_array_equal(g.jacobian[:9], plain.jacobian)
    np.testing.assert_array_equal(g.flexibility[:9, :9], plain.flexibility)
    np.testing.assert_array_equal(g.flexibility[9:, 9:], np.eye(12) * 1e-3)
    np.testing.assert_allclose(s.forces_world.sum(0), [0, 0, 0.2 * G], atol=1e-9)
    np.testing.assert_allclose(s.torques, plain.jacobian.T @ s.forces[:3].ravel(), rtol=1e-12, atol=1e-15)
    assert len(s.torques) == 6
    assert "table 1" in str(s)
    (line,) = (e for e in g.explain().effects if e.title == "environment contacts")
    says(line.why, "4", "7", "table 1")


def test_fingers_that_only_press_leave_the_weight_to_a_rigid_table(three):
    """Smooth fingers on upright flanks carry nothing: the table has all of the weight."""
    can = hl.Cylinder(0.025, 0.05, (0, 0, 0.08), 0.3)
    floor = hl.Table((0, 0, 0.055))
    s = three.at(three.close_on(can)).grasp(can, hl.Frictionless(), preload=0.003, environment=floor).solve()
    np.testing.assert_allclose(s.forces_world[3:, 2].sum(), 0.3 * G, rtol=1e-9)
    assert not s.uniqueness.forces_determined


def test_given_contacts_take_an_environment_and_no_table(held):
    state, box = held
    contacts = state.grasp(box, hl.Coulomb(0.8)).contacts
    around = table().under(box)
    given = arrays(state.grasp(contacts, preload=0.006, environment=around))
    found = arrays(state.grasp(box, hl.Coulomb(0.8), environment=around))
    np.testing.assert_allclose(given.positions, found.positions, atol=1e-15)
    refused("environment", state.grasp, contacts, environment=table())


def test_a_stream_begins_at_a_solution_where_it_finds_nothing_by_itself(three, held):
    """Without pads on a table a hundred times as stiff: from a solution on each answer is that of a single solve."""
    _, box = held
    q = three.close_on(box)
    g = three.at(q).grasp(box, hl.Coulomb(0.8), preload=0.003, environment=table(1e-5))
    assert not hl.GraspStream(g).update(q).held
    stream, rng = hl.GraspStream(g, start=g.solve()), np.random.default_rng(0)
    for _ in range(5):
        u = stream.update(q + 1e-4 * rng.normal(size=6))
        assert u.held
        np.testing.assert_allclose(u.forces, stream.grasp.solve(start=u).forces, atol=1e-8)
    assert not stream.update(wrench=(0, 0, 1e3, 0, 0, 0)).held, "nothing holds that"
    assert stream.update(wrench=(0, 0, -0.2 * G, 0, 0, 0)).held, "it begins at the solution again"
    assert pickle.loads(pickle.dumps(stream)).update(q).held
    refused("start", hl.GraspStream, g, start=three.at(q).grasp(box).solve(throw=False))


def test_a_stream_takes_arrays_of_fingers_and_leaves_the_table(held):
    state, box = held
    g = state.grasp(box, hl.Coulomb(0.8), preload=0.006, environment=table())
    stream = hl.GraspStream(g)
    there = arrays(g).positions[:3] + 1e-3 * UP
    stream.update(positions=there, frames=g.frames[:3], offset=np.full((3, 3), -1e-4))
    now = arrays(stream.grasp)
    np.testing.assert_array_equal(now.positions, [*there, *arrays(g).positions[3:]])
    np.testing.assert_array_equal(now.offset, [*np.full((3, 3), -1e-4), *g.offset[3:]])
    for bad in ({"offset": np.zeros((4, 3))}, {"positions": np.zeros((2, 3))}, {"frames": np.zeros((5, 3, 3))}):
        with pytest.raises(InputError):
            stream.update(**bad)


def test_a_table_below_the_hands_reach_and_bad_tables_are_refused(held):
    state, box = held
    with pytest.raises(NotReached, match="table"):
        state.grasp(box, environment=hl.Table((0, 0, 0.05)))
    for bad in ("floor", 3, [hl.Coulomb(0.5)], []):
        with pytest.raises(InputError) as info:
            state.grasp(box, environment=bad)
        assert info.value.argument.startswith("environment")
    for argument, change in {
        "point": {"point": (0, 0)}, "normal": {"normal": (0, 0, 2)}, "friction": {"friction": -0.5},
        "flexibility": {"flexibility": (1e-3, -1e-3, 0)}, "max_gap": {"max_gap": -1}, "name": {"name": 3},
    }.items():  # fmt: skip
        refused(argument, hl.Table, **{"point": (0, 0, 0)} | change)
    with pytest.raises(InputError):
        table().under("box")


def test_a_table_turned_round_is_refused_with_the_likely_cause():
    ball = hl.Sphere(0.035, (0, 0, 0.07), mass=0.2)
    with pytest.raises(hl.InputError) as info:
        hl.Table((0, 0, 0.105)).under(ball)  # the ball is above it, where its normal should point
    says(str(info.value), info.value.argument)
    assert len(hl.Table((0, 0, 0.105), (0, 0, -1)).under(ball).contacts) == 1


def test_fingers_that_are_detected_know_nothing_of_what_the_object_rests_on(tmp_path):
    """On a mesh; run as Python, which stops where compiled code would write beside its arrays."""
    corners = np.array([(x, y, z) for x in (-HALF, HALF) for y in (-HALF, HALF) for z in (-HALF, HALF)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [half for a, b, c, d in sides for half in ((a, b, c), (a, c, d))]
    mesh = hl.Mesh(write_mesh(tmp_path / "cube.obj", corners, faces), placement=(0, 0, 0.08), mass=0.2)
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    state = hand.at(hand.close_on(mesh))
    with interpreted():
        loading = state.grasp(mesh, hl.Coulomb(0.8), preload=0.003, environment=table()).follow(steps=2)
    assert loading.reached
    assert np.isfinite(loading.solution.forces).all()
    box = hl.Box(2 * HALF, (0, 0, 0.08), 0.2)
    like = state.grasp(box, hl.Coulomb(0.8), preload=0.003, environment=table()).follow(steps=2)
    np.testing.assert_allclose(loading.solution.forces, like.solution.forces, atol=1e-3)
