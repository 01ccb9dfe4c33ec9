"""What one asks of a study: the best, those that none beats, main effects; its picture and its page."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

import handlcp as hl
from handlcp.design.space import Space
from handlcp.design.study import is_pareto_optimal, main_effect


def told(rows, space=None):
    """A study of rows that nobody computed."""
    said = {"space": Space(space or {"x": (0, 1)}).to_dict(), "sampling": "sobol", "samples": len(rows), "seed": 0}
    return hl.Study(said, [{"design": k, "x": k / 10, "error": None, **row} for k, row in enumerate(rows)])


FOUR = told([
    {"payload_kg": 1.0, "torque_Nm": 2.0, "holds": True, "gives_out": "a slips"},
    {"payload_kg": 3.0, "torque_Nm": 3.0, "holds": False, "gives_out": "b slips"},
    {"payload_kg": None, "torque_Nm": 0.1, "holds": False, "gives_out": None},
    {"payload_kg": 0.5, "torque_Nm": 2.5, "holds": True, "gives_out": "a slips"},
])  # fmt: skip


def test_the_best_are_sorted_those_that_hold_first_and_what_is_not_known_is_left_out():
    assert FOUR.best(10).columns["design"] == [0, 3, 1]
    assert FOUR.best(1, by="-torque").columns["design"] == [0], "a hand that drops its object needs no torque"
    assert FOUR.best(10, by="payload", held=True).columns["design"] == [0, 3]


def test_the_front_takes_names_of_columns_and_of_evaluations():
    for by in ((), ("payload", "-torque"), ("payload_kg", "-torque_Nm"), ("payload", "-motor_torque")):
        assert FOUR.pareto(*by, held=False).columns["design"] == [1, 0]
        assert FOUR.pareto(*by).columns["design"] == [0], "of those that hold"
    with pytest.raises(hl.UnknownName, match="payload_kg"):
        FOUR.pareto("paylod_kg")
    with pytest.raises(hl.InputError, match="has words"):
        FOUR.best(by="gives_out")


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)), elements=st.integers(0, 4).map(float)))
def test_a_design_is_on_the_front_exactly_if_none_beats_it(rows):
    beaten = [any((b >= a).all() and (b > a).any() for b in rows) for a in rows]
    assert is_pareto_optimal(rows).tolist() == [not b for b in beaten]


# ---------------------------------------------------------------- Main effects.


def test_first_order_indices_are_those_of_ishigamis_function():
    a, b, n = 7.0, 0.1, 4096
    u = Space({name: (0, 1) for name in "xyz"}).sobol(n, seed=2)
    x, y, z = (np.pi * (2 * u - 1)).T
    f = np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x)
    variance = a**2 / 8 + b * np.pi**4 / 5 + b**2 * np.pi**8 / 18 + 0.5  # Ishigami and Homma, 1990
    exact = np.array([0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8, 0.0]) / variance
    assert np.allclose([main_effect(u[:, k], f).index for k in range(3)], exact, atol=0.02)


def test_an_index_of_chance_alone_is_zero_on_average():
    rng = np.random.default_rng(0)
    found = [main_effect(rng.random(64), rng.random(64)).index for _ in range(400)]
    assert abs(np.mean(found)) < 3 * np.std(found) / np.sqrt(400)


def test_the_means_of_choices_are_those_of_their_designs():
    u, y = np.array([0.25, 0.75] * 20), np.array([1.0, 3.0] * 20)
    found = main_effect(u, y)
    assert found.places.tolist() == [0.25, 0.75]
    assert found.means.tolist() == [1.0, 3.0]
    assert found.index == 1.0
    assert np.isnan(main_effect(u, np.ones(40)).index)


# ---------------------------------------------------------------- To look at.


def test_the_figure_has_the_front_the_lines_and_a_panel_for_each_parameter(tmp_path):
    space = Space({"x": (0, 1), "kind": ["a", "b"], "k": (1, 10, "log")})
    rng, rows = np.random.default_rng(0), []
    for k, u in enumerate(space.sobol(40)):
        payload, torque = rng.random(2).tolist()
        rows.append({**space.point(u), "payload_kg": payload, "torque_Nm": torque, "holds": k % 3 > 0})
    figure = told(rows, space.to_dict()).plot()
    titles = [ax.get_title(loc="left").partition(":")[0] for ax in figure.axes]
    assert titles == ["Designs, and the front", "Designs as lines, the front coloured", "x", "kind", "k"]
    assert told(rows, space.to_dict()).plot(tmp_path / "a.png").stat().st_size > 10_000
    words = [text.get_text() for text in figure.texts]
    assert any("(rough: from 40 designs)" in text for text in words), "shares of so few designs"
    front = told(rows, space.to_dict()).pareto().columns["design"]
    assert [text.get_text() for text in figure.axes[0].texts] == [str(k) for k in sorted(front)]
    lost = told([{**row, "holds": False} for row in rows], space.to_dict()).plot()
    assert lost.axes[0].get_title(loc="left") == "Designs"
    assert any("There is no front" in text.get_text() for text in lost.texts)
    assert not lost.axes[0].texts
    with pytest.raises(hl.InputError, match="two columns"):
        told(rows, space.to_dict()).plot(by=("payload",))


def test_a_study_that_was_loaded_needs_to_know_how_hands_are_made_for_its_page(tmp_path):
    with pytest.raises(hl.InputError, match=r"Study.load\(path, make, brief\)"):
        FOUR.page(tmp_path / "study.html")
