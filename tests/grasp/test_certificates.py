"""Certifier, uniqueness, holdability: no wrong answer passes, what is loose is named, every no is proven."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support.grasp import arrays, at_centre, judged as judged_with, nearest_in_polygon
from tests.support.search import is_escape, jammed, least_total
from tests.support.texts import says

PYRAMID = hl.Pyramid(8)


def judged(g, forces, twist):
    return judged_with(g, PYRAMID, forces, twist)


@pytest.fixture(params=range(4))
def answer(request):
    contacts, data = ring(np.random.default_rng(request.param))
    g = hl.Grasp(contacts, **data)
    s = g.solve(8)
    return g, s.forces.copy(), at_centre(g, s)


def test_the_answer_passes(answer):
    assert judged(*answer).passes


def test_every_corrupted_force_is_refused(answer):
    g, f, u = answer
    for i in range(f.size):
        for change in (1e-5, -1e-5, np.nan, np.inf):
            bad = f.copy()
            bad.flat[i] += change * abs(f).max()
            assert not judged(g, bad, u).passes


def test_every_corrupted_motion_is_refused(answer):
    g, f, u = answer
    for i in range(6):
        for change in (1e-4, -1e-4, np.nan):
            bad = u.copy()
            bad[i] += change * arrays(g).units.motion_unit / (1 if i < 3 else arrays(g).units.length_unit)
            assert not judged(g, f, bad).passes


def test_a_motion_at_a_rigid_support_is_refused_as_it_changes_the_fingers_forces():
    """Two springs squeeze a ball that stands on a rigid point: 1e-6 of what bends the stiffer one is too much there."""
    z = np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 1.0]])
    contacts = [hl.Contact(-0.03 * n, n, hl.Coulomb(0.5)) for n in z]
    E = np.diag(np.repeat([1e-4, 1e-3, 0.0], 3))
    g = hl.Grasp(contacts, (0, 0, -1.0, 0, 0, 0), flexibility=E, preload=[1e-3, 1e-3, 0.0])
    s = g.solve(8)
    f, u = s.forces.copy(), at_centre(g, s)
    assert judged(g, f, u).passes
    for i in range(3):  # rigid across and along the normal
        bad = u.copy()
        bad[i] += 1e-6 * 1e-4 * abs(f).max()
        assert not judged(g, f, bad).passes


def test_forces_scaled_beyond_balance_are_refused(answer):
    g, f, u = answer
    assert judged(g, 1.001 * f, u).balance > 1e-5
    assert judged(g, 0 * f, u).balance > 1e-2


def test_pulling_is_refused():
    g = pinch(load=(0, 0, 0), squeeze=0.0)
    f = np.array([[0, 0, -1.0], [0, 0, -1.0]])
    assert judged(g, f, np.zeros(6)).normal > 0.1


@pytest.mark.parametrize("faces", [3, 4, 5, 8, 16, 2, 0])
def test_the_projection_on_the_friction_polygon_is_the_nearest_point(faces):
    rng = np.random.default_rng(faces)
    m = faces or 4096
    a = 2 * np.pi * np.arange(m) / m
    N = np.vstack([np.cos(a), np.sin(a)]) if faces != 2 else np.array([[1.0, -1], [0, 0]])
    for _ in range(200):
        p = rng.normal(size=2) * 2
        x = np.array(nearest_in_polygon(*p, 0.7, faces))
        assert (N.T @ x <= 0.7 + (1e-6 if faces == 0 else 1e-12)).all()
        if faces == 2:
            assert x[1] == 0.0
            continue
        # variational inequality of the nearest point, tested at the polygon's vertices
        vertices = 0.7 / np.cos(np.pi / m) * np.vstack([np.cos(a + np.pi / m), np.sin(a + np.pi / m)])
        assert ((p - x) @ (vertices - x[:, None]) <= (1e-5 if faces == 0 else 1e-9)).all()


# ---------------------------------------------------------------- uniqueness
def test_example_3_leaves_one_direction_of_the_object_free():
    s = cube_example().solve(8)
    assert s.uniqueness.loose_motions == 1
    assert s.uniqueness.forces_determined


def test_moving_along_a_loose_direction_keeps_every_law_and_another_direction_does_not():
    g = cube_example()
    s = g.solve(8)
    d = s.uniqueness.directions[0]
    u = at_centre(g, s)
    step = at_centre(g, d) * 1e-8 / np.linalg.norm(d)  # the slips may turn by 1e-7 m only
    assert judged(g, s.forces, u + step).passes
    assert judged(g, s.forces, u - step).passes
    other = np.roll(step, 1)
    assert not judged(g, s.forces, u + other).passes


def test_the_smallest_motion_is_given():
    g = cube_example()
    s = g.solve(8)
    d = s.uniqueness.directions[0]
    for t in (-1e-8, 1e-8):
        shifted = at_centre(g, s.object_displacement + t * d / np.linalg.norm(d))
        assert judged(g, s.forces, shifted).passes
        now = at_centre(g, s)
        size = np.r_[np.ones(3), np.full(3, arrays(g).units.length_unit)]
        assert np.linalg.norm(shifted * size) >= np.linalg.norm(now * size) * (1 - 1e-9)


def test_the_smallest_motion_of_a_mirrored_scene_is_mirrored():
    """Example 3 is its own mirror image in the plane x = y: and so is its smallest motion."""
    for faces in (8, 16):
        s = cube_example().solve(faces)
        u = s.object_displacement
        np.testing.assert_allclose(u[[0, 3, 5]], [u[1], -u[4], 0], atol=1e-9 * abs(u).max())
        np.testing.assert_allclose(s.slip[0], s.slip[1] * [1, -1], atol=1e-9 * abs(s.slip).max())


def test_an_object_nobody_touches_is_loose_in_every_direction():
    s = pinch(squeeze=-1e-3, load=(0, 0, 0)).solve()
    assert s.contact_state == ("separated", "separated")
    assert s.uniqueness.loose_motions == 6
    np.testing.assert_array_equal(s.object_displacement, 0)


# ---------------------------------------------------------------- holdability
@pytest.mark.parametrize("seed", range(6))
def test_what_escapes_is_proven_by_signs(seed):
    rng = np.random.default_rng(seed)
    contacts, _ = ring(rng, n=3)
    # all fingers push upwards, and so does the load
    up = [hl.Contact(c.position, (0, 0, 1), hl.Coulomb(0.3)) for c in contacts]
    g = hl.Grasp(up, (0.1, 0, 1.0, 0, 0, 0), flexibility=1e-4)
    s = g.solve(throw=False)
    assert s.status is hl.Status.NOT_HOLDABLE
    t = s.certificate
    p = np.array([c.position for c in g.contacts])
    angles = 2 * np.pi * (np.arange(8) + 0.5) / 8
    for c, a in zip(g.contacts, p, strict=True):
        at = t[:3] + np.cross(t[3:], a)
        edges = c.rotation @ np.vstack([0.3 * np.cos(angles), 0.3 * np.sin(angles), np.ones(8)])
        assert (at @ edges >= -1e-9).all()  # no force of the finger resists
    assert arrays(g).force @ t[:3] + arrays(g).moment @ t[3:] > 0  # and the load drives it


def test_an_escape_that_does_no_work_or_is_resisted_is_no_proof():
    g = pinch()
    w = arrays(g).natural.w
    assert not is_escape(g, PYRAMID, np.zeros(6))
    assert not is_escape(g, PYRAMID, -w)
    assert not is_escape(g, PYRAMID, w)  # downwards: friction resists
    assert not is_escape(g, PYRAMID, np.full(6, np.nan))


@pytest.mark.parametrize("faces", [4, 8])
def test_a_bound_on_the_total_force_below_what_the_load_needs_is_named(faces):
    """Friction 0.5 holds 1 N with 2 N in all; more in a pyramid, where the load lies between two edges."""
    g = pinch(mu=0.5, load=(0, 0, -1.0), effects=[hl.TotalForceBound(1e-3)])
    s = g.solve(faces, throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    least = 2 / np.cos(np.pi / faces)
    assert least_total(g, faces) == pytest.approx(least)
    says(s.diagnosis, "0.001 N", f"{least:.4g} N")


def test_rigid_fingers_that_overlap_the_object_are_named():
    squeezed = [hl.Contact((x, 0, 0), (-np.sign(x), 0, 0), hl.Coulomb(0.5)) for x in (-0.01, 0.01)]
    g = hl.Grasp(squeezed, (0, 0, -1, 0, 0, 0), preload=1e-3)
    s = g.solve(throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    says(s.diagnosis, "give way")
    touching = hl.Grasp(squeezed, (0, 0, -1, 0, 0, 0))
    aside = hl.Grasp(squeezed, (0, 0, -1, 0, 0, 0), preload=[1e-3, -1e-3])
    soft = hl.Grasp(squeezed, (0, 0, -1, 0, 0, 0), preload=1e-3, flexibility=1e-4)
    assert jammed(g)
    assert not any(jammed(x) for x in (touching, aside, soft))


@pytest.mark.parametrize("slide", [1e-3, 1.0, 1e3, 1e6, 1e9])
def test_no_slide_is_long_enough_to_excuse_an_overlap(slide):
    """A load 1 % beyond what the squeeze can hold: forces 1 % larger than the springs give are no answer, however far
    the object slides meanwhile.
    """
    load = 5.0 * 1.01  # 2 fingers · 10 N · 0.25
    line = [((-0.01, 0, 0), (1, 0, 0)), ((0.01, 0, 0), (-1, 0, 0))]
    contacts = [hl.Contact(p, z, hl.Coulomb(0.25), tangent=(0, 0, 1)) for p, z in line]
    g = hl.Grasp(contacts, (0, 0, -load, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    f = np.array([[load / 2, 0, 10.1], [load / 2, 0, 10.1]])
    assert not judged_with(g, hl.Pyramid(4, inscribed=False), f, (0, 0, -slide, 0, 0, 0)).passes


@pytest.mark.parametrize("seed", range(12))
def test_contacts_at_one_point_have_no_size_made_of_rounding(seed):
    """Their mean may differ from that point by the last bit, which is no length to measure moments with."""
    at = np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
    z = [(0, 0, 1), (0, 0.6, 0.8), (0.6, 0, 0.8)]
    f = np.array([0.1, 0.2, -1.3])
    g = hl.Grasp([hl.Contact(at, a) for a in z], np.r_[f, np.cross(at, f)], flexibility=1e-4)
    assert g.solve(throw=False).held
    assert arrays(g).units.length_unit > 1e-3
