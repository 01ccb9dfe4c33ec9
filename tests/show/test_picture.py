"""Pictures: written, not blank, with everything inside; and the geometry behind them."""

import pathlib

import numpy as np
import pytest
from matplotlib.image import imread

from handlcp import Contact, Coulomb, Environment, Frictionless, Grasp
from handlcp.errors import InputError, Unsupported
from handlcp.scene import load
from handlcp.viz.picture import body as shapes
from handlcp.viz.picture.body import environment_bodies, stub_bodies
from handlcp.viz.picture.camera import fill_triangles
from handlcp.viz.picture.figure import draw_solution
from handlcp.viz.picture.overlay import friction_cone_rim
from tests.show.picture_cases import ring
from tests.support import patches
from tests.support.grasp import arrays
from tests.support.show import save
from tests.support.texts import says

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def volume(t):
    return float(np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6)


@pytest.mark.parametrize(
    "name",
    ["cube_three_fingers", *(pytest.param(one, marks=pytest.mark.long) for one in ("planar_ring", "allegro_pinch"))],
)
def test_a_picture_is_written_and_shows_something(name, tmp_path):
    scene = load(EXAMPLES / f"{name}.toml")
    grasp = scene.build()
    file = save(grasp, grasp.solve(), tmp_path / "out.png", title=scene.title)
    image = imread(file)[..., :3]
    assert image.shape[1] == 1600
    left = image[200:, : image.shape[1] * 7 // 10]
    assert left.std() > 0.08, "not blank"
    assert len(np.unique((left * 15).astype(int).reshape(-1, 3), axis=0)) > 60, "shaded"
    blue = abs(left - np.array([0x00, 0x72, 0xB2]) / 255).max(-1) < 0.02
    assert blue.sum() > 500, "forces of sticking fingers"
    border = np.concatenate([image[:8].reshape(-1, 3), image[-8:].reshape(-1, 3), image[:, -8:].reshape(-1, 3)])
    assert border.min() > 0.98, "nothing runs off the page"


def test_a_grasp_that_does_not_hold_shows_the_way_out(tmp_path):
    grasp = ring(3, Frictionless())
    s = grasp.solve(throw=False)
    assert not s.held
    image = imread(save(grasp, s, tmp_path / "a.png"))[..., :3]
    orange = abs(image - np.array([0xD5, 0x5E, 0x00]) / 255).max(-1) < 0.04
    assert orange.sum() > 50


def test_a_format_or_place_that_cannot_be_written_is_refused(tmp_path):
    grasp = ring(3)
    s = grasp.solve()
    with pytest.raises(InputError, match=r"\.png, \.svg, \.pdf"):
        save(grasp, s, tmp_path / "a.doc")
    with pytest.raises(InputError) as wrong:
        save(grasp, s, tmp_path / "no" / "a.png")
    says(str(wrong.value).replace(str(tmp_path), "…"), "exists")


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    grasp = ring(3)
    s = grasp.solve()
    patches.without_module(monkeypatch, "matplotlib")
    with pytest.raises(Unsupported, match="pip install 'matplotlib>="):
        draw_solution(grasp, s)


def test_shapes_are_closed_wind_outwards_and_have_their_volume():
    assert volume(shapes.box_triangles((1, 2, 3))) == pytest.approx(6)
    assert volume(shapes.ellipsoid_triangles((1, 2, 3))) == pytest.approx(8 * np.pi, rel=0.02)
    assert volume(shapes.cylinder_triangles(1, 2)) == pytest.approx(2 * np.pi, rel=0.01)
    rod = shapes.capsule_triangles((0, 0, 0), (0, 3, 4), 1)
    assert volume(rod) == pytest.approx(5 * np.pi + 4 / 3 * np.pi, rel=0.06)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    assert volume(shapes.thick_hull(corners, 0.1)) == pytest.approx(1)
    assert shapes.thick_hull(np.array([[0, 0, 0], [1, 0, 0]]), 0.1) is None


def test_a_fine_surface_is_made_coarse_and_stays_where_it_is():
    plain = shapes.box_triangles((1, 2, 3))
    assert shapes.coarsen_triangles(plain, 0.1) is plain
    fine = shapes.revolve_profile([(np.sin(a), -np.cos(a)) for a in np.linspace(0, np.pi, 120)], 200)
    few = shapes.coarsen_triangles(fine, 0.1)
    assert 200 < len(few) < 0.2 * len(fine)
    np.testing.assert_allclose(np.linalg.norm(few.reshape(-1, 3), axis=1), 1.0, atol=0.1)
    assert volume(few) == pytest.approx(4 / 3 * np.pi, rel=0.1)


def test_the_nearer_triangle_wins_a_pixel():
    colour, depth = np.zeros((4, 4, 3)), np.full((4, 4), -np.inf)
    whole = np.array([[-9.0, -9, 0], [20, -9, 0], [-9, 20, 0]])
    up = np.array([0.0, 0.0, 1.0])
    fill_triangles(colour, depth, np.array([whole + 2 * up, whole + up]), np.array([[1.0, 0, 0], [0, 1.0, 0]]))
    assert (colour == (1, 0, 0)).all()
    np.testing.assert_allclose(depth, 2)


def test_a_cones_rim_is_the_friction_limit():
    edge = friction_cone_rim(np.zeros(3), np.eye(3), 2.0, 0.5, False)
    np.testing.assert_allclose(edge[:, 2], 2.0)
    np.testing.assert_allclose(np.hypot(edge[:, 0], edge[:, 1]), 1.0)
    np.testing.assert_allclose(friction_cone_rim(np.zeros(3), np.eye(3), 2.0, 0.5, True), [[1, 0, 2], [-1, 0, 2]])


def test_contacts_in_one_plane_share_a_slab_below_it():
    top = [Contact((0, 0, 0.04), (0, 0, -1), Coulomb(0.5))]
    feet = [Contact((x, y, 0), (0, 0, 1), Coulomb(0.5)) for x in (-0.02, 0.02) for y in (-0.02, 0.02)]
    wall = Contact((0.02, 0, 0.02), (-1, 0, 0), Coulomb(0.5), name="wall")
    around = Environment([*feet, wall], 1e-5, [0, 0, 0, 0, 1e-3])
    grasp = Grasp(top, (0, 0, -1.0, 0, 0, 0), flexibility=1e-4, preload=1e-3, environment=around)
    table, wall = environment_bodies(grasp)
    size = arrays(grasp).units.length_unit
    corners = table.triangles.reshape(-1, 3)
    assert corners[:, 2].max() == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.ptp(corners[:, :2], axis=0), 0.04 + size)
    assert volume(table.triangles) == pytest.approx((0.04 + size) ** 2 * 0.1 * size), "it winds outwards"
    assert wall.triangles[..., 0].min() == pytest.approx(0.02)
    assert len(stub_bodies(grasp)) == 1, "a rod for the finger alone"
    assert environment_bodies(ring(3)) == []
