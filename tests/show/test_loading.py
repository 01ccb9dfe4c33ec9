"""The figure of a loading shows the steps it was given, its words do not cover each other, and its events are told in
short; the picture of the end shows the hand and the object where they end.
"""

import dataclasses
from functools import cache

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text

import handlcp as hl
from handlcp.geometry import Sphere
from handlcp.hand import example_hand
from handlcp.viz.loading.curves import grasp_at_end, solution_at_end
from handlcp.viz.loading.figure import draw_end_picture as loading_picture, draw_loading as loading_figure
from tests.show.figures import drawn, extents, panel, words_stand_alone
from tests.show.picture_cases import LONG, on_table, ring
from tests.support import patches
from tests.support.show import events_in_short

MU = 0.6


def ball(load=0.0, stiffness=6.0, **more):
    """A ball that five fingers hold from above; +z is down."""
    hand = example_hand("five_finger", joint_stiffness=stiffness, **more)
    obj = Sphere(0.035, placement=(0.0, 0.0, 0.07), mass=0.3)
    state = hand.at(hand.close_on(obj))
    wrench = (0.0, 0.0, load, 0.0, 0.0, 0.0)
    return state.grasp(obj, friction=hl.Coulomb(MU), wrench=wrench, gravity=(0, 0, 9.81), squeeze=0.002)


def three_points(names=("thumb", "index", "a finger with a very long name")):
    """Contacts without a hand, pulled aside, so that each does something else."""
    return ring(3, load=(0.8, 0.3, -0.5, 0, 0, 0), names=names, squeeze=2e-3)


@cache
def found(name):
    if name == "ball":
        return ball().follow(steps=8)
    if name == "lost":
        return ball(20.0, 1.0).follow(steps=8)
    if name == "without limits":
        return ball(0.0, torque_limits=np.inf).follow(steps=4)
    if name == "long names":
        return three_points(LONG).follow(steps=8)
    if name == "table":
        return on_table(8).follow(steps=4)
    if name == "many stages":
        path = [(0.3 * k, 0, -0.2 * k, 0, 0, 0) for k in (1, -1, 1, -1)]
        return three_points().follow(load=path, steps=4)
    return three_points().follow(steps=8)


def curves(ax):
    """(y) of the curves, which are all lines with as many points as there are steps."""
    most = max(len(line.get_xdata()) for line in ax.lines)
    return [line for line in ax.lines if len(line.get_xdata()) == most]


@pytest.mark.parametrize("name", ["ball", "lost", "points"])
def test_numbers_drawn_are_those_of_the_steps(name):
    h = found(name)
    figure = loading_figure(h)
    forces = curves(panel(figure, "Normal force"))
    assert len(forces) == h.steps.forces.shape[1]
    for i, line in enumerate(forces):
        np.testing.assert_array_equal(line.get_ydata(), h.steps.forces[:, i, 2])
        np.testing.assert_allclose(line.get_xdata(), h.steps.stage + h.steps.share)
    motion = panel(figure, "Motion")
    unit = {"[mm]": 1e3, "[µm]": 1e6}[motion.get_title("left").split()[-1]]
    assert len(curves(motion)) == 3
    for j, line in enumerate(curves(motion)):
        np.testing.assert_allclose(line.get_ydata(), unit * h.steps.displacement[:, j])


def test_friction_is_drawn_as_a_share_of_its_limit_and_sliding_is_100_percent():
    h = found("lost")
    pushed = np.hypot(*h.steps.forces[..., :2].transpose(2, 0, 1)) / (MU * np.maximum(h.steps.forces[..., 2], 1e-12))
    shown = np.array([line.get_ydata() for line in curves(panel(loading_figure(h), "Friction"))]).T
    known = np.isfinite(shown)
    assert known.sum() > 0.9 * known.size
    np.testing.assert_allclose(shown[known], 100 * pushed[known], rtol=1e-6)
    slides = np.array([[kind == "sliding" for kind in kinds] for kinds in h.steps.contact_state])
    assert slides.any()
    np.testing.assert_allclose(shown[slides & known], 100.0, rtol=1e-6)


def test_where_it_is_lost_is_marked_and_said():
    h = found("lost")
    assert not h.reached
    figure = loading_figure(h, "A title")
    at = h.stages.index(h.lost_stage) + h.lost_at
    for ax in figure.axes:
        assert any(line.get_linewidth() > 1.7 and set(line.get_xdata()) == {at} for line in ax.lines)
        assert ax.get_xlim() == (0.0, len(h.stages)), "the load that is not reached is shown"
    said = [t.get_text() for t in figure.texts]
    assert "NOT HELD:" in said
    assert "lost" in [t.get_text() for t in figure.axes[0].texts]
    assert "HELD:" in [t.get_text() for t in loading_figure(found("ball")).texts]


def written(figure):
    """(text, box in pixels) of everything that is written."""
    renderer, texts = drawn(figure), [*figure.texts]
    for ax in figure.axes:
        texts += [*ax.texts, *(t for t in ax.findobj(Text) if t.get_text() == ax.get_title("left") != "")]
        for line, (low, high) in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
            ticks = [t for t in line.get_major_ticks() if low <= t.get_loc() <= high]
            texts += [t.label1 for t in ticks if t.label1.get_visible()]
    return extents(texts, renderer)


@pytest.mark.parametrize("name", ["ball", "lost", "points", "many stages", "crowded", "long names", "table"])
def test_no_text_leaves_the_page_or_covers_another(name):
    h = found("points" if name == "crowded" else name)
    if name == "crowded":
        kinds = ("slips", "sticks", "opens", "touches")
        more = [hl.grasp.Event(kinds[k % 4], "thumb", "load", 0.2 + 0.031 * k, 1) for k in range(20)]
        h = dataclasses.replace(h, events=tuple(more))
    title = "A ball that five fingers hold: a title"
    figure = loading_figure(h, 9 * f"{title} " if name == "long names" else title)
    shown = written(figure)
    assert len(shown) > 20
    words_stand_alone(shown, figure.bbox)


# ---------------------------------------------------------------- the end
def test_the_grasp_of_the_end_is_where_hand_and_object_end():
    h = found("lost")
    grasp, solution = grasp_at_end(h), solution_at_end(h)
    assert np.linalg.norm(h.state.q - ball().state.q) > 1e-2, "the joints have been pushed back"
    np.testing.assert_allclose(grasp.state.q, h.state.q, atol=1e-3)
    np.testing.assert_allclose(grasp.scene.positions, h.steps.positions[-1])
    np.testing.assert_allclose(solution.forces, h.steps.forces[-1], atol=1e-6)
    centre = h.object.placement.translation
    assert np.linalg.norm(h.displacement[:3]) > 3e-3
    np.testing.assert_allclose(centre - [0.0, 0.0, 0.07], h.displacement[:3], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(grasp.scene.positions - centre, axis=1), 0.035, atol=1e-4)


def test_slips_at_the_end_are_those_of_the_whole_way():
    h = found("lost")
    slipped = np.hypot(*solution_at_end(h).slip.T)
    way = np.hypot(*h.steps.slip.transpose(2, 0, 1)).sum(axis=0)
    assert (slipped > 3e-3).all()
    assert (slipped <= way * (1 + 1e-9)).all()
    np.testing.assert_allclose(slipped, way, rtol=0.05)  # they slip one way, along what turns a little


def test_files_are_written_or_refused(tmp_path, monkeypatch):
    h = found("points")
    image = imread(h.plot(tmp_path / "a.png"))[..., :3]
    assert image.shape[1] == 1600
    edge = np.concatenate([image[:4].reshape(-1, 3), image[-4:].reshape(-1, 3), image[:, -4:].reshape(-1, 3)])
    assert edge.min() > 0.98, "nothing runs off the page"
    assert h.plot(tmp_path / "a.svg").stat().st_size > 10_000
    with pytest.raises(hl.InputError, match=r"\.png, \.svg, \.pdf"):
        h.plot(tmp_path / "a.doc")
    patches.without_module(monkeypatch, "matplotlib")
    for draw in (loading_figure, loading_picture):
        with pytest.raises(hl.Unsupported, match="pip install 'matplotlib>="):
            draw(h)


# ---------------------------------------------------------------- words
def events(*told):
    return [hl.grasp.Event(kind, who, stage, share, int(stage == "load")) for kind, who, stage, share in told]


SLIPS = [("slips", "index", "load", 0.4), ("slips", "thumb", "load", 0.405)]
BY_TURNS = [(("slips", "sticks")[k % 2], "thumb", "load", 0.4 + 0.01 * k) for k in range(7)]
APART = [("slips", "thumb", "squeeze", 1.0), ("slips", "index", "load", 0.001)]


@pytest.mark.parametrize(
    ("told", "short"),
    [
        (SLIPS, ["load, 40 %: thumb and index begin to slip"]),
        (APART, ["squeeze, end: thumb begins to slip", "load, start: index begins to slip"]),
        (BY_TURNS, ["load, 40 % to 46 %: thumb slips and sticks by turns"]),
        ([("lost", "because", "load", 0.4)], []),
    ],
)
def test_several_fingers_at_one_place_are_one_sentence(told, short):
    assert events_in_short(events(*told), three_points()) == short
