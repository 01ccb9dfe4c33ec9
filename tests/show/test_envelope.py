"""Pictures and pages of envelopes show the factors, in the colours of their causes, within the figure."""

from __future__ import annotations

import json
import re
from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl
from handlcp.errors import InputError
from handlcp.viz.envelope.surface import bound_lines, cut_by_plane, divide_mixed_cells, make_surface
from tests.support import squeezed
from tests.support.browser import opened

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


def test_a_segment_is_divided_in_its_middle():
    parts, kinds, more = divide_mixed_cells(np.array([(0, 1), (1, 2)]), np.array([0, 1, 1]))
    assert sorted(zip(parts.tolist(), kinds.tolist(), strict=True)) == [([0, 3], 0), ([1, 2], 1), ([3, 1], 1)]
    np.testing.assert_array_equal(more, [(0, 1, 0, 1, 0, 1)])


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


def test_the_bounds_lines_are_outside_the_surface_and_within_the_reach():
    s = make_surface(cube())
    lines = bound_lines(s)
    assert len(lines)
    assert np.linalg.norm(lines, axis=2).max() <= 1.001 * s.reach


def test_directions_that_nothing_joins_have_no_picture():
    env = pinch(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    for draw in (env.plot, env.polar):
        with pytest.raises(InputError, match="all around or in a plane"):
            draw()


# ---------------------------------------------------------------- pictures
@pytest.mark.parametrize("make", [cube, pinch], ids=["cube", "pinch"])
@pytest.mark.parametrize("way", ["plot", "polar"])
def test_a_figure_names_every_cause_with_its_colour_and_keeps_its_words_inside(make, way):
    env = make()
    figure = getattr(env, way)(title="How much it holds")
    FigureCanvasAgg(figure).draw()
    said = "\n".join(t.get_text() for t in texts(figure))
    for cause in env.causes:
        assert cause.says[:40].rstrip() in said
    assert f"{env.weakest.factor:.3g} N" in said.replace("\N{NO-BREAK SPACE}", " ")
    for t in texts(figure):
        box = t.get_window_extent()
        assert box.x0 >= -1, t.get_text()
        assert box.x1 <= figure.bbox.width + 1, t.get_text()
        assert box.y0 >= -1, t.get_text()
        assert box.y1 <= figure.bbox.height + 1, t.get_text()


def test_lines_of_the_legend_do_not_cover_each_other():
    figure = cube().plot()
    FigureCanvasAgg(figure).draw()
    boxes = [t.get_window_extent() for t in figure.texts]
    for k, a in enumerate(boxes):
        for b in boxes[k + 1 :]:
            across, along = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
            assert across <= 1 or along <= 1


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


def test_directions_in_a_plane_are_drawn_as_a_polar_diagram(tmp_path):
    file = pinch(("xy", 24)).plot(tmp_path / "plane.png")
    assert file.stat().st_size > 10_000
    with pytest.raises(InputError, match="plot"):
        pinch(("xy", 24)).plot(tmp_path / "plane.txt")


def test_a_grasp_that_holds_nothing_still_has_a_picture():
    loose = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), 0.5)], flexibility=1e-3, preload=1e-3)
    env = hl.envelope(loose, 12)
    assert (env.factors == 0).all()
    assert "does not hold without a load" in " ".join(str(t.get_text()) for t in texts(env.plot()))


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
    source = env.page(tmp_path / "pinch.html").read_text(encoding="utf-8")
    assert 'src="http' not in source
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', source, re.S)[1])
    surface = data["surface"]
    long = np.linalg.norm(surface["points"], axis=1)[: len(env.factors)] / surface["scale"]
    reach = surface["reach"] / surface["scale"]
    np.testing.assert_allclose(long, np.minimum(env.factors, reach), rtol=1e-4)
    assert [surface["causes"][k] for k in surface["cause"]] == [env.causes[k].says for k in env.cause]
    assert surface["held"][int(np.argmax(env.factors))] == "any"


def test_directions_in_a_plane_have_no_page(tmp_path):
    with pytest.raises(InputError, match="all around"):
        pinch(("xy", 24)).page(tmp_path / "plane.html")
