"""Force closure, form closure and the wrench space: textbook cases, Nguyen's rule, polytopes with known numbers."""

import numpy as np
import pytest

import handlcp as hl

A = 0.02  # half a side [m]


def grasp(points, normals, friction=None, **more):
    friction = hl.Frictionless() if friction is None else friction
    contacts = [hl.Contact(p, n, friction) for p, n in zip(points, normals, strict=True)]
    return hl.Grasp(contacts, flexibility=1e-4, preload=1e-4, **more)


def square(shift):
    """A planar square touched on its four sides, each contact `shift` beyond the middle, always the same way round but
    for the flanks, where it is the other way round.
    """
    points = [(shift, -A), (-shift, A), (-A, shift), (A, -shift)]
    return points, [(0, 1), (0, -1), (1, 0), (-1, 0)]


def located():
    """Seven contacts of a unit cube: three below, two behind, one beside it, and a clamp on its cut corner through the
    middle of all. (The 3-2-1 rule of fixtures.)
    """
    below = [(0.5 + 0.3 * np.cos(a), 0.5 + 0.3 * np.sin(a), 0.0) for a in 2 * np.pi * np.arange(3) / 3]
    points = [*below, (0.2, 0, 0.5), (0.8, 0, 0.5), (0, 0.5, 0.5), (0.9, 0.9, 0.9)]
    clamp = -np.ones(3) / np.sqrt(3)
    return points, [*[(0, 0, 1)] * 3, *[(0, 1, 0)] * 2, (1, 0, 0), clamp]


def triangle(friction):
    angles = 2 * np.pi * np.arange(3) / 3
    points = [(A * np.cos(a), A * np.sin(a), 0.0) for a in angles]
    return grasp(points, [tuple(-np.array(p) / A) for p in points], friction)


def tilted(angle, friction, planar):
    """Two fingers opposite each other, the first one's normal turned by an angle [rad] off the line between them."""
    if planar:
        return grasp([(-A, 0), (A, 0)], [(np.cos(angle), np.sin(angle)), (-1, 0)], friction)
    return grasp([(-A, 0, 0), (A, 0, 0)], [(np.cos(angle), 0, np.sin(angle)), (-1, 0, 0)], friction)


def wrenches_of(g, closure):
    """(6,) sum of the witness's forces about the reference."""
    total = np.zeros(6)
    for c, R, f in zip(g.contacts, g.frames, closure.forces, strict=True):
        total += np.append(R @ f, np.cross(c.position - g.reference, R @ f))
    return total


def rates(g, closure):
    """(n, 3) how fast the object's contact points move in the witness's motion, contact axes."""
    u, omega = closure.motion[:3], closure.motion[3:]
    return np.array([R.T @ (u + np.cross(omega, c.position - g.reference))
                     for c, R in zip(g.contacts, g.frames, strict=True)])  # fmt: skip


# ---------------------------------------------------------------- form closure
@pytest.mark.parametrize("body", [square(0.005), located()], ids=["square", "cube"])
def test_contacts_that_turn_a_square_both_ways_or_locate_a_cube_leave_no_motion_and_none_of_them_can_be_spared(body):
    points, normals = body
    g = grasp(points, normals)
    found = g.margins().form_closure
    assert found.closed
    assert found.motion is None
    assert (found.forces[:, 2] > 0).all()
    assert found.forces[:, 2].sum() == pytest.approx(1.0)
    assert wrenches_of(g, found) == pytest.approx(np.zeros(6), abs=1e-12)
    for left_out in range(len(points)):
        g = grasp(*([x for k, x in enumerate(of) if k != left_out] for of in body))
        found = g.margins().form_closure
        assert found.closed is False
        assert (rates(g, found)[:, 2] >= -1e-9).all()  # nothing is pushed into


def test_four_contacts_through_one_point_leave_it_a_turn():
    g = grasp(*square(0.0))
    found = g.margins().form_closure
    assert found.closed is False
    assert found.motion[:2] == pytest.approx([0, 0], abs=1e-9)
    assert abs(found.motion[5]) > 0.0
    assert "turns about" in found.sentence


def test_without_friction_force_closure_is_form_closure():
    for g in (grasp(*square(0.005)), grasp(*square(0.0)), grasp(*located())):
        m = g.margins()
        assert m.force_closure.closed is m.form_closure.closed


# ---------------------------------------------------------------- force closure
NGUYEN = [(a, hl.Coulomb(0.5), True) for a in (-0.45, 0.0, 0.46, 0.47, 0.8)]
MURRAY = [(a, hl.SoftFinger(0.5, 0.002), False) for a in (-0.46, 0.0, 0.455, 0.475)]


@pytest.mark.parametrize(("angle", "law", "planar"), NGUYEN + MURRAY)
def test_two_fingers_have_it_where_their_line_lies_in_both_cones(angle, law, planar):
    """In a plane, Nguyen's rule; soft fingers, Murray, Li & Sastry, theorem 5.7. atan 0.5 = 0.4636."""
    assert tilted(angle, law, planar).margins().force_closure.closed is bool(abs(np.tan(angle)) < 0.5)


def test_of_all_motions_that_are_left_the_plainest_one_is_told():
    """Four contacts around a cube leave it to slide and to turn; noise in the places does not change what is told."""
    points = [(A, 0, 0), (-A, 0, 0), (0, A, 0), (0, -A, 0)]
    for noise in (0.0, 1e-12, -1e-12):
        moved = [np.array(p) + noise * np.array([1.0, -2.0, 3.0]) for p in points]
        found = grasp(moved, [-np.array(p) / A for p in points]).margins().form_closure
        assert found.motion == pytest.approx([0, 0, 1, 0, 0, 0], abs=1e-9)
        assert found.sentence.startswith("without friction the object slides along (0, 0, 1)")


def test_two_point_fingers_in_space_leave_the_turn_about_their_line():
    g = tilted(0.0, hl.Coulomb(0.5), planar=False)
    found = g.margins().force_closure
    assert found.closed is False
    assert rates(g, found) == pytest.approx(np.zeros((2, 3)), abs=1e-9)
    assert found.sentence == "the object turns about the line through fingers 1 and 2, and no contact resists"


@pytest.mark.parametrize("faces", ["cone", 4, 16])
def test_three_fingers_around_a_ball_have_it_with_forces_within_friction(faces):
    g = triangle(hl.Coulomb(0.3))
    found = g.margins(faces=faces).force_closure
    assert found.closed
    assert wrenches_of(g, found) == pytest.approx(np.zeros(6), abs=1e-12)
    assert (np.hypot(*found.forces[:, :2].T) < 0.3 * found.forces[:, 2]).all()


@pytest.mark.parametrize("mu", [0.57, 0.58])
def test_on_the_cone_it_is_told_to_a_percent_of_the_friction(mu):
    """Three fingers around a ring, one pushing across: with normals 60° off the bisector, atan μ ≥ 30° is needed."""
    points = [(A * np.cos(a), A * np.sin(a), 0.0) for a in np.radians([0, 60])]
    g = grasp(points, [(-1, 0, 0), tuple(-np.array(points[1]) / A)], hl.SoftFinger(mu, 0.01))
    assert g.margins().force_closure.closed is False  # two fingers on one side of the ball push it out
    chord = [(-A, 0, 0), (A * np.cos(np.pi / 3), A * np.sin(np.pi / 3), 0.0)]
    g = grasp(chord, [(1, 0, 0), tuple(-np.array(chord[1]) / A)], hl.SoftFinger(mu, 0.01))
    line = np.array(chord[1]) - np.array(chord[0])
    needs = np.tan(np.arccos(line[0] / np.linalg.norm(line)))  # 1/√3 = 0.5774, at both fingers
    assert g.margins().force_closure.closed is bool(mu > needs)


def test_a_box_that_lies_on_a_table_has_none_as_nothing_holds_it_down():
    corners = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.4)) for x in (-A, A) for y in (-A, A)]
    finger = hl.Contact((-A, 0, A), (1, 0, 0), hl.Coulomb(0.4))
    g = hl.Grasp([finger], flexibility=1e-4, environment=hl.Environment(corners))
    found = g.margins().force_closure
    assert found.closed is False
    v = rates(g, found)
    assert (v[:, 2] >= 0.4 * np.hypot(v[:, 0], v[:, 1]) - 1e-7).all()  # no force within the cones resists it


def test_a_contact_whose_force_is_prescribed_takes_no_part():
    g = tilted(0.0, hl.Coulomb(0.5), planar=True)
    assert g.margins().force_closure.closed
    fixed = g.replace(effects=[hl.PrescribedForce(1, (0, 0, 1.0))])
    assert fixed.margins().force_closure.closed is False


# ---------------------------------------------------------------- ε and volume of the wrench space: polytopes whose
MU = 0.5


def test_normals_along_all_axes_make_a_cross_polytope():
    """ε = 1/√d, volume 2ᵈ/d!: forces alone, in three dimensions of six, as no contact of a ball makes a moment."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    space = grasp(A * axes, -axes).margins().wrench_space
    assert (space.dimension, space.of) == (3, 6)
    assert space.epsilon == pytest.approx(1 / np.sqrt(3), rel=1e-12)
    assert space.volume == pytest.approx(8 / 6, rel=1e-12)
    assert space.volume_most == space.volume
    flat = grasp(A * axes[[0, 1, 3, 4], :2], -axes[[0, 1, 3, 4], :2]).margins().wrench_space
    assert (flat.dimension, flat.of) == (2, 3)
    assert flat.epsilon == pytest.approx(1 / np.sqrt(2), rel=1e-12)
    assert flat.volume == pytest.approx(2.0, rel=1e-12)


def test_two_planar_fingers_make_a_tetrahedron():
    """Corners (±1, ±μ, ∓μ), torque over half the distance: every second corner of a box, ε = μ/√(μ² + 2)."""
    m = tilted(0.0, hl.Coulomb(MU), planar=True).margins()
    assert m.wrench_space.length == pytest.approx(A)
    assert m.epsilon == pytest.approx(MU / np.sqrt(MU**2 + 2), rel=1e-12)
    assert m.volume == pytest.approx(8 * MU**2 / 3, rel=1e-12)


@pytest.mark.parametrize("length", [0.005, 0.1])
def test_the_length_that_scales_moments_is_the_one_asked_for(length):
    m = tilted(0.0, hl.Coulomb(MU), planar=True).margins(length=length)
    share = A / length  # of the torque axis
    assert m.epsilon == pytest.approx(1 / np.sqrt(1 + 1 / MU**2 + 1 / (MU * share) ** 2), rel=1e-12)
    assert m.volume == pytest.approx(8 * MU**2 * share / 3, rel=1e-12)


def test_in_the_weakest_direction_the_grasp_bears_epsilon_and_no_more():
    """Any larger load there needs normal forces of more than 1 N in all."""
    m = triangle(hl.Coulomb(MU)).margins()
    space = m.wrench_space
    size = np.linalg.norm(space.weakest / ([1.0] * 3 + [space.length] * 3))
    assert size == pytest.approx(space.epsilon, rel=1e-9)


def test_on_the_cone_epsilon_lies_below_the_support_in_every_direction():
    """Of three fingers at 120° on a sphere: the support of each contact is n·t + μ |T·t|, without any faces."""
    g = triangle(hl.Coulomb(MU))
    space = g.margins().wrench_space
    rng = np.random.default_rng(0)
    t = rng.normal(size=(200000, 6))
    t /= np.linalg.norm(t, axis=1)[:, None]
    reach = []
    for c, R in zip(g.contacts, g.frames, strict=True):
        arm = np.cross(c.position / A, R, axisb=0, axisc=0)
        W = np.vstack([R, arm])
        along = t @ W
        reach.append(along[:, 2] + MU * np.hypot(along[:, 0], along[:, 1]))
    least = np.maximum(np.max(reach, axis=0), 0.0).min()
    assert space.epsilon <= least
    assert space.epsilon > 0.7 * least  # random directions come near to the weakest
    assert space.epsilon <= space.epsilon_most <= 1.1 * space.epsilon
    assert space.epsilon_most <= MU  # which is all that friction bears along the axis


def test_pyramids_within_the_cone_give_less_and_come_closer_with_their_faces():
    found = [triangle(hl.Coulomb(MU)).margins(faces=faces).wrench_space for faces in (4, 8, 16)]
    exact = triangle(hl.Coulomb(MU)).margins().wrench_space
    epsilons = [space.epsilon for space in found]
    assert epsilons[0] < epsilons[2] <= exact.epsilon_most
    assert exact.epsilon <= exact.epsilon_most
    assert exact.volume <= exact.volume_most
    assert found[0].volume < found[1].volume < found[2].volume <= exact.volume_most
    assert all(space.faces == 0 for space in found)
    assert exact.faces > 0


@pytest.mark.parametrize("law", [hl.SoftFinger(MU, 0.01), hl.AnisotropicCoulomb(0.6, 0.2)])
def test_soft_and_anisotropic_fingers_have_a_wrench_space_as_others_do(law):
    space = triangle(law).margins().wrench_space
    assert space.dimension == 6
    assert 0.0 < space.epsilon <= space.epsilon_most
    assert space.epsilon_most <= 1.1 * space.epsilon


def test_without_force_closure_epsilon_is_nothing():
    points = [(A, 0, 0), (0, A, 0), (A / np.sqrt(2), A / np.sqrt(2), 0)]
    space = grasp(points, [tuple(-np.array(p) / np.linalg.norm(p)) for p in points], hl.Coulomb(0.3)).margins()
    assert space.force_closure.closed is False
    assert space.epsilon == 0.0


def test_epsilon_is_positive_exactly_where_there_is_force_closure():
    rng = np.random.default_rng(2)
    seen = set()
    for _ in range(12):
        points = rng.normal(size=(3, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        m = grasp(A * points, -points, hl.Coulomb(rng.uniform(0.2, 1.2))).margins()
        seen.add(m.force_closure.closed)
        assert (m.epsilon > 0.0) is m.force_closure.closed
    assert seen == {True, False}


def test_fewer_dimensions_are_said_and_none_fails():
    one = grasp([(A, 0, 0)], [(-1, 0, 0)]).margins().wrench_space
    assert (one.dimension, one.epsilon, one.volume) == (1, 0.0, pytest.approx(1.0))
    both = grasp([(A, 0, 0), (-A, 0, 0)], [(-1, 0, 0), (1, 0, 0)]).margins()
    assert (both.wrench_space.dimension, both.epsilon, both.volume) == (1, pytest.approx(1.0), pytest.approx(2.0))
    assert "1 of 6 dimensions" in str(both)
    none = grasp([(A, 0, 0)], [(-1, 0, 0)], effects=[hl.PrescribedForce(0, (0, 0, 1.0))]).margins()
    assert none.wrench_space.dimension == 0
    assert "no contact has an unknown force" in str(none)
