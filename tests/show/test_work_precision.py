"""The figure of accuracy and cost: written, nothing over anything else, every method told apart."""

from itertools import pairwise

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from handlcp.studies.paper import example
from handlcp.viz.accuracy import figure as work_precision_figure
from tests.show.figures import drawn, extents, words_stand_alone

ENOUGH = 3600.0  # s, a budget that no busy machine spends
draw, save = work_precision_figure.draw, work_precision_figure.save


@pytest.fixture(scope="module")
def cube():
    return hl.accuracy_cost(example(3).grasp, faces=[4, 8], tolerances=[1e-2, 1e-10], repeats=1, seconds=ENOUGH)


@pytest.fixture(scope="module")
def planar():
    return hl.accuracy_cost(example(1).grasp, tolerances=[1e-2, 1e-10], repeats=1, seconds=ENOUGH, left_out=False)


def texts(figure):
    renderer, shown = drawn(figure), list(figure.texts)
    for ax in figure.axes:
        legend = ax.get_legend()
        shown += [*ax.texts, ax.xaxis.label, ax.yaxis.label, *(legend.get_texts() if legend else ())]
        shown += [t for t in ax.get_xticklabels() + ax.get_yticklabels() if t.get_visible()]
    return extents(shown, renderer)


@pytest.mark.parametrize("several", [False, True])
def test_no_text_leaves_the_page_or_covers_another(several, cube, planar):
    figure = draw([("The paper's Example 3", cube), ("Planar", planar)] if several else cube)
    written = texts(figure)
    assert len(written) > 30
    words_stand_alone(written, figure.bbox, 4.0)


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
