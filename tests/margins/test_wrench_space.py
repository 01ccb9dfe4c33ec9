"""ε and volume of the wrench space: polytopes whose numbers are known, scaling, and flat ones."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from tests.margins.test_closure import A, grasp, tilted, triangle

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
