"""In every picture of a grasp all words can be read: none leaves the page, or stands over another, an arrow or a
contact; lines from labels do not cross.
"""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.patches import Polygon

from handlcp.viz.picture.figure import draw_solution
from tests.show import figures
from tests.show.figures import extents, over
from tests.show.picture_cases import CASES, case
from tests.support import patches

EASY = {f"paper/{name}" for name in ("hard_finger", "partially_known_forces", "total_bound", "soft_finger")} | {
    "ball_five_fingers",
    "cube_three_fingers",
    "frictionless",
    "pure_torque",
    "bare_hand",
    "eight_on_table",
}

HARD = [name for name in CASES if name not in EASY]


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    patches.coarse_pictures(monkeypatch)


def drawn(name):
    grasp, solution, obj, title = case(name)
    figure = draw_solution(grasp, solution, obj, title)
    return figure, figures.drawn(figure)


def lines_of_labels(ax):
    """(3, 2) in pixels: where each begins, its bend, its contact."""
    found = [line.get_xydata() for line in ax.lines if line.get_zorder() == 5]
    return [ax.transData.transform(points) for points in found if len(points) == 3]


def cross(a, b, c, d):
    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < -1e-6 and side(c, d, a) * side(c, d, b) < -1e-6


@pytest.mark.parametrize("name", HARD)
def test_every_word_can_be_read_and_no_lines_cross(name):
    figure, renderer = drawn(name)
    words_stand_alone(figure, renderer)
    lines_stand_alone(figure.axes[0], renderer)


def words_stand_alone(figure, renderer):
    """On the page, and over nothing."""
    shown = [*figure.texts, *figure.legends[0].get_texts(), *(t for ax in figure.axes for t in ax.texts)]
    written = extents(shown, renderer)
    assert len(written) > 8
    figures.words_stand_alone(written, figure.bbox)
    ax = figure.axes[0]
    arrows = [p.get_transform().transform(p.get_xy()) for p in ax.patches if isinstance(p, Polygon) and p.zorder >= 6]
    points = [ax.transData.transform(line.get_xydata())[0] for line in ax.lines if 7 <= line.get_zorder() < 8]
    assert points
    for words, box in written:
        small = box.padded(-2.0)
        assert not any(small.count_contains(arrow) for arrow in arrows), f"{words!r} over an arrow"
        assert not small.count_contains(points), f"{words!r} over a contact"
    legend, handles = figure.legends[0].get_window_extent(renderer), [box for _, box in written]
    assert not any(over(legend, box) > 3.0 for box in handles[: len(figure.texts)]), "the panel covers the legend"


def lines_stand_alone(ax, renderer):
    """Lines from labels cross neither each other nor labels."""
    lines = lines_of_labels(ax)
    assert lines
    for a, b in combinations(lines, 2):
        same_side = (a[1, 0] - a[0, 0]) * (b[1, 0] - b[0, 0]) > 0
        assert not (same_side and cross(a[1], a[2], b[1], b[2]))
    for words, box in extents(ax.texts, renderer):
        for line in lines:
            along = np.linspace(0.02, 1.0, 60)[:, None]
            way = np.vstack([line[0] + along * (line[1] - line[0]), line[1] + along * (line[2] - line[1])])
            assert not box.padded(-1.0).count_contains(way), f"a line crosses {words!r}"


def test_labels_are_one_for_each_contact_until_there_are_too_many():
    names = [t.get_text() for t in drawn("eight_on_table")[0].axes[0].texts]
    assert {f"table {k}" for k in range(1, 9)} < set(names)
    grouped = [t.get_text() for t in drawn("forty_on_table")[0].axes[0].texts]
    assert "table: 40 contacts" in grouped
    assert not any(name.startswith("table 1") for name in grouped)
    solution = case("forty_on_table")[1]
    forces = solution.normal_force[2:]
    said = next(t for t in grouped if t.endswith("N, stick"))
    low, high = (float(x) for x in said.removesuffix(" N, stick").split(" to "))
    assert low == pytest.approx(forces.min(), rel=5e-3)
    assert high == pytest.approx(forces.max(), rel=5e-3)


def test_a_label_has_the_normal_force_and_the_friction_of_its_contact():
    _, solution, *_ = case("psyonic_grasp")
    written = [t.get_text() for t in drawn("psyonic_grasp")[0].axes[0].texts]
    for name, f, state in zip(solution.names, solution.forces, solution.contact_state, strict=True):
        said = written[written.index(name) + 1]
        numbers, _, verb = said.partition(" N, ")
        normal, friction = (float(x) for x in numbers.split(" + "))
        assert normal == pytest.approx(f[2], rel=5e-3)
        assert friction == pytest.approx(np.hypot(f[0], f[1]), rel=5e-3)
        assert verb == {"sticking": "sticks", "sliding": "slides"}[state]
