"""Shapes against closed forms and coal's yes or no: gaps, depths, reach, swept balls, convex parts."""

import re
from contextlib import nullcontext

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from hypothesis import example, given, settings, strategies as st

import handlcp as hl
from handlcp.errors import InputError, Unsupported, URDFError
from handlcp.geometry import YCB, Box, Cylinder, Ellipsoid, Mesh
from handlcp.geometry.contact_detection import choose_corners as flat_corners
from handlcp.geometry.distance import shape_distance_outside, signed_distance, support_points
from handlcp.hand import Hand
from handlcp.hand.library import urdf
from handlcp.robot.link_surface import convex_hull, hull_planes
from tests.hard_cases.scenes import turn as random_turn
from tests.support.hand import ball_near, shape_near, swept_contacts, swept_station
from tests.support.kernels import interpreted

CLEAR = 1e-5  # [m] of a move that parts shapes, or leaves them in touch


def _lathe(path, outline, sides):
    """The solid that an outline of (radius, height) makes when turned about z, as an OBJ file; ends on the axis."""
    trimesh.creation.revolve(np.array(outline), sections=sides).export(path, digits=17)
    return path


def _barrel(folder):
    outline = [(0.0, -0.03), (0.015, -0.03), (0.02, 0.0), (0.012, 0.03), (0.0, 0.03)]
    return _lathe(folder / "barrel.obj", outline, 24)


def _pairs(seed, count, folder):
    """Tips and objects that overlap: cylinders and capsules against boxes, cylinders, ellipsoids and a mesh."""
    rng, barrel, made = np.random.default_rng(seed), _barrel(folder), 0
    while made < count:
        a, b, c = rng.uniform(0.005, 0.03, 3)
        placement = pin.SE3(random_turn(rng), rng.normal(size=3) * 0.01)
        tip = [coal.Cylinder(a, 2 * b), coal.Capsule(a, 2 * b), coal.Box(2 * a, 2 * b, 2 * c)][made % 3]
        sizes = rng.uniform(0.005, 0.03, 3)
        kinds = [
            lambda s=sizes, P=placement: Box(2 * s, P),
            lambda s=sizes, P=placement: Cylinder(s[0], 2 * s[1], P),
            lambda s=sizes, P=placement: Ellipsoid(s, P),
            lambda P=placement: Mesh(barrel, 1.0, P),
        ]
        obj, R = kinds[made % 4](), random_turn(rng)
        if _touch(tip, R, np.zeros(3), obj):
            made += 1
            yield tip, R, np.zeros(3), obj


def _touch(tip, R, p, obj):
    """Coal's yes or no, which needs no depth."""
    asked, found = coal.CollisionRequest(), coal.CollisionResult()
    asked.gjk_tolerance = 1e-8
    return coal.collide(tip, coal.Transform3s(R, p), obj.geometry, obj.transform, asked, found) > 0


def test_every_depth_is_the_shortest_way_out(tmp_path):
    """Moved out along the normal by the depth the tip is free; moved by less in any direction it is not."""
    rng = np.random.default_rng(1)
    for tip, R, p, obj in _pairs(0, 96, tmp_path):
        found = shape_near(tip, R, p, obj)
        assert -0.2 < found.gap < 0.0
        assert np.linalg.norm(found.normal) == pytest.approx(1.0)
        assert not _touch(tip, R, p + (found.gap - CLEAR) * found.normal, obj)
        for way in np.vstack([-found.normal, rng.normal(size=(20, 3))]):
            assert _touch(tip, R, p + max(-found.gap - CLEAR, 0.0) * way / np.linalg.norm(way), obj)
        np.testing.assert_allclose(found.tip_point - found.position, -found.gap * found.normal, atol=1e-6)


def test_every_gap_is_the_shortest_way_in(tmp_path):
    """The same of tips that are apart: moved by the gap along the normal they touch, by less in any way they don't."""
    rng = np.random.default_rng(2)
    for tip, R, p, obj in _pairs(1, 36, tmp_path):
        away = rng.normal(size=3)
        p = p + 0.15 * away / np.linalg.norm(away)
        found = shape_near(tip, R, p, obj)
        assert 0.0 < found.gap < 0.15
        assert _touch(tip, R, p + (found.gap + CLEAR) * found.normal, obj)
        for way in np.vstack([found.normal, rng.normal(size=(20, 3))]):
            assert not _touch(tip, R, p + (found.gap - CLEAR) * way / np.linalg.norm(way), obj)


def test_shapes_that_just_touch_have_a_gap_of_nothing_and_a_normal(tmp_path):
    """Also where coal's normal is off, or its distance -1.8e308: 10 µm along the normal they touch, 10 µm back not."""
    rng = np.random.default_rng(0)
    tips = Mesh(_barrel(tmp_path), 1.0).geometry, coal.Cylinder(0.01, 0.03)
    objects = Box((0.04, 0.05, 0.08)), Cylinder(0.03, 0.1), Ellipsoid((0.02, 0.03, 0.04))
    for k in range(120):
        tip, obj, R, p = tips[k % 2], objects[k % 3], random_turn(rng), rng.normal(size=3)
        p *= 0.12 / np.linalg.norm(p)
        for _ in range(3):
            found = shape_near(tip, R, p, obj)
            p = p + found.gap * found.normal
        last = shape_near(tip, R, p, obj)
        assert abs(last.gap) < 2e-7
        assert not _touch(tip, R, p - CLEAR * last.normal, obj)
        assert _touch(tip, R, p + CLEAR * last.normal, obj)


def test_where_the_normal_of_coal_is_off_the_gap_between_support_planes_is_found():
    R = [[0.41236122, -0.59586321, -0.6891337], [-0.46844637, -0.78746216, 0.40057627],
         [-0.78135537, 0.15764006, -0.60384881]]  # fmt: skip
    Q = [[0.58191348, -0.73582449, 0.34632213], [0.59943443, 0.10029459, -0.79411546],
         [0.54959537, 0.6697039, 0.49944131]]  # fmt: skip
    at = np.array(R), np.array([-0.03575414, 0.02130153, 0.17345556])
    there = np.array(Q), np.array([-0.01250012, -0.03067517, 0.16591636])
    box, can = coal.Box(0.014, 0.038, 0.02), coal.Cylinder(0.02634893, 0.10738267)
    gap, on, beside, n = signed_distance(box, at, can, there, ("a box", "a can"))
    one, two = np.array(coal.Box(0.014, 0.038, 0.02).halfSide), Q @ np.array([0.0, 0.0, 1.0])
    reach = one @ abs(n @ R)  # of the box along n; and of the can against it
    across = 0.02634893 * np.sqrt(1.0 - (n @ two) ** 2) + 0.053691335 * abs(n @ two)
    assert n @ (there[1] - at[1]) - reach - across == pytest.approx(gap, abs=1e-10)  # no larger: planes part them
    assert np.linalg.norm(beside - on) == pytest.approx(gap, abs=1e-10)  # no smaller: points are so near


def test_an_edge_seven_nanometres_from_a_hull_has_a_gap_though_coals_normal_is_not_of_unit_length():
    R = [[0.909638011, -0.112545343, -0.399865147], [0.121235446, 0.992617058, -0.003586484],
         [0.397316821, -0.045215427, 0.916566699]]  # fmt: skip
    sponge, edge = YCB("026_sponge").geometry, coal.Capsule(1e-4, 0.02370630840002)
    at, there = (np.array(R), np.array([0.035514826, 0.031615412, 0.011257383])), (np.eye(3), np.zeros(3))
    gap, on, beside, n = signed_distance(edge, at, sponge, there, ("an edge", "a sponge"))
    reach = n @ at[1] + 0.01185315420001 * abs(n @ at[0][:, 2]) + 1e-4  # of the edge along n
    assert gap == pytest.approx((np.asarray(sponge.points()) @ n).min() - reach, abs=1e-9)  # planes part them
    assert np.linalg.norm(beside - on) == pytest.approx(gap, abs=1e-9)  # points are so near


@pytest.mark.parametrize("shift", [0.0, 1e-3, -4e-3])
def test_a_cylinder_lying_in_a_slab_is_as_deep_as_its_radius_and_the_slab(shift):
    """A finger of radius 8 mm lies `shift` above the middle of a slab, 20 mm thick: out through the nearer side."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        Q, c = random_turn(rng), rng.normal(size=3)
        lying = Q @ pin.exp3(np.array([np.pi / 2, 0.0, 0.0]))
        found = shape_near(coal.Cylinder(0.008, 0.03), lying, c + Q[:, 2] * shift, Box((0.2, 0.2, 0.02), pin.SE3(Q, c)))
        assert found.gap == pytest.approx(-(0.018 - abs(shift)), abs=1e-9)
        assert abs(found.normal @ Q[:, 2]) == pytest.approx(1.0, abs=1e-9)


def test_a_ball_leaves_a_box_through_the_nearest_face():
    """Closed form, whichever face, edge or corner is the nearest one; inside and outside."""
    rng, size, r = np.random.default_rng(4), np.array([0.04, 0.06, 0.1]), 0.005
    for _ in range(150):
        P = pin.SE3(random_turn(rng), rng.normal(size=3))
        x = rng.uniform(-1, 1, 3) * size
        over = abs(x) - size / 2
        expected = np.linalg.norm(np.maximum(over, 0.0)) if over.max() > 0 else over.max()
        found = ball_near(r, P.act(x), Box(size, P))
        assert found.gap == pytest.approx(expected - r, abs=1e-12)
        on = P.actInv(found.position)
        assert (abs(on) - size / 2).max() == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(found.position - found.tip_point, found.gap * found.normal, atol=1e-12)


@pytest.mark.parametrize("sides", [254, 700])
def test_fine_cones_and_cylinders_are_hulls_too(sides, tmp_path):
    """A vertex with hundreds of neighbours, and lids with hundreds of corners: volumes and gaps by hand."""
    r, h = 0.02, 0.05
    base = sides / 2 * np.sin(2 * np.pi / sides) * r**2
    cone = Mesh(_lathe(tmp_path / "cone.obj", [(0.0, 0.0), (r, 0.0), (0.0, h)], sides), density=1.0)
    drum = Mesh(_lathe(tmp_path / "drum.obj", [(0.0, 0.0), (r, 0.0), (r, h), (0.0, h)], sides), density=1.0)
    assert cone.convex
    assert drum.convex
    assert cone.volume == pytest.approx(base * h / 3, rel=1e-5)
    assert drum.volume == pytest.approx(base * h, rel=1e-6)
    assert ball_near(0.01, (0.0, 0.0, h + 0.03), cone).gap == pytest.approx(0.02, abs=1e-6)
    assert ball_near(0.01, (0.003, 0.001, h + 0.005), drum).gap == pytest.approx(-0.005, abs=1e-8)
    post = coal.Cylinder(0.004, 0.02)
    assert shape_near(post, np.eye(3), np.array([0.0, 0.0, h + 0.009]), drum).gap == pytest.approx(-0.001, abs=1e-7)
    assert shape_near(post, np.eye(3), np.array([0.0, 0.0, -0.012]), cone).gap == pytest.approx(0.002, abs=1e-7)


def _with_tips(folder, mesh):
    """The two-finger hand with a mesh for the ball at each fingertip."""
    text = urdf("two_finger").read_text(encoding="utf-8")
    assert text.count("<sphere") > 0
    out = folder / "hand.urdf"
    out.write_text(re.sub(r"<sphere[^>]*/>", f'<mesh filename="{mesh}"/>', text), encoding="utf-8")
    return out


def test_a_fingertip_may_be_a_fine_cone_and_may_not_be_flat(tmp_path):
    """Coal refuses the one with a bare RuntimeError, and crashes on the other."""
    _lathe(tmp_path / "cone.obj", [(0.0, -0.008), (0.008, -0.008), (0.0, 0.008)], 300)
    hand = Hand.from_urdf(_with_tips(tmp_path, "cone.obj"), joint_stiffness=1.0)
    tip = hand.at(np.zeros(4)).tip_positions[0]
    state = hand.at(np.zeros(4))
    found = state.grasp(Box(0.02, tip + np.array([0.0, 0.0, -0.0175])), fingers=[hand.fingertips[0]], max_gap=1.0)
    assert np.isfinite(found.offset).all()
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    hand = Hand.from_urdf(_with_tips(tmp_path, "flat.obj"), joint_stiffness=1.0)
    with pytest.raises(URDFError, match=hand.fingertips[0]):
        hand.at(np.zeros(4)).grasp(Box(0.02, tip), max_gap=1.0)


def test_a_distance_that_cannot_be_checked_is_refused_with_names():
    """Of a shape whose support function is not known; a position that is no number is no contact either."""
    with pytest.raises(Unsupported, match=r"fingertip.*Box"):
        shape_near(coal.Cone(0.01, 0.02), np.eye(3), np.zeros(3), Box(0.1))
    with pytest.raises(Unsupported, match="confirmed"):
        shape_near(coal.Cylinder(0.01, 0.02), np.eye(3), np.full(3, np.nan), Box(0.1))


def test_a_mesh_that_is_flat_is_no_object(tmp_path):
    """A closed sheet of no thickness."""
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n")
    with pytest.raises(InputError, match=r"flat\.obj"):
        Mesh(tmp_path / "flat.obj")


# ---------------------------------------------------------------- convex shapes as numbers: how far they reach in a
RNG = np.random.default_rng(4)
N = RNG.standard_normal((200, 3))
N /= np.linalg.norm(N, axis=1)[:, None]
CLOUD = RNG.standard_normal((40, 3)) * (0.02, 0.03, 0.05)


ACROSS = np.hypot(N[:, 0], N[:, 1])
REACHES = {
    "box": (coal.Box(0.02, 0.06, 0.1), abs(N) @ (0.01, 0.03, 0.05)),
    "sphere": (coal.Sphere(0.03), np.full(len(N), 0.03)),
    "capsule": (coal.Capsule(0.01, 0.08), 0.01 + 0.04 * abs(N[:, 2])),
    "cylinder": (coal.Cylinder(0.02, 0.06), 0.02 * ACROSS + 0.03 * abs(N[:, 2])),
    "ellipsoid": (coal.Ellipsoid(0.01, 0.02, 0.03), np.linalg.norm(N * (0.01, 0.02, 0.03), axis=1)),
    "hull": (convex_hull(CLOUD), (N @ CLOUD.T).max(axis=1)),
}


@pytest.mark.parametrize("name", REACHES)
@pytest.mark.parametrize("compiled", [True, False])
def test_a_shape_reaches_as_far_as_its_closed_form_says(name, compiled):
    shape, reach = REACHES[name]
    with nullcontext() if compiled else interpreted():
        points = support_points(shape, N)
    np.testing.assert_allclose((points * N).sum(axis=1), reach, atol=1e-14)


@pytest.mark.parametrize("name", REACHES)
def test_furthest_points_lie_on_the_surface_and_what_is_further_is_beyond(name):
    shape, _ = REACHES[name]
    for point in support_points(shape, N[:50]):
        assert abs(shape_distance_outside(shape, point)) < 1e-12
        assert shape_distance_outside(shape, 0.9 * point) < 0.0 < shape_distance_outside(shape, 1.1 * point)


def test_how_far_a_point_is_beyond_a_hull_is_read_off_its_planes():
    shape, _ = REACHES["hull"]
    _, normals, offsets = hull_planes(shape)
    for point in 0.05 * N[:20]:
        beyond = float((normals @ point - offsets).max())
        assert shape_distance_outside(shape, point) == pytest.approx(beyond, abs=1e-15)


# ---------------------------------------------------------------- swept balls: the nearest station beside a search
BALL, BOX, CAN, EGG = hl.Sphere(0.03), Box((0.05, 0.04, 0.06)), Cylinder(0.03, 0.08), Ellipsoid((0.02, 0.03, 0.05))


def drawn(rng, lines):
    """Centre, spans and radius of a swept ball beside an object."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    spans = np.zeros((2, 3))
    spans[:lines] = (axes[:, :lines] * rng.uniform(0.005, 0.03, lines)).T
    way = rng.normal(size=3)
    return 0.09 * way / np.linalg.norm(way), spans, rng.uniform(0.0, 0.01)


@pytest.mark.parametrize("obj", [BALL, BOX, CAN, EGG], ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("lines", [1, 2])
def test_no_station_is_nearer_than_the_one_found(obj, lines):
    rng = np.random.default_rng(3)
    for _ in range(8):
        centre, spans, _ = drawn(rng, lines)
        found = obj.closest(swept_station(obj, centre, spans))[0]
        grid = np.linspace(-1.0, 1.0, 21)
        every = [centre + s * spans[0] + t * spans[1] for s in grid for t in (grid if lines > 1 else (0.0,))]
        assert found <= min(obj.closest(point)[0] for point in every) + 1e-9


@pytest.mark.parametrize("obj", [BALL, CAN, EGG], ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("lines", [0, 1, 2])
def test_contacts_turn_and_shift_as_differences_of_them_do(obj, lines):
    rng = np.random.default_rng(5)
    for _ in range(6):
        centre, spans, radius = drawn(rng, lines)
        place, turn = rng.normal(size=3) * 0.01, pin.exp3(rng.normal(size=3))
        swept = turn.T @ (centre - place), spans @ turn, radius
        _, _, _, dn, dx = swept_contacts(obj, swept, place, turn)
        h = 1e-6
        for a in range(6):
            by = np.zeros(3)
            by[a % 3] = h
            ends = []
            for sign in (1.0, -1.0):
                moved = (place + sign * by, turn) if a < 3 else (place, pin.exp3(sign * by) @ turn)
                ends.append(swept_contacts(obj, swept, *moved))
            x, n = ((ends[0][k] - ends[1][k]) / (2 * h) for k in (0, 1))
            np.testing.assert_allclose(dn[:, a], n, atol=2e-3 * (1 + abs(n).max()))
            np.testing.assert_allclose(dx[:, a], x, atol=2e-3 * (1 + abs(x).max()))


# ---------------------------------------------------------------- tiny facets: whether they touch at a point or
# Of a facet that one measure called wide while no corner was so far from the first one chosen
FLAT = np.array([[9.77e-5, -8.5e-6], [-9.78e-5, -2.6e-6], [-7.12e-5, -6.85e-5], [7.11e-5, 6.15e-5]])  # m
APART = 1.93439e-4


def test_a_facet_that_is_wide_has_two_corners_also_where_they_are_nearer_than_that():
    assert np.ptp(FLAT[:, 0]) > APART
    assert len(flat_corners(FLAT, APART)) == 2


@given(seed=st.integers(0, 2**32 - 1), over=st.floats(0.0, 1.0), thin=st.floats(0.0, 1.0))
@example(seed=15, over=0.0, thin=0.5)
@settings(max_examples=100, deadline=None)
def test_points_that_are_wide_span_at_least_two_corners(seed, over, thin):
    """However little wider than the threshold they are; no other two of the corners are nearer than that."""
    points = np.random.default_rng(seed).normal(size=(8, 2)) * (1.0, thin)
    points -= points.mean(axis=0)
    apart = float(np.ptp(points[:, 0])) / (1.0 + 1e-12 + over)
    chosen = flat_corners(points, apart)
    assert 2 <= len(chosen) == len(set(chosen)) <= 4
    between = np.linalg.norm(points[chosen, None] - points[chosen], axis=2)
    assert (between[np.triu_indices(len(chosen), 1)][1:] > apart).all()


# ---------------------------------------------------------------- convex parts of meshes that are not convex: of
@pytest.fixture(scope="module")
def ring():
    pytest.importorskip("coacd")
    return hl.Mesh(trimesh.creation.annulus(0.02, 0.03, 0.04, sections=24), mass=0.1)


def test_the_parts_of_a_ring_fill_it_and_leave_its_middle_empty(ring):
    assert not ring.convex
    volume = sum(float(part.computeVolume()) for part in ring.parts)
    assert volume == pytest.approx(ring.volume, rel=0.15)
    assert len(ring.parts) > 3


def test_links_touch_a_ring_in_its_parts(ring):
    """A box flat on the ring's upper side: as far away as it was put."""
    near = shape_near(coal.Box(0.1, 0.1, 0.02), np.eye(3), np.array([0.0, 0.0, 0.02 + 0.01 + 0.003]), ring)
    assert near.gap == pytest.approx(0.003, abs=1e-4)


def test_a_link_that_is_not_there_has_no_parts():
    pytest.importorskip("coacd")
    with pytest.raises(hl.UnknownName, match="palm"):
        hl.example_hand("two_finger").in_parts("thumb")
    parted = hl.example_hand("two_finger").in_parts("palm")
    assert parted.in_parts_of == {"palm"}
