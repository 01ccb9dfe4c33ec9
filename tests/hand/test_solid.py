"""Convex shapes as numbers: how far they reach in a direction, and what lies in them, against closed forms."""

from __future__ import annotations

import coal
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from handlcp.geometry.distance import shape_distance_outside, support_points
from handlcp.robot.link_surface import hull_planes
from tests.support.kernels import interpreted

RNG = np.random.default_rng(4)
N = RNG.standard_normal((200, 3))
N /= np.linalg.norm(N, axis=1)[:, None]
CLOUD = RNG.standard_normal((40, 3)) * (0.02, 0.03, 0.05)


def _hull():
    hull = ConvexHull(CLOUD)
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for point in CLOUD:
        points.append(point)
    for (a, b, c), plane in zip(hull.simplices, hull.equations, strict=True):
        out = np.cross(CLOUD[b] - CLOUD[a], CLOUD[c] - CLOUD[a]) @ plane[:3] > 0.0
        triangles.append(coal.Triangle(*map(int, (a, b, c) if out else (a, c, b))))
    return coal.Convex(points, triangles)


ACROSS = np.hypot(N[:, 0], N[:, 1])
REACHES = {
    "box": (coal.Box(0.02, 0.06, 0.1), abs(N) @ (0.01, 0.03, 0.05)),
    "sphere": (coal.Sphere(0.03), np.full(len(N), 0.03)),
    "capsule": (coal.Capsule(0.01, 0.08), 0.01 + 0.04 * abs(N[:, 2])),
    "cylinder": (coal.Cylinder(0.02, 0.06), 0.02 * ACROSS + 0.03 * abs(N[:, 2])),
    "ellipsoid": (coal.Ellipsoid(0.01, 0.02, 0.03), np.linalg.norm(N * (0.01, 0.02, 0.03), axis=1)),
    "hull": (_hull(), (N @ CLOUD.T).max(axis=1)),
}


@pytest.mark.parametrize("name", REACHES)
@pytest.mark.parametrize("compiled", [True, False])
def test_a_shape_reaches_as_far_as_its_closed_form_says(name, compiled):
    shape, reach = REACHES[name]
    if compiled:
        points = support_points(shape, N)
    else:
        with interpreted():
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
        assert shape_distance_outside(shape, point) == pytest.approx(
            float((normals @ point - offsets).max()), abs=1e-15
        )
