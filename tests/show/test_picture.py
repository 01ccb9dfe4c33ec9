"""Pictures: written, not blank, with everything inside; and the geometry behind them."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from matplotlib.image import imread

from handlcp import Contact, Coulomb, Frictionless, Grasp
from handlcp.errors import InputError, Unsupported
from handlcp.scene import load
from handlcp.viz.picture import body as shapes
from handlcp.viz.picture.camera import camera_against, fill_triangles
from handlcp.viz.picture.figure import draw_solution
from handlcp.viz.picture.overlay import friction_cone_rim, nice_number
from tests.support import patches
from tests.support.show import camera_of, save
from tests.support.texts import says

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def volume(t):
    return float(np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6)


def contacts_only(friction=None, squeeze=3e-3, load=-1.0):
    law = Coulomb(0.5) if friction is None else friction
    angles = np.radians([0, 120, 240])
    contacts = [Contact(0.03 * np.array([np.cos(a), np.sin(a), 0]), (-np.cos(a), -np.sin(a), 0), law) for a in angles]
    return Grasp(contacts, (0, 0, load, 0, 0, 0), flexibility=1e-3, preload=squeeze)


@pytest.mark.parametrize("name", ["cube_three_fingers", "planar_ring", "allegro_pinch"])
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


def test_the_caption_is_the_verdicts_word_and_first_reason():
    grasp = load(EXAMPLES / "cube_three_fingers.toml").build()
    s = grasp.solve()
    checked = grasp.check(faces=8, solution=s)
    for verdict, figure in ((s.verdict, draw_solution(grasp, s)), (checked, draw_solution(grasp, s, verdict=checked))):
        said = " ".join(t.get_text() for t in figure.texts[:3])
        assert said.startswith(f"{verdict.word}: {verdict.reasons[0].sentence}.")
        assert verdict.reasons[1].sentence not in said


def test_a_grasp_without_a_hand_or_an_object_is_drawn_too(tmp_path):
    grasp = contacts_only()
    assert imread(save(grasp, grasp.solve(), tmp_path / "a.png"))[..., :3].std() > 0.05


def test_a_plane_with_an_askew_load_is_seen_along_its_normal_too():
    contacts = [Contact((-0.03, 0), (1, 0), Coulomb(0.5)), Contact((0.03, 0), (-1, 0), Coulomb(0.5))]
    grasp = Grasp(contacts, (0.2, -0.3, 0), flexibility=1e-4, preload=1e-3)
    solution = grasp.solve()
    camera = camera_of(grasp)
    np.testing.assert_array_equal(camera.project(np.eye(3)), [(1, 0), (0, 1), (0, 0)])
    assert len(draw_solution(grasp, solution).axes) > 0


def test_a_grasp_that_does_not_hold_shows_the_way_out(tmp_path):
    grasp = contacts_only(Frictionless())
    s = grasp.solve(throw=False)
    assert not s.held
    image = imread(save(grasp, s, tmp_path / "a.png"))[..., :3]
    orange = abs(image - np.array([0xD5, 0x5E, 0x00]) / 255).max(-1) < 0.04
    assert orange.sum() > 50


@pytest.mark.parametrize("suffix", [".svg", ".pdf"])
def test_other_formats_by_their_suffix(suffix, tmp_path):
    grasp = contacts_only()
    assert save(grasp, grasp.solve(), tmp_path / f"a{suffix}").stat().st_size > 10_000


def test_a_format_or_place_that_cannot_be_written_is_refused(tmp_path):
    grasp = contacts_only()
    s = grasp.solve()
    with pytest.raises(InputError, match=r"\.png, \.svg, \.pdf"):
        save(grasp, s, tmp_path / "a.doc")
    with pytest.raises(InputError) as wrong:
        save(grasp, s, tmp_path / "no" / "a.png")
    says(str(wrong.value).replace(str(tmp_path), "…"), "exists")


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    grasp = contacts_only()
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


def test_the_camera_is_a_rotation_that_keeps_up_up():
    c = camera_against(np.array([1.0, 2, 0.5]), np.array([0.0, 0, 1]))
    np.testing.assert_allclose(c.axes @ c.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(c.axes) == pytest.approx(1)
    up = c.project(np.array([0.0, 0, 1]))
    assert abs(up[0]) < 1e-12 < up[1]


def test_a_cones_rim_is_the_friction_limit():
    edge = friction_cone_rim(np.zeros(3), np.eye(3), 2.0, 0.5, False)
    np.testing.assert_allclose(edge[:, 2], 2.0)
    np.testing.assert_allclose(np.hypot(edge[:, 0], edge[:, 1]), 1.0)
    np.testing.assert_allclose(friction_cone_rim(np.zeros(3), np.eye(3), 2.0, 0.5, True), [[1, 0, 2], [-1, 0, 2]])


@pytest.mark.parametrize(("value", "expected"), [(1.0, 1.0), (1.9, 1.0), (4.9, 2.0), (7.0, 5.0), (0.03, 0.02)])
def test_scales_are_round(value, expected):
    assert nice_number(value) == pytest.approx(expected)
