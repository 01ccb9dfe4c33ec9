"""The chance that a grasp holds: against closed forms, its interval against the truth, its samples one by one."""

import io

import numpy as np
import pytest
from scipy import stats

import handlcp as hl
from handlcp.studies.reliability.run import make_blocks
from tests.support.study import chance, chance_in_two_looks, steps_of

C, SQUEEZE = 1e-3, 5e-3  # m/N, m: two fingers press with 5 N


def pinch(mu=0.5, load=3.0):
    """Two fingers in a plane, which hold the load if μ N ≥ load / 2."""
    contacts = [hl.Contact((x, 0), (-x, 0), mu, name=name) for x, name in ((-1.0, "left"), (1.0, "right"))]
    return hl.Grasp(contacts, (0, -load, 0), flexibility=C, preload=SQUEEZE)


def lognormal(mean, share):
    """Mean and standard deviation of the logarithm."""
    variance = np.log1p(share**2)
    return np.log(mean) - variance / 2, variance


def chance_that_a_pinch_holds(shares, newtons=3.0, mu=0.5):
    """P(μ k s N ≥ w newtons / 2) for lognormal factors."""
    mean, variance = np.log(SQUEEZE / C) - np.log(newtons / 2), 0.0
    for name, share in shares.items():
        m, v = lognormal(mu if name == "friction" else 1.0, share)
        mean, variance = mean + (-m if name == "load" else m), variance + v
    return stats.norm.cdf(mean / np.sqrt(variance))


# ---------------------------------------------------------------- the estimate
ONE, TWO = {"friction": 0.3}, {"friction": 0.2, "load": 0.3}
FOUR = {"friction": 0.2, "stiffness": 0.2, "load": 0.2, "squeeze": 0.3}


@pytest.mark.parametrize("shares", [ONE, TWO, FOUR], ids=str)
def test_the_chance_that_a_pinch_holds_is_that_of_its_closed_form(shares):
    found = hl.reliability(pinch(), shares, 2000, workers=1)
    truth = chance_that_a_pinch_holds(shares)
    assert found.chance_held.low <= truth <= found.chance_held.high
    assert found.chance_held.value == pytest.approx(truth, abs=0.01)
    assert found.chance_held.high - found.chance_held.low < 0.05
    assert found.chance_within_limits is None  # no motors


def test_a_distribution_is_of_the_coefficient_itself():
    law = stats.truncnorm(-4.0, 4.0, 0.4, 0.08)
    found = hl.reliability(pinch(), {"friction": law}, 512, workers=1)
    assert found.chance_held.value == pytest.approx(law.sf(3.0 / 2 / (SQUEEZE / C)), abs=1e-2)
    assert law.mean() == pytest.approx(found.values.mean(), abs=1e-2)


def test_contacts_named_one_by_one_vary_apart_from_each_other():
    """Unequal shares of the load would turn the object, so both fingers need μ ≥ 0.3: a quarter of the square."""
    law = stats.uniform(0.1, 0.4)
    found = hl.reliability(pinch(), {"friction": {"left": law, "right": law}}, 2000, workers=1)
    assert found.names == ("friction left", "friction right")
    np.testing.assert_array_equal(found.codes == 0, found.values.min(axis=1) * SQUEEZE / C >= 1.5)
    assert found.chance_held.low <= 0.25 <= found.chance_held.high


@pytest.mark.parametrize(("load", "chance_is"), [(0.1, 1.0), (300.0, 0.0)])
def test_what_always_happens_is_certain_up_to_what_so_many_samples_can_tell(load, chance_is):
    found = hl.reliability(pinch(load=load), {"friction": 0.1}, 256, workers=1).chance_held
    assert found.value == chance_is
    assert {found.low, found.high} & {chance_is}
    assert found.high - found.low == pytest.approx(np.log(40) / 256, rel=1e-9)


# ---------------------------------------------------------------- the interval
@pytest.fixture(scope="module")
def runs():
    """200 seeds: blocks and points of 300 samples in three dimensions."""
    every = [make_blocks(seed, 3, 300) for seed in range(200)]
    return [(blocks, blocks.points(0, blocks.samples)) for blocks in every]


ENOUGH = stats.binom(200, 0.95).ppf(0.005)  # 181


def test_the_interval_covers_the_truth_at_its_confidence_over_200_seeds(runs):
    """On the pinch's condition itself, which tests above tie to solved grasps."""
    shares = {"friction": 0.25, "load": 0.15, "squeeze": 0.2}
    laws = [lognormal(0.5 if name == "friction" else 1.0, share) for name, share in shares.items()]
    loads = (1.5, 2.0, 3.0, 4.0, 5.5)
    covers, widths = dict.fromkeys(loads, 0), dict.fromkeys(loads, 0.0)
    for blocks, points in runs:
        mu, w, s = (np.exp(m + np.sqrt(v) * z) for (m, v), z in zip(laws, stats.norm.ppf(points).T, strict=True))
        for load in loads:
            found = chance(mu * s * SQUEEZE / C >= w * load / 2, blocks)
            covers[load] += found.low <= chance_that_a_pinch_holds(shares, load) <= found.high
            widths[load] += (found.high - found.low) / len(runs)
    assert min(covers.values()) >= ENOUGH
    for load, width in widths.items():
        truth = chance_that_a_pinch_holds(shares, load)
        assert width < 2 * 1.96 * np.sqrt(truth * (1 - truth) / 300) + 2 * np.log(40) / 300  # of independent samples


def test_samples_that_stand_for_others_widen_the_interval_and_it_still_covers(runs):
    covers, widths = 0, []
    for blocks, u in runs:
        good, open_ = u[:, 0] < 0.8, (u[:, 0] > 0.7) & (u[:, 1] < 0.5)  # a third of the open ones are good
        all_known, found = chance(good, blocks), chance_in_two_looks(good, open_, 4, blocks)
        covers += found.low <= 0.8 <= found.high
        assert found.high - found.low > all_known.high - all_known.low
        widths.append(found.high - found.low)
    assert covers >= ENOUGH
    assert np.mean(widths) < 0.2


@pytest.mark.parametrize(
    ("chance", "text"),
    [
        ((0.9951, 0.9907, 0.99957), "99.51 % (95 % interval 99.07 to 99.96 %)"),
        ((1.0, 0.99964, 1.0), "100 % (95 % interval 99.964 to 100 %)"),
        ((0.0, 0.0, 0.05), "0 % (95 % interval 0 to 5.0 %)"),
        ((0.9997, 0.95, 1.0), "99.9 % (95 % interval 95.0 to 100 %)"),
        ((0.5, 0.48, 0.53), "50.0 % (95 % interval 48.0 to 53.0 %)"),
    ],
)  # fmt: skip
def test_a_chance_prints_with_the_digits_that_its_interval_is_sure_of(chance, text):
    found = hl.Chance(*chance, 0.95)
    assert str(found) == text
    assert float(found) == chance[0]


# ---------------------------------------------------------------- the same again
def test_the_same_seed_gives_the_same_bits_and_another_does_not():
    one, two, other = (hl.reliability(pinch(), {"friction": 0.3}, 256, seed=s, workers=1) for s in (3, 3, 4))
    assert one.to_dict() == two.to_dict()
    np.testing.assert_array_equal(one.margin, two.margin)
    assert not np.array_equal(one.margin, other.margin)


class Interrupted(Exception):
    """As Ctrl-C."""


def test_a_run_that_was_interrupted_goes_on_and_ends_with_the_same_bits(tmp_path, monkeypatch):
    steps_of(monkeypatch, 100, 0.0)
    file, spread, told = tmp_path / "run.npz", {"friction": 0.3, "load": 0.2}, []

    def stop(done, total):
        told.append((done, total))
        if done >= 300:
            raise Interrupted

    with pytest.raises(Interrupted):
        hl.reliability(pinch(), spread, 1000, progress=stop, resume=file, workers=1)
    assert told[-1] == (300, 1024)
    told.clear()
    resumed = hl.reliability(pinch(), spread, 1000, progress=lambda *now: told.append(now), resume=file, workers=1)
    assert (told[0], told[-1]) == ((300, 1024), (1024, 1024))
    whole = hl.reliability(pinch(), spread, 1000, workers=1)
    assert resumed.to_dict() == whole.to_dict()
    np.testing.assert_array_equal(resumed.margin, whole.margin)
    assert [f.name for f in tmp_path.iterdir()] == ["run.npz"]  # nothing half written is left


def keep_a_run(file):
    """The file of a run that is done."""
    hl.reliability(pinch(), {"friction": 0.3}, 64, resume=file)
    return file


@pytest.mark.parametrize(
    ("load", "friction", "samples", "seed", "what"),
    [(3.1, 0.3, 64, 0, "grasp"), (3, 0.31, 64, 0, "spread"), (3, 0.3, 64, 1, "seed"), (3, 0.3, 128, 0, "samples")],
)
def test_a_file_of_another_question_is_refused_by_name(load, friction, samples, seed, what, tmp_path):
    file = keep_a_run(tmp_path / "run.npz")
    with pytest.raises(hl.InputError, match=rf"resume: .*run\.npz' of another {what}"):
        hl.reliability(pinch(load=load), {"friction": friction}, samples, seed=seed, resume=file)


def one_array():
    """What `np.save` writes."""
    out = io.BytesIO()
    np.save(out, np.zeros(3))
    return out.getvalue()


@pytest.mark.parametrize("content", [b"no run", one_array()], ids=["text", "one array"])
def test_a_file_of_no_run_is_refused_and_stays(content, tmp_path):
    file = tmp_path / "run.npz"
    file.write_bytes(content)
    with pytest.raises(hl.InputError, match=r"resume: expected a file that an earlier run with resume= wrote"):
        hl.reliability(pinch(), {"friction": 0.3}, 64, resume=file)
    assert file.read_bytes() == content


TWICE = {"codes": np.zeros(128, int), "margin": np.ones(128)}
TWICE |= dict.fromkeys(("again", "unplaced", "far"), np.zeros(128, bool))


@pytest.mark.parametrize(
    ("arrays", "fact"),
    [
        ({"codes": np.full(64, 4)}, "codes"), ({"codes": np.zeros(64)}, "codes"),
        ({"codes": np.zeros((64, 1), int)}, "codes"), ({"margin": np.ones(63)}, "margin"),
        ({"margin": np.full(64, "x")}, "margin"), ({"again": np.zeros(64)}, "again"),
        ({"unplaced": np.zeros((2, 32), bool)}, "unplaced"), ({"codes": None}, "codes"),
        ({"codes": np.array(3)}, "codes"), (TWICE, "128 samples that are done of 64"),
    ],
)  # fmt: skip
def test_a_file_made_by_hand_is_refused_by_what_is_wrong(arrays, fact, tmp_path):
    with np.load(keep_a_run(tmp_path / "run.npz")) as found:
        kept = dict(found)
    assert len(kept["codes"]) == 64
    np.savez(tmp_path / "run.npz", **{key: x for key, x in (kept | arrays).items() if x is not None})
    with pytest.raises(hl.InputError, match=rf"resume: .*run\.npz'.*{fact}"):
        hl.reliability(pinch(), {"friction": 0.3}, 64, resume=tmp_path / "run.npz")


# ---------------------------------------------------------------- one sample
def test_the_worst_sample_fails_and_says_why_and_the_nearest_is_just_over_the_edge():
    found = hl.reliability(pinch(), {"friction": 0.3, "load": 0.1}, 512, workers=1)
    worst, near = found.worst, found.nearest_failure
    for sample in (worst, near):
        assert sample.word == "NOT HELD"
        assert not sample.grasp.solve(throw=False).held
        assert sample.grasp.contacts[0].mu == sample.values["friction"]
        assert sample.grasp.spec.wrench[1] == pytest.approx(-3.0 * sample.values["load"])
        assert sample.values["friction"] * SQUEEZE / C < 1.5 * sample.values["load"]
        assert sample.cause
    used = [1.5 * s.values["load"] / (s.values["friction"] * SQUEEZE / C) for s in (worst, near)]
    assert used[0] > used[1] > 1.0
    assert used[1] == pytest.approx(1.0, abs=0.1)


def test_the_margin_is_what_friction_is_left_over():
    found = hl.reliability(pinch(load=1.0), {"friction": 0.1}, 64, workers=1)
    np.testing.assert_allclose(found.margin, 1.0 - 0.5 / (found.values[:, 0] * SQUEEZE / C), rtol=1e-9)


# ---------------------------------------------------------------- what matters
def test_what_matters_most_comes_first_by_samples_and_by_derivatives():
    """Log margin ratio: friction counts twice as much as the load, and squeeze next to nothing."""
    found = hl.reliability(pinch(load=1.0), {"friction": 0.2, "load": 0.1, "squeeze": 0.01}, 4000, workers=1)
    by = {f.name: f for f in found.influences}
    assert [f.name for f in found.influences] == ["friction", "load", "squeeze"]
    assert by["friction"].rank > 0.7
    assert by["load"].rank < -0.3
    assert by["friction"].share == pytest.approx(0.8, abs=0.05)
    assert by["load"].share == pytest.approx(0.2, abs=0.05)
    used = 0.5 / (0.5 * SQUEEZE / C)  # margin = 1 - w load / (2 μ s N), at the means
    assert by["friction"].slope == pytest.approx(0.2 * used, rel=1e-3)
    assert by["load"].slope == pytest.approx(-0.1 * used, rel=1e-6)
    assert by["squeeze"].slope == pytest.approx(0.01 * used, rel=1e-3)
    assert sum(f.linear for f in found.influences) == pytest.approx(1.0)


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("spread", "match"),
    [
        ({}, "at least one parameter"), (0.1, "a mapping of what varies"),
        ({"frictoin": 0.1}, "did you mean 'friction'"),
        ({"friction": -0.1}, r"spread\['friction'\]: expected a finite number > 0"),
        ({"friction": "much"}, "a frozen distribution"), ({"friction": stats.norm}, "a frozen distribution"),
        ({"friction": stats.norm(0.3, 0.1)}, "values of at least 0"),
        ({"friction": stats.cauchy(5.0)}, "with a standard deviation"), ({"friction": {"thumb": 0.1}}, "left"),
        ({"mass": 0.1}, "an object with a mass"), ({"pads": 0.1}, "of a hand"), ({"posture": 0.1}, "of a hand"),
        ({"stiffness": {"joint": 0.1}}, "of a hand"), ({"positions": {"thumb": 0.1}}, "left"),
    ],
)  # fmt: skip
def test_a_spread_that_cannot_be_is_refused_by_name(spread, match):
    with pytest.raises(hl.InputError, match=match):
        hl.reliability(pinch(), spread, 64)


CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.25)
HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
FAR = {"finger_1_tip": 0.02}  # m: the edges are 25 mm from the middle of a face


def held_cube():
    return HAND.at(HAND.close_on(CUBE)).grasp(CUBE, friction=0.7, squeeze=0.005)


@pytest.mark.parametrize(("by", "samples"), [("solve", 128), ("check", 64)])
def test_contacts_past_an_edge_are_undecided_and_say_so_and_nothing_else_is_changed(by, samples):
    sure = hl.reliability(held_cube(), {"friction": 0.1, "positions": FAR}, samples, by=by)
    shift = sure.values[:, [sure.names.index(f"position finger_1_tip {a}") for a in "xy"]]
    grasp = held_cube()
    goal = grasp.spec.positions[0] + shift @ grasp.spec.frames[0][:, :2].T - CUBE.placement.translation
    past = (abs(goal) > 0.025 + 1e-9).any(axis=1)
    assert 0.05 < past.mean() < 0.9
    assert set(sure.why_not) == set(np.flatnonzero(past))
    assert (sure.codes[past] == 3).all()
    assert np.isnan(sure.margin[past]).all()
    if by == "solve":
        assert not (sure.codes[~past] == 3).any()
    lower, upper = (sure.codes < 2).mean(), ((sure.codes < 2) | past).mean()
    assert sure.chance_held.low <= lower + 1e-12
    assert sure.chance_held.high >= upper - 1e-12


def test_a_sample_past_an_edge_is_a_row_with_its_reason():
    sure = hl.reliability(held_cube(), {"positions": FAR}, 64)
    k, why = next(iter(sure.why_not.items()))
    sample, row = sure.sample(k), sure.to_frame().iloc[k]
    assert why == "finger_1_tip would be past an edge of the object, where a contact has no normal"
    assert (sample.word, sample.why_not, sample.cause) == ("UNDECIDED", why, why)
    assert (row["word"], row["why_not"]) == ("UNDECIDED", why)
    assert np.isfinite(sample.grasp.spec.frames).all()
    assert f"{len(sure.why_not)} are no grasp, with a contact past an edge" in " ".join(str(sure).split())
    assert sure.to_dict()["counts"]["UNDECIDED"] == len(sure.why_not)


def test_a_contact_past_the_rim_of_a_cylinder_is_past_an_edge_and_one_around_its_side_is_not():
    can = hl.Cylinder(0.025, 0.05, placement=(0, 0, 0.08), mass=0.25)
    grasp = HAND.at(HAND.close_on(can)).grasp(can, friction=0.7, squeeze=0.005)
    sure = hl.reliability(grasp, {"positions": 0.02}, 128)
    x, y = (sure.values[:, [sure.names.index(f"position finger_{i}_tip {a}") for i in (1, 2, 3)]] for a in "xy")
    frames = grasp.spec.frames
    axial = x * frames[:, 2, 0] + y * frames[:, 2, 1] + grasp.spec.positions[:, 2] - 0.08
    past = (abs(axial) > 0.025 + 1e-9).any(axis=1)
    assert 0 < past.sum() < len(past)
    assert set(sure.why_not) == set(np.flatnonzero(past))


@pytest.mark.parametrize("spread", [{"friction": 1e6}, {"friction": {"left": 1e6}}, {"stiffness": 101.0}])
def test_a_spread_without_a_derivative_is_refused_by_its_own_name(spread):
    with pytest.raises(hl.InputError, match=r"^spread\['[a-z]*'\].*: expected a standard deviation of at most"):
        hl.reliability(pinch(), spread, 64)
