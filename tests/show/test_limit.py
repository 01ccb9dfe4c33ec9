"""The figure of a load limit shows its path and says what gives out; a table has a row for each load."""

from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl
from tests.show.figures import panel
from tests.show.picture_cases import ring
from tests.support import squeezed


@cache
def found(name):
    if name in ("hand", "heavy"):
        held = squeezed.cube() if name == "hand" else squeezed.cube().replace(mass=3.0)
        return held.load_limit((1, 0, 0, 0, 0, 0), geometry="fixed")
    if name == "soft":
        return ring(3, hl.SoftFinger(0.5, 0.005, 1.0), None, squeeze=2e-3).load_limit((0, 0, -1, 0, 0, 0.001), faces=8)
    if name == "without limit":
        return ring(2, load=None, squeeze=2e-3).load_limit((1, 0, 0, 0, 0, 0), faces=8)
    return ring(3, load=None, squeeze=2e-3).load_limit((0, 0, 0, 0, 0, 1), faces=8)


def words_of(figure):
    return " ".join(text.get_text() for text in figure.texts)


def curves(ax, count):
    return [
        line
        for line in ax.lines
        if len(line.get_xdata()) == count and np.ptp(line.get_xdata()) > 0.0 and line.get_linewidth() > 1.0
    ]


@pytest.mark.parametrize("name", ["hand", "moment"])
def test_curves_are_those_of_the_path_over_the_size_of_the_load(name):
    limit = found(name)
    figure = limit.plot()
    forces = curves(panel(figure, "Normal force"), len(limit.path.factors))
    assert len(forces) == 3
    for i, line in enumerate(forces):
        np.testing.assert_array_equal(line.get_ydata(), limit.path.forces[:, i, 2])
        np.testing.assert_allclose(line.get_xdata(), limit.path.factors)


def test_where_a_finger_slips_its_friction_is_100_percent():
    limit = found("hand")
    drawn = curves(panel(limit.plot(), "Friction"), len(limit.path.factors))
    assert "slips" in [e.kind for e in limit.events]
    assert max(max(line.get_ydata()) for line in drawn) == pytest.approx(100.0, rel=1e-6)
    assert max(line.get_ydata()[-1] for line in drawn) == pytest.approx(100.0, rel=1e-3)  # between two states


@pytest.mark.parametrize("name", ["hand", "moment", "soft", "without limit"])
def test_every_kind_of_limit_can_be_drawn(name, tmp_path):
    figure = found(name).plot()
    FigureCanvasAgg(figure).draw()
    assert ("NO LIMIT" in words_of(figure)) == (name == "without limit")
    assert found(name).plot(tmp_path / "limit.svg").stat().st_size > 5000


def test_a_grasp_that_does_not_bear_its_weight_has_no_load_to_draw():
    limit = found("heavy")
    assert limit.factor == 0.0
    with pytest.raises(hl.Unsupported, match="no load to draw"):
        limit.plot()
