"""The picture of a reliability shows every sample once, and what matters in its order."""

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl


def pinch(load):
    contacts = [hl.Contact((x, 0), (-x, 0), 0.5) for x in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, -load, 0), flexibility=1e-3, preload=5e-3)


@pytest.mark.parametrize(("load", "held"), [(1.0, True), (4.0, None), (300.0, False)])
def test_the_bars_are_all_samples_and_the_values_stand_in_their_order(load, held, tmp_path):
    found = hl.reliability(pinch(load), {"friction": 0.2, "load": 0.1}, 128, workers=1)
    figure = found.plot(title="Two fingers")
    FigureCanvasAgg(figure).draw()
    left, right = figure.axes
    assert sum(bar.get_height() for bar in left.patches) == pytest.approx(100.0)
    words = " ".join(t.get_text() for t in left.texts)
    assert ("not held" in words) == (held is not True)
    assert "over a limit" not in words
    assert str(found.chance_held) in " ".join(t.get_text() for t in figure.texts)
    names = [t.get_text().split("\n")[0] for t in right.get_yticklabels()]
    assert names == ([] if held is False else [f.name for f in found.influences])
    assert found.plot(tmp_path / "sure.png").read_bytes().startswith(b"\x89PNG")


def test_samples_over_a_limit_stand_left_of_zero():
    hand, cube = (
        hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=0.34),
        hl.Box(0.05, (0, 0, 0.08), 0.2),
    )
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)
    found = hl.reliability(grasp, {"squeeze": 0.2}, 64, workers=1)
    left = found.plot().axes[0]
    below = sum(bar.get_height() for bar in left.patches if bar.get_x() + bar.get_width() <= 1e-9)
    assert below == pytest.approx(100 * (found.margin < 0).mean())
    assert below > 10
    assert "over a limit" in " ".join(t.get_text() for t in left.texts)
