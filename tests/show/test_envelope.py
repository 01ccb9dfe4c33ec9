"""Pictures and pages of envelopes show the factors, in the colours of their causes, within the figure."""

import re
from functools import cache
from itertools import combinations

import numpy as np
import pytest

import handlcp as hl
from handlcp.viz.envelope.page import choose_view_axes as facing_weakest
from handlcp.viz.envelope.surface import cut_by_plane, divide_mixed_cells, make_surface
from tests.show.figures import drawn, extents, over, words_stay_on_the_page
from tests.support import squeezed
from tests.support.browser import data_of, opened
from tests.support.show import ENVELOPE_COLOURS, ENVELOPE_GREYS

NASTY = "</script><script>document.documentElement.dataset.pwned=1</script>"
MU, GRIP = 0.5, 2.0


@cache
def pinch(directions=42, **more):
    """Two points along x; pressed along x, nothing ever gives out."""
    sides = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), MU, name=f"finger {2 - (s < 0)}") for s in (-1, 1)]
    return hl.envelope(hl.Grasp(sides, flexibility=1e-3, preload=1e-3 * GRIP), directions, **more)


@cache
def cube():
    return hl.envelope(squeezed.cube(), 42, faces=8, adaptive=1, geometry="fixed")


def texts(figure):
    return [t for t in figure.findobj(lambda a: hasattr(a, "get_text")) if t.get_text() and t.get_visible()]


# ---------------------------------------------------------------- the surface
@pytest.mark.long
def test_every_point_of_the_surface_is_the_factor_along_its_direction():
    for env in (cube(), pinch()):
        s, m = make_surface(env), len(env.factors)
        np.testing.assert_allclose(s.points[:m], env.directions * np.minimum(env.factors, s.reach)[:, None])
        assert s.cut == bool((env.factors > s.reach).any())
        assert np.linalg.norm(s.points, axis=1).max() <= s.reach * (1 + 1e-12)


def test_cells_are_divided_where_causes_differ_into_parts_of_one_cause():
    corners = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    cells = np.array([(0, 1, 2), (1, 3, 2)])
    parts, kinds, more = divide_mixed_cells(cells, np.array([0, 1, 2, 1]))
    points = np.concatenate([corners, corners[more].mean(axis=1)])
    a, b, c = points[parts].transpose(1, 0, 2)
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(1.0)
    shares = [area[kinds == k].sum() for k in range(3)]
    np.testing.assert_allclose(shares, [1 / 6, 1 / 6 + 3 / 8, 1 / 6 + 1 / 8])


def test_a_section_lies_in_its_plane_and_on_the_surface_all_around():
    env = cube()
    s = make_surface(env)
    for normal in (np.array([0.0, 0, 1]), np.array([1.0, 1, 0]) / np.sqrt(2)):
        lines, cells = cut_by_plane(s.factor_points, s.cells, normal)
        assert abs(lines @ normal).max() < 1e-7 * s.reach
        assert len(cells) == len(lines)
        turned = np.cross(lines[:, 0], lines[:, 1]) @ normal
        angle = np.arcsin(turned / np.prod(np.linalg.norm(lines, axis=2), axis=1))
        assert abs(angle).sum() == pytest.approx(2 * np.pi, rel=1e-6)


# ---------------------------------------------------------------- pictures
@pytest.mark.parametrize("make", [cube, pinch], ids=["cube", "pinch"])
@pytest.mark.parametrize("way", ["plot", "polar"])
def test_a_figure_names_every_cause_with_its_colour_and_keeps_its_words_inside(make, way):
    env = make()
    figure = getattr(env, way)(title="How much it holds")
    renderer = drawn(figure)
    said = "\n".join(t.get_text() for t in texts(figure))
    shown = [cause for cause in env.causes if cause.says[:40].rstrip() in said]
    others = re.search(r"(\d+) other causes", said)
    assert len(shown) >= min(6, len(env.causes))
    assert len(shown) + (int(others[1]) if others else 0) == len(env.causes)
    assert f"{env.weakest.factor:.3g} N" in said.replace("\N{NO-BREAK SPACE}", " ")
    words_stay_on_the_page(extents(texts(figure), renderer), figure.bbox)


def test_lines_of_the_legend_do_not_cover_each_other():
    figure = cube().plot()
    for (_, a), (_, b) in combinations(extents(figure.texts, drawn(figure)), 2):
        assert over(a, b) <= 1


def test_polar_diagrams_draw_the_factors_in_three_planes_or_in_the_one_asked_for():
    assert len(cube().polar().axes) == 3
    env = pinch(("yz", 24))
    ax, *others = env.polar().axes
    assert not others
    rim = ax.collections[1]
    points = np.concatenate([path.vertices for path in rim.get_paths()])
    np.testing.assert_allclose(np.hypot(*points.T), 2 * MU * GRIP, rtol=1e-6)
    assert {"+y", "-y", "+z", "-z"} <= {t.get_text() for t in ax.texts}
    assert any(t.get_text().endswith(" N") for t in ax.texts)


# ---------------------------------------------------------------- pages
def test_a_browser_draws_the_surface_around_the_object_with_its_causes(tmp_path):
    env = cube()
    page = env.page(tmp_path / "cube.html", title=NASTY)
    seen = opened(page, tmp_path)
    assert "error" not in seen.told
    assert "pwned" not in seen.told
    assert int(seen.told["colours"]) > 30
    assert seen.hidden("notice")
    for cause in env.causes:
        assert cause.says in seen.words["causes"]
    assert f"{env.weakest.factor:.3g} N" in seen.words["labels"]
    assert "weakest" in seen.words["labels"]


def test_a_page_holds_the_surface_and_asks_no_network(tmp_path):
    env = pinch()
    page = env.page(tmp_path / "pinch.html")
    assert 'src="http' not in page.read_text(encoding="utf-8")
    surface = data_of(page)["surface"]
    long = np.linalg.norm(surface["points"], axis=1)[: len(env.factors)] / surface["scale"]
    reach = surface["reach"] / surface["scale"]
    np.testing.assert_allclose(long, np.minimum(env.factors, reach), rtol=1e-4)
    assert [surface["causes"][k] for k in surface["cause"]] == [env.causes[k].says for k in env.cause]
    assert surface["held"][int(np.argmax(env.factors))] == "any"


# ---------------------------------------------------------------- Colours of an envelope tell causes apart, also for

_TO_XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                    [0.0193339, 0.1191920, 0.9503041]])  # fmt: skip
SEEN = {  # Machado, Oliveira and Fernandes (2009), severity 1
    "everyone": np.eye(3),
    "no green cones": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                                [-0.011820, 0.042940, 0.968881]]),
    "no red cones": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                              [-0.003882, -0.048116, 1.051998]]),
}  # fmt: skip
LEAST = {"everyone": 13.0, "no green cones": 8.0, "no red cones": 8.0}  # a just noticeable difference is 2.3


def lab(colours, seen):
    """(k, 3) CIE 1976 L*, a*, b* of hexadecimal colours."""
    rgb = np.array([[int(c[k : k + 2], 16) / 255 for k in (1, 3, 5)] for c in colours])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    x, y, z = (np.clip(linear @ SEEN[seen].T, 0, 1) @ _TO_XYZ.T / (0.95047, 1.0, 1.08883)).T
    f, g, h = (np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116) for t in (x, y, z))
    return np.stack([116 * g - 16, 500 * (f - g), 200 * (g - h)], axis=1)


@pytest.mark.parametrize("seen", SEEN)
def test_no_two_colours_look_alike(seen):
    every = [c for shades in ENVELOPE_COLOURS.values() for c in shades] + list(ENVELOPE_GREYS)
    points = lab(every, seen)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + 1e3 * np.eye(len(every))
    i, j = np.unravel_index(apart.argmin(), apart.shape)
    assert apart.min() > LEAST[seen], f"{every[i]} and {every[j]}"


def test_kinds_differ_in_hue_and_shades_stay_near_the_hue_of_their_kind():
    mean = {}
    for kind, shades in ENVELOPE_COLOURS.items():
        _, a, b = lab(shades, "everyone").T
        ways = (a + 1j * b) / np.hypot(a, b)
        if np.hypot(a, b).max() > 20.0:  # neither grey nor white
            mean[kind] = np.angle(ways.mean(), deg=True)
            assert abs(np.angle(ways / ways.mean(), deg=True)).max() < 50.0, kind
    kinds = list(mean)
    assert len(kinds) > 3
    for one, other in combinations(kinds, 2):
        assert abs((mean[one] - mean[other] + 180.0) % 360.0 - 180.0) > 25.0, (one, other)


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1), (0, 0, -1), (-0.6, 0.3, -0.7)])
def test_the_camera_looks_at_the_weakest_direction_upright_and_past_what_is_before_it(way):
    way = np.array(way) / np.linalg.norm(way)
    usual, up = np.array([[0, 1, 0], [-0.5, 0, np.sqrt(0.75)], [np.sqrt(0.75), 0, 0.5]]), np.array([0, 0, 1.0])
    wall = way + 0.4 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1.0]])  # a triangle across the direction
    for solids in (np.zeros((0, 3, 3)), 3.0 * wall[None]):
        axes = facing_weakest(0.5 * way, usual, up, np.zeros(3), solids)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        assert axes[0] @ up == pytest.approx(0.0, abs=1e-12)
        assert axes[2] @ way > 0.5
