"""The figure of accuracy and cost: written, nothing over anything else, every method told apart."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

import handlcp as hl
from handlcp.errors import InputError
from handlcp.studies.paper import example
from handlcp.viz.accuracy import figure as work_precision_figure

ENOUGH = 3600.0  # s, a budget that no busy machine spends
draw, save = work_precision_figure.draw, work_precision_figure.save


@pytest.fixture(scope="module")
def cube():
    return hl.accuracy_cost(example(3).grasp, faces=[4, 8], tolerances=[1e-2, 1e-10], repeats=1, seconds=ENOUGH)


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


def test_bad_input_is_refused(cube, tmp_path):
    for costs in (None, [], [cube], "cube", [("a", 1)]):
        with pytest.raises(InputError, match="costs"):
            draw(costs)
    for path in ("out.doc", tmp_path / "nowhere" / "out.png"):
        with pytest.raises(InputError, match="plot"):
            save(cube, path)
