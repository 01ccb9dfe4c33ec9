"""What accuracy costs: errors that mean what they say, budgets that hold, nothing dropped in silence."""

import csv
import math
from itertools import pairwise

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, NoSolutionFound
from handlcp.studies.accuracy import METHODS, AccuracyCost
from handlcp.studies.accuracy.cost import UNDETERMINED
from handlcp.studies.accuracy.result import CERTIFIED, LOOSE, NOT_RUN, OTHER
from handlcp.studies.paper import example
from tests.grasp.scenes import ring
from tests.support import patches
from tests.support.grasp import arrays
from tests.support.study import left_out, planned_rows
from tests.support.texts import says

ENOUGH = 3600.0  # s, a budget that no busy machine spends
SMALL = {"faces": [4, 8], "tolerances": [1e-3, 1e-10], "repeats": 1, "seconds": ENOUGH}


def cost(grasp, **words):
    return hl.accuracy_cost(grasp, **(SMALL | {"left_out": False} | words))


def ball(**words):
    hand = hl.example_hand("five_finger", **({"joint_stiffness": 6.0} | words.pop("hand", {})))
    obj = hl.Sphere(radius=0.035, placement=(0, 0, 0.07), mass=0.3)
    return hand.at(hand.close_on(obj)).grasp(obj, gravity=(0, 0, 9.81), preload=0.003, **words)


def error_between(a, b):
    """Largest difference of a contact's forces over the largest force of b."""
    return np.linalg.norm(a.forces - b.forces, axis=1).max() / np.linalg.norm(b.forces, axis=1).max()


@pytest.fixture(scope="module")
def cube():
    """The paper's Example 3, whose fingers slide."""
    return hl.accuracy_cost(example(3).grasp, **SMALL)


# ---------------------------------------------------------------- errors
def test_newton_on_the_cone_and_the_whole_solve_reach_the_exact_forces(cube):
    for method in ("cone, Newton", "grasp.solve()"):
        exact = [r for r in cube.of(method) if r.section == "exact"]
        assert exact
        assert all(r.status == CERTIFIED and r.force_error < 1e-9 and r.slip_error < 1e-9 for r in exact)


def test_every_method_on_a_pyramid_makes_the_pyramids_error_and_no_other(cube):
    solved = {faces: error for faces, error in cube.pyramids()}
    for method in ("NSNGRK polished", "Newton", "Lemke", "NSNGRK scaled"):
        tight = [r for r in cube.of(method) if r.tolerance in (None, 1e-10) and r.status == CERTIFIED]
        assert len(tight) == 2
        for r in tight:
            assert r.force_error == pytest.approx(solved[r.faces], rel=1e-6)
            assert r.residual < 1e-8


def test_the_error_of_a_row_is_that_of_the_grasp_solved_with_so_many_faces(cube):
    grasp = example(3).grasp
    exact = grasp.solve("cone")
    assert dict(cube.pyramids())[8] == pytest.approx(error_between(grasp.solve(8), exact), rel=1e-9)
    around = grasp.solve(hl.Pyramid(8, inscribed=False))
    assert dict(cube.pyramids("circumscribed"))[8] == pytest.approx(error_between(around, exact), rel=1e-9)


def test_errors_fall_with_the_faces_about_as_one_over_their_number():
    found = cost(example(3).grasp, methods=["grasp.solve()"], faces=None, tolerances=None)
    errors = dict(found.pyramids())
    assert max(errors[m] for m in (64, 96, 128)) < 0.2 * max(errors[m] for m in (4, 6, 8))
    law = found.law()
    assert 0.7 < law.exponent < 2.3
    fitted = [law.factor * m**-law.exponent for m in law.faces]
    assert np.mean(np.log(fitted)) == pytest.approx(np.mean(np.log([errors[m] for m in law.faces])))


def test_as_printed_stops_content_with_forces_and_slips_that_are_wrong(cube):
    printed = cost(example(3).grasp, methods=["NSNGRK as printed"], faces=[8], tolerances=None)
    (paper,) = [r for r in printed.rows if r.tolerance == 1e-5]
    assert paper.status == LOOSE
    assert paper.force_error > 0.01
    assert paper.slip_error > 0.1
    (natural,) = [r for r in cube.of("as printed, scaled") if r.faces == 4 and r.tolerance == 1e-10]
    assert natural.status == CERTIFIED
    assert natural.force_error == pytest.approx(dict(cube.pyramids())[4], rel=1e-6)


def test_a_tighter_tolerance_brings_the_forces_nearer_on_the_cone():
    found = cost(example(3).grasp, methods=["cone, NSNGRK"], tolerances=[1e-2, 1e-4, 1e-6, 1e-8])
    errors = [r.force_error for r in found.rows]
    assert [r.tolerance for r in found.rows] == [1e-2, 1e-4, 1e-6, 1e-8]
    assert all(b < 0.1 * a for a, b in pairwise(errors))
    assert [r.iterations for r in found.rows] == sorted(r.iterations for r in found.rows)


def test_rows_that_reach_another_equilibrium_are_marked_and_not_scored(monkeypatch):
    patches.ticks_of_equilibria(monkeypatch)
    other = []
    for seed in (25, 26):
        contacts, data = ring(np.random.default_rng(seed), 5)
        grasp = hl.Grasp(contacts, **data)
        found = cost(grasp, methods=["grasp.solve()", "NSNGRK polished", "Newton"], faces=[8, 16, 32])
        marked = [r for r in found.rows if r.status == OTHER]
        assert len(found.notes) == bool(marked)
        if marked:
            says(*found.notes, "equilibrium")
        for r in marked:
            assert r.force_error > math.pi / r.faces
            assert r not in found.front(r.method)
        if marked:
            assert len(grasp.equilibria(8)) > 1
        other += marked
    assert other


# ---------------------------------------------------------------- effects left out
def test_a_scene_without_coupling_is_the_hand_built_grasp_without_it():
    contacts, data = ring(np.random.default_rng(1), 4)
    grasp, E = hl.Grasp(contacts, **data), np.array(data["flexibility"])
    exact, n = grasp.solve("cone"), 4
    normal = np.tile([False, False, True], n)
    finger = np.repeat(np.arange(n), 3)
    names = "normal–tangential coupling", "coupling between fingers"
    kept = {name: one[:, None] == one for name, one in zip(names, (normal, finger), strict=True)}
    found = {e.effect: e for e in cost(grasp, methods=["cone, Newton"], left_out=True).left_out}
    for effect, stays in kept.items():
        built = hl.Grasp(contacts, data["wrench"], flexibility=np.where(stays, E, 0.0), preload=data["preload"])
        row = found[effect]
        assert row.status == CERTIFIED
        assert row.force_error > 1e-3
        assert row.force_error == pytest.approx(error_between(built.solve("cone"), exact), rel=1e-6)


def test_a_hand_without_joint_compliance_or_pads_is_the_hand_with_rigid_joints_or_tips():
    grasp, exact = ball(), ball().solve("cone")
    found = {e.effect: e for e in cost(grasp, methods=["cone, Newton"], left_out=True).left_out}
    hard = left_out(grasp)["fingertip pads"]
    assert arrays(hard).flexibility == pytest.approx(arrays(ball(hand={"pad_flexibility": 0.0})).flexibility, abs=1e-12)
    stiff = left_out(grasp)["joint compliance"]
    rigid = ball(hand={"joint_stiffness": np.inf})
    assert arrays(stiff).flexibility == pytest.approx(arrays(rigid).flexibility, abs=1e-12)
    solution, row = stiff.solve("cone"), found["joint compliance"]
    assert row.force_error == pytest.approx(error_between(solution, exact), rel=1e-6)
    off = abs(solution.torques - exact.torques).max() / abs(exact.torques).max()
    assert row.torque_error == pytest.approx(off, rel=1e-6)


def test_leaving_out_the_fingers_weight_changes_torques_alone():
    found = cost(ball(finger_weight="torques"), methods=["cone, Newton"], left_out=True)
    (row,) = [e for e in found.left_out if e.effect == "finger weight"]
    assert row.force_error < 1e-12
    assert row.torque_error > 1e-3


def test_an_effect_without_which_nothing_holds_or_forces_are_free_says_so(cube):
    found = {e.effect: e for e in cube.left_out}
    assert found["friction"].status == "not holdable"
    assert found["friction"].force_error is None
    assert found["finger flexibility"].status == UNDETERMINED
    assert "fingertip pads" not in found, "a grasp without a hand has none"


def test_effects_asked_for_by_name_are_left_out_one_by_one():
    contacts, data = ring(np.random.default_rng(1), 4)
    free = hl.Grasp(contacts, **data)
    bound = 0.9 * float(free.solve("cone").normal_force.sum())
    grasp = hl.Grasp(contacts, **data, effects=[hl.TotalForceBound(bound)])
    found = cost(grasp, methods=["cone, Newton"], left_out=True)
    (row,) = [e for e in found.left_out if e.effect == hl.TotalForceBound.title]
    assert row.force_error == pytest.approx(error_between(free.solve("cone"), grasp.solve("cone")), rel=1e-6)


# ---------------------------------------------------------------- budget, plan, records
def test_what_does_not_fit_the_budget_is_a_row_that_says_so(monkeypatch):
    patches.ticks_of_studies(monkeypatch, 1e-4)
    found = hl.accuracy_cost(example(3).grasp, left_out=False, seconds=0.05, repeats=1)
    faces, tolerances = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128), tuple(10.0**-k for k in range(1, 13))
    assert len(found.rows) == planned_rows(METHODS.values())
    assert {r.faces for r in found.rows} == {None, *faces}
    assert {r.tolerance for r in found.rows} == {None, *tolerances}
    missing = [r for r in found.rows if r.status == NOT_RUN]
    assert missing
    assert all(r.seconds is r.force_error is r.iterations is None and r.runs == 0 for r in missing)
    assert CERTIFIED in {r.status for r in found.rows}
    assert found.conditions.seconds < 2 * 0.05


def test_json_comes_back_as_it_was_and_csv_has_every_row(cube, tmp_path):
    text = cube.to_json()
    assert AccuracyCost.from_json(text) == cube
    with cube.to_csv(tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(cube.rows)
    for line, row in zip(lines, cube.rows, strict=True):
        assert line["method"] == row.method
        assert line["status"] == row.status
        assert (float(line["force_error"]) if line["force_error"] else None) == row.force_error


def test_times_are_quartiles_and_no_setting_is_clearly_better_than_the_front(cube):
    for r in cube.rows:
        if r.seconds is not None:
            assert 0 < r.seconds_low <= r.seconds <= r.seconds_high < math.inf
            assert r.runs >= 1
    for method in cube.methods:
        front = cube.front(method)
        assert all(b.seconds > a.seconds and b.force_error < a.force_error for a, b in pairwise(front))
        for r in cube.of(method):
            if r.comparable:
                near = max(r.force_error, 1e-12)
                assert any(f.seconds <= r.seconds / 0.9 and f.force_error <= near for f in front)


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("methods", {"methods": ["Gauss"]}), ("methods", {"methods": "Lemke"}), ("methods", {"methods": []}),
        ("faces", {"faces": [2]}), ("faces", {"faces": 8}), ("faces", {"faces": ["cone"]}),
        ("tolerances", {"tolerances": [0.0]}), ("tolerances", {"tolerances": [math.nan]}), ("repeats", {"repeats": 0}),
        ("seconds", {"seconds": 0.0}), ("seconds", {"seconds": math.inf}), ("seed", {"seed": -1}),
        ("left_out", {"left_out": 1}), ("progress", {"progress": "bar"}),
    ],
)  # fmt: skip
def test_bad_input_is_refused_by_name(argument, words):
    with pytest.raises(InputError) as caught:
        hl.accuracy_cost(example(3).grasp, **words)
    assert caught.value.argument == argument


def test_a_scene_without_an_answer_has_nothing_to_compare_with():
    with pytest.raises(NoSolutionFound):
        hl.accuracy_cost(example(4).grasp)
