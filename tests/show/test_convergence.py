"""The figure of convergence shows the runs it was given, claims what they did, and keeps its words apart."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread
from matplotlib.text import Text

import handlcp as hl
from handlcp.method.convergence import convergence
from handlcp.method.paper import example
from tests.lcp.problems import random_p
from tests.support import patches
from tests.support.show import convergence_figure
from tests.support.texts import says, without_numbers

draw, save = convergence_figure.draw, convergence_figure.save
GIVEN, NATURAL, UNIFORM = convergence_figure.GIVEN, convergence_figure.NATURAL, convergence_figure.UNIFORM


@cache
def found(name):
    if name == "lcp":
        return convergence(hl.LCP(*random_p(np.random.default_rng(0), 6)), seeds=range(2))
    if name == "cut short":
        return convergence(example(3).grasp, 8, seeds=range(2), max_iterations=300)
    return convergence(example(int(name)).grasp, {"3": 8, "5": 6}[name], seeds=range(3))


def lines(ax, colour):
    return [line for line in ax.lines if line.get_color() == colour and line.get_linestyle() == "-"]


@pytest.mark.parametrize("name", ["3", "5", "lcp", "cut short"])
def test_no_text_leaves_the_page_or_covers_another(name):
    c = found(name)
    figure = draw(c, "How NSNGRK converges: a title", ("Table 7", float(c.answer[c.disputed])))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = [*figure.texts]
    for ax in figure.axes:
        left = [t for t in ax.findobj(Text) if t.get_text() == ax.get_title("left") != ""]
        texts += [*ax.texts, ax.xaxis.label, ax.yaxis.label, *left]
        for axis, (low, high) in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
            ticks = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
            texts += [t.label1 for t in ticks if t.label1.get_visible()]
    shown = [(t.get_text(), Text.get_window_extent(t, canvas.get_renderer())) for t in texts if t.get_text()]
    assert len(shown) > 20
    for i, (text, a) in enumerate(shown):
        assert a.x0 >= -1, text
        assert a.x1 <= figure.bbox.x1 + 1, text
        for other, b in shown[i + 1 :]:
            across, along = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
            assert min(across, along) < 3.0, f"{text!r} over {other!r}"


def test_every_run_is_a_line_and_dots_are_where_the_rule_stops():
    c = found("3")
    left, top, bottom = draw(c).axes
    assert [len(lines(left, colour)) for colour in (NATURAL, UNIFORM)] == [3, 3]
    for run, line in zip(c.select(), lines(left, NATURAL), strict=True):
        np.testing.assert_allclose(line.get_ydata(), run.history[:, 1])
    assert len(lines(top, GIVEN)) == 3
    dots = [line for line in bottom.lines if line.get_marker() == "o"]
    for run, dot in zip(c.select("given"), dots, strict=True):
        assert (dot.get_xdata()[0], dot.get_ydata()[0]) == (run.stop, run.stopped[c.disputed])
    low, high = bottom.get_ylim()
    assert low < min(c.answer[c.disputed], *(r.stopped[c.disputed] for r in c.select("given")))
    assert high > max(r.stopped[c.disputed] for r in c.select("given"))


def test_dashed_lines_have_the_slopes_that_conditioning_gives():
    c = found("3")
    left = draw(c).axes[0]
    slopes = []
    for line in left.lines:
        if line.get_linestyle() == "--":
            (x, y), first = line.get_data(), 0
            slopes.append(-np.log(y[-1] / y[first]) / (x[-1] - x[first]) / 1e3)
    np.testing.assert_allclose(slopes, [c.select()[0].bound, 2 * c.select(sampling="uniform")[0].bound])


def test_it_claims_convergence_only_of_runs_that_converged():
    whole, short = draw(found("3")), draw(found("cut short"))
    titles = [f.axes[0].get_title("left") for f in (whole, short)]
    assert titles[0] != titles[1]
    says(titles[0], "converges")
    says(titles[1], "Natural")
    remarks = [{t.get_text() for t in f.axes[0].texts} for f in (whole, short)]
    says(without_numbers("; ".join(sorted(remarks[1] - remarks[0]))), "dashed")
    ends = [{t.get_text() for t in f.axes[2].texts} for f in (whole, short)]
    says(without_numbers("; ".join(sorted(ends[0] - ends[1]))), "natural")


def test_a_picture_is_written_and_shows_something(tmp_path):
    image = imread(save(found("3"), tmp_path / "c.png", "A title"))[..., :3]
    assert image.shape[1] == 1600
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
        assert (abs(image - np.array(colour) / 255).max(-1) < 0.05).sum() > 500
    edge = np.concatenate([image[:4].reshape(-1, 3), image[-4:].reshape(-1, 3), image[:, -4:].reshape(-1, 3)])
    assert edge.min() > 0.98, "nothing runs off the page"
    assert save(found("3"), tmp_path / "c.svg").stat().st_size > 10_000


def test_a_format_or_place_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(hl.InputError, match=r"\.png, \.svg, \.pdf"):
        save(found("3"), tmp_path / "c.doc")
    with pytest.raises(hl.InputError) as wrong:
        save(found("3"), tmp_path / "no" / "c.png")
    says(str(wrong.value).replace(str(tmp_path), "…"), "exists")


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    c = found("3")
    patches.without_module(monkeypatch, "matplotlib")
    with pytest.raises(hl.Unsupported, match="pip install 'matplotlib>="):
        draw(c)
