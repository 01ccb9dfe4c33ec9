"""Optimisations of which the best is known, what they count as a derivative, and going on with one that was stopped."""

import sys
from functools import cache

import numpy as np
import pytest

import handlcp as hl
from handlcp.design.evaluation import parse_requirement
from handlcp.design.optimise.aims import margin, read_aims
from handlcp.design.optimise.best import slopes_of
from handlcp.design.optimise.slopes import Gradient, places, slope
from handlcp.design.space import Space
from tests.design.optima import SPACE, brief, make, run


def of(function, u):
    """The slope of a function, from samples where they are asked for."""
    return slope(u, function(u), [function(place) for place in places(u)])


# ---------------------------------------------------------------- Derivatives.


@pytest.mark.parametrize("u", [0.0, 0.004, 0.3, 0.9, 0.995, 1.0])
def test_slopes_of_smooth_functions_are_their_derivatives_inside_and_at_the_ends(u):
    found = of(lambda x: np.exp(2.0 * x) / (1.0 + x), u)
    exact = np.exp(2.0 * u) * (1.0 + 2.0 * u) / (1.0 + u) ** 2
    assert found.rate == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("u", [0.3, 0.3 - 2e-3, 0.3 + 7e-3])
def test_a_kink_on_the_spot_or_between_the_samples_is_no_derivative(u):
    assert not of(lambda x: 1.0 + 2.0 * x - abs(x - 0.3), u).sure


def test_away_from_a_kink_there_is_a_derivative_again():
    found = of(lambda x: 1.0 + 2.0 * x - abs(x - 0.3), 0.32)
    assert found.sure
    assert found.rate == pytest.approx(1.0, rel=1e-9)


def test_two_loads_that_give_out_at_once_are_said_to_be_a_kink():
    space = Space({"x": (0.0, 4.0)})
    sure = {"x": of(lambda x: 1.0 + x, 0.5)}
    found = Gradient({"pull": 1.5, "weight": 1.5}, {"pull": sure, "weight": sure})
    alone, none = slopes_of(space, {"x": 2.0}, read_aims("factor")[0], {"pull": 1.5, "weight": 1.7}, found)
    assert alone["x"] == pytest.approx(0.25)
    assert none == ()
    _, kinks = slopes_of(space, {"x": 2.0}, read_aims("factor")[0], {"pull": 1.5, "weight": 1.5}, found)
    assert [kink.says for kink in kinks] == ["factor by x: pull, weight give out at once, and the least counts"]


# ---------------------------------------------------------------- One objective.


@cache
def uphill():
    return run(start={"force": 1.0}, space={"force": (0.5, 2.0)}, budget=22)


def test_the_payload_of_forces_of_another_scale_grows_to_the_end_of_its_range_with_the_slope_of_similarity():
    best = uphill()
    assert best.designs[0]["force"] == pytest.approx(2.0, rel=1e-6)
    there = best.evaluation()
    assert there.holds
    assert best.slopes["force"] == pytest.approx(there.payload / 2.0, rel=1e-4)
    assert best.kinks == ()


def test_the_slope_is_that_of_central_differences_with_other_steps():
    best = uphill()
    near = best.evaluation()
    rates = []
    for h in (3e-3,):
        held = [hl.evaluate(make(2.0 + way * h), brief(2.0 + way * h), near).payload for way in (1, -1)]
        rates.append((held[0] - held[1]) / (2.0 * h))
    np.testing.assert_allclose(rates, best.slopes["force"], rtol=1e-4)


def test_a_design_that_is_given_back_has_its_hand_its_grasps_and_a_table():
    best = uphill()
    assert best.hand(0).nv == 6
    assert best.evaluation(0).cases["object"].candidate.grasp.check().ok
    assert len(best.to_frame()) == len(best) == 1
    assert "for payload" in str(best)
    with pytest.raises(hl.InputError, match="i: expected an integer"):
        best.hand(1)


def test_a_budget_ends_it_and_a_requirement_nobody_meets_leaves_nothing():
    best = run(constraints="payload>=100", budget=3)
    assert len(best) == 0
    assert len(best.study) == 3
    assert best.why == "3 evaluations are spent, and no design meets what was asked"
    with pytest.raises(hl.InputError, match="none did: 3 evaluations are spent"):
        best.hand(0)


def test_where_every_design_fails_the_reason_is_told():
    def fails(force):
        raise SystemExit("no such motor")

    best = run(make=fails, brief=brief(1.0), budget=4)
    assert best.why.endswith("4 of 4 failed, most often: SystemExit: no such motor")


# ---------------------------------------------------------------- Stopped, and gone on with.


@pytest.mark.long
def test_stopped_by_hand_it_gives_what_it_has_and_goes_on_with_the_same_numbers(tmp_path):
    whole, out = run(budget=6), tmp_path / "opt.csv"
    calls = iter(range(9))

    def stopped(force):
        if next(calls) == 3:
            raise KeyboardInterrupt
        return make(force)

    few = run(budget=4, out=out)
    assert few.why.startswith("4 evaluations are")
    more = run(budget=6, out=out)
    assert more.study.columns == whole.study.columns
    table = out.read_bytes()
    assert len(run(budget=4, out=out).study) == len(few.study)
    assert len(hl.Study.load(out)) == len(more.study), "the table keeps what more evaluations found"
    assert out.read_bytes() == table
    assert more.designs == whole.designs
    cut = hl.optimise(stopped, SPACE, brief, budget=6, executor="serial", progress=False)
    assert cut.why == "it was interrupted"
    with pytest.raises(hl.InputError, match="differs in the sampling"):
        run("factor", budget=6, out=out)


# ---------------------------------------------------------------- Several objectives.


def test_of_several_objectives_none_of_the_designs_beats_another():
    pytest.importorskip("pymoo")
    best = run(["payload", "-torque"], budget=5, population=4)
    assert len(best.study) == 5
    rows = [best.study.columns[name] for name in ("payload_kg", "torque_Nm")]
    kept = [(rows[0][k], -rows[1][k]) for k in best.numbers]
    assert not any(a != b and a[0] >= b[0] and a[1] >= b[1] for a in kept for b in kept)
    assert list(best.study.pareto("payload", "-torque").columns["design"]) == list(best.numbers)


def test_without_pymoo_several_objectives_say_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo", None)
    with pytest.raises(hl.Unsupported, match=r"pip install .pymoo"):
        run(["payload", "-torque"])


# ---------------------------------------------------------------- What is asked.


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"objectives": "weight"}, "weight"),
        ({"objectives": []}, "objectives: expected a name"),
        ({"objectives": ["payload", "-payload_kg"]}, "payload twice"),
        ({"constraints": "payload=1"}, "constraints: expected"),
        ({"constraints": "foo>=1"}, "constraints: expected"),
        ({"budget": 0}, "budget: expected"),
        ({"seconds": -1.0}, "seconds: expected"),
        ({"start": {"force": 9.0}}, r"start\['force'\]: expected"),
        ({"start": {"x": 1.0}}, "start: expected"),
        ({"start": 3}, "start: expected"),
    ],
)
def test_what_cannot_be_asked_is_named(given, said):
    with pytest.raises(hl.InputError, match=said):
        run(**given)


def test_margins_are_shares_of_their_limit():
    assert margin(parse_requirement("payload>=2"), 3.0) == pytest.approx(0.5)
    assert margin(parse_requirement("torque<=0.5"), 0.6) == pytest.approx(-0.2)
