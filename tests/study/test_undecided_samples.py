"""Samples that move farther than one solve can tell anything of: neither held nor not, and the answer says so."""

import numpy as np
import pytest

import handlcp as hl

HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
SPREAD = {"friction": 0.1, "mass": 0.1}


def whole_hand(obj, torque):
    """An object kept in place while all links close on it, over a palm a few millimetres below."""
    return HAND.at(HAND.neutral).grasp(obj, links="all", closing_torque=torque, hold_object=True)


def ball(mass):
    """Where friction is used up at every contact from 1 kg or so on."""
    return whole_hand(hl.Sphere(0.035, (0, 0, 0.04), mass=mass), 0.4)


def cube(mass):
    """Held by three fingertips; the heavier it is the farther it moves."""
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=mass)
    return HAND.replace(pad_flexibility=8e-3).at(HAND.close_on(box)).grasp(box, friction=3.0, squeeze=0.02)


@pytest.mark.parametrize(
    ("grasp", "word"),
    [(ball(0.3), "HELD"), (ball(1.1), "UNDECIDED"),
     (whole_hand(hl.Box((0.03, 0.03, 0.05), placement=(0, 0, 0.034), mass=0.3), 0.3), "UNDECIDED")],
    ids=["light ball", "heavy ball", "box that falls on the palm"],
)  # fmt: skip
def test_an_object_that_nothing_keeps_where_it_was_gripped_is_undecided_by_one_solve(grasp, word):
    solution = grasp.solve()
    assert solution.held
    assert solution.verdict.word == word
    assert bool(solution.verdict.about("large_motion")) == (word == "UNDECIDED")
    if word == "UNDECIDED":
        assert "check() follows it" in solution.verdict.text


def test_a_grasp_whose_samples_move_too_far_has_no_chance_that_it_holds():
    sure = hl.reliability(ball(1.1), SPREAD, 64, workers=1)
    far = sure.outcomes.far
    assert far.all()
    assert (sure.codes == 3).all()
    for chance in (sure.chance_held, sure.chance_within_limits):
        assert chance.low == 0.0
        assert chance.high == 1.0
        assert chance.undecided == pytest.approx(1.0)
    assert sure.worst.word == sure.worst.verdict.word == "UNDECIDED"
    said = " ".join(str(sure).split())
    assert said.startswith("holds, and within torque limits: undecided (95 % interval 0 to 100 %)")
    assert np.isnan(float(sure.chance_held)), "0 would say that it never holds"
    assert sure.to_dict()["chance_held"]["value"] is None
    assert f"{far.sum()} move farther than one solve can tell" in said
    assert 'by="check" follows each sample' in said
    assert "the grasp itself is one of these" in said


@pytest.mark.parametrize("make", [ball, cube], ids=["whole hand", "fingertips"])
def test_samples_as_rows_are_undecided_where_their_own_solutions_are(make):
    counts = {}
    for mass in (0.9, 3.0) if make is ball else (1.0, 4.0):
        sure = hl.reliability(make(mass), {"mass": 0.4, "friction": 0.1}, 64, workers=1)
        for k in range(0, 64, 4):
            word = sure.sample(k).word
            assert word == sure.sample(k).solution.verdict.word
            counts[word] = counts.get(word, 0) + 1
    assert counts["HELD"] > 2
    assert counts["UNDECIDED"] > 2


def test_samples_of_which_some_are_undecided_hold_at_least_so_often_and_the_interval_counts_the_others_as_unknown():
    sure = hl.reliability(cube(1.0), {"mass": 0.4, "friction": 0.1}, 64, workers=1)
    chance, counts = sure.chance_held, sure.counts
    assert 0 < counts["UNDECIDED"] < 64
    assert chance.value == pytest.approx((counts["HELD"] + counts["OVER LIMIT"]) / 64)
    assert chance.high >= chance.value + counts["UNDECIDED"] / 64 - 1e-12
    assert f"at least {100 * chance.value:.1f} %, undecided {100 * counts['UNDECIDED'] / 64:.1f} %" in str(chance)
