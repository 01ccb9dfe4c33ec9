"""The figure of accuracy and cost: written, nothing over anything else, every method told apart."""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread
from matplotlib.text import Text
from rich.console import Console

import handlcp as hl
from handlcp.errors import InputError, Unsupported
from handlcp.studies.accuracy import METHODS, Row
from handlcp.studies.accuracy.result import NOT_RUN
from handlcp.studies.paper import example
from handlcp.viz.accuracy import all_tables, figure as work_precision_figure
from tests.support import patches
from tests.support.texts import says

ENOUGH = 3600.0  # s, a budget that no busy machine spends
draw, save, STYLE = work_precision_figure.draw, work_precision_figure.save, work_precision_figure.STYLE


@pytest.fixture(scope="module")
def cube():
    return hl.accuracy_cost(
        example(3).grasp, faces=[4, 8, 16], tolerances=[1e-2, 1e-5, 1e-10], repeats=1, seconds=ENOUGH
    )


@pytest.fixture(scope="module")
def planar():
    return hl.accuracy_cost(example(1).grasp, tolerances=[1e-2, 1e-10], repeats=1, seconds=ENOUGH, left_out=False)


def texts(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    shown = list(figure.texts)
    for ax in figure.axes:
        legend = ax.get_legend()
        shown += [*ax.texts, ax.xaxis.label, ax.yaxis.label, *(legend.get_texts() if legend else ())]
        shown += [t for t in ax.get_xticklabels() + ax.get_yticklabels() if t.get_visible()]
    return [(t, Text.get_window_extent(t, renderer)) for t in shown if t.get_text()], figure.bbox


@pytest.mark.parametrize("several", [False, True])
def test_no_text_leaves_the_page_or_covers_another(several, cube, planar):
    figure = draw([("The paper's Example 3", cube), ("Planar", planar)] if several else cube)
    boxes, page = texts(figure)
    assert len(boxes) > 30
    for text, box in boxes:
        assert box.x0 >= page.x0 - 1, text
        assert box.x1 <= page.x1 + 1, text
        assert box.y0 >= page.y0 - 1, text
        assert box.y1 <= page.y1 + 1, text
    for i, (a, box) in enumerate(boxes):
        for b, other in boxes[i + 1 :]:
            across = min(box.x1, other.x1) - max(box.x0, other.x0)
            along = min(box.y1, other.y1) - max(box.y0, other.y0)
            assert min(across, along) < 4.0, f"{a.get_text()!r} over {b.get_text()!r}"


def test_the_legend_of_the_faces_covers_no_curve(cube):
    figure = draw(cube)
    figure.canvas.draw()
    faces = next(ax for ax in figure.axes if "faces" in ax.get_title("left"))
    box = faces.get_legend().get_window_extent()
    curves = [line for line in faces.lines if len(line.get_xdata())]
    assert len(curves) > 1
    for line in curves:
        points = faces.transData.transform(line.get_xydata())
        along = [a + s * (b - a) for a, b in pairwise(points) for s in np.linspace(0, 1, 40)]
        assert not box.count_contains(np.array([*points, *along])), line.get_label()


def test_no_text_is_too_small_to_read(cube):
    boxes, _ = texts(draw(cube))
    assert min(t.get_fontsize() for t, _ in boxes) >= 9.0


def test_every_method_is_named_once_beside_its_own_line(cube):
    figure = draw(cube)
    words = [t.get_text() for t in figure.axes[0].texts]
    for method in cube.methods:
        assert words.count(method) == 1
    assert "µs" in "".join(t.get_text() for t in figure.axes[0].get_xticklabels())


def test_scenes_without_pyramids_or_effects_left_out_have_no_panel_for_them(cube, planar):
    titles = [[ax.get_title(loc="left") for ax in draw(c).axes] for c in (cube, planar, replace(cube, left_out=()))]
    time, faces, _ = titles[0]
    assert titles[1:] == [[time], [time, faces]]
    says("; ".join(titles[0]), "against")


def test_methods_differ_in_marker_and_colour():
    assert set(STYLE) == set(METHODS)
    assert len(set(STYLE.values())) == len({m for _, m in STYLE.values()}) == len({c for c, _ in STYLE.values()})


def test_a_file_is_written_and_not_blank(cube, tmp_path):
    image = imread(save(("Example 3", cube), tmp_path / "out.png"))[..., :3]
    assert image[200:].std() > 0.08
    border = np.concatenate([image[:6].reshape(-1, 3), image[-6:].reshape(-1, 3), image[:, -4:].reshape(-1, 3)])
    assert border.min() > 0.98


def test_a_study_in_which_nothing_ran_is_drawn_and_says_so(cube):
    nothing = tuple(Row(r.method, r.section, r.faces, r.tolerance, NOT_RUN) for r in cube.rows)
    figure = draw(replace(cube, rows=nothing, left_out=()))
    (said,) = {t.get_text() for t in figure.axes[0].texts} - {t.get_text() for t in draw(cube).axes[0].texts}
    says(said, "nothing")


def test_bad_input_is_refused(cube, tmp_path):
    for costs in (None, [], [cube], "cube", [("a", 1)]):
        with pytest.raises(InputError, match="costs"):
            draw(costs)
    for path in ("out.doc", tmp_path / "nowhere" / "out.png"):
        with pytest.raises(InputError, match="plot"):
            save(cube, path)


def test_without_matplotlib_the_message_says_what_to_install(cube, monkeypatch):
    patches.without_module(monkeypatch, "matplotlib")
    with pytest.raises(Unsupported, match=r"pip install .matplotlib"):
        draw(cube)


@pytest.mark.parametrize("width", [80, 100])
def test_tables_fit_the_terminal_with_every_number_whole(cube, planar, width):
    for study in (cube, planar):
        console = Console(width=width, file=io.StringIO(), no_color=True)
        for table in all_tables(study):
            console.print(table)
        text = console.file.getvalue()
        assert max(map(len, text.splitlines())) <= width
        assert "…" not in text
        for method in study.methods:
            assert f" {method} " in text
