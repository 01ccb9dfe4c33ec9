"""A designer's tasks: each takes at most fifteen lines of public names, runs, and gives a number that holds."""

import ast
import pathlib
import runpy
from functools import cache

import numpy as np
import pytest

TASKS = sorted((pathlib.Path(__file__).parents[2] / "examples" / "tasks").glob("*.py"))
G = 9.81


@cache
def ran(name):
    return runpy.run_path(str(next(file for file in TASKS if file.stem == name)))


@pytest.mark.parametrize("file", TASKS, ids=lambda p: p.stem)
def test_a_task_takes_at_most_fifteen_lines_and_no_private_name(file):
    lines = file.read_text(encoding="utf-8").splitlines()
    tree = ast.parse("\n".join(lines))
    imports = [n for n in tree.body if isinstance(n, ast.Import | ast.ImportFrom)]
    own = set(range(tree.body[0].end_lineno + 1, len(lines) + 1)) - {n.lineno for n in imports}
    assert len([k for k in own if lines[k - 1].strip()]) <= 15
    assert {a.name for n in imports for a in n.names if a.name.startswith("handlcp")} == {"handlcp"}
    assert not [n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and n.attr.startswith("_")]


@pytest.mark.long
def test_the_motors_hold_the_bottle_tilted_and_pushed_and_a_weaker_grip_does_not():
    task = ran("motor_torques")
    motors, grasp, brief = task["motors"], task["grasp"], task["brief"]
    assert motors.verdicts == dict.fromkeys(brief, "HELD")
    hand = grasp.state.hand.replace(torque_limits=motors.torque)
    touching = hand.at(grasp.state.q).grasp(grasp.target, friction=0.6, grip_force=motors.grip)
    lifted = touching.replace(mass=2.25)  # 1.5 times as heavy
    assert lifted.check().word == "HELD"
    end = lifted.follow().solution
    assert end.forces_world[:, 2].sum() == pytest.approx(2.25 * G, rel=1e-6)
    # Nothing but friction carries the bottle: the fingers press with at least weight / μ together
    assert end.normal_force.sum() * (1 + 1e-6) >= 2.25 * G / 0.6
    less = {finger: motors.fails * force for finger, force in motors.grip.items()}
    assert motors.lost[0] == "push"
    pushed = lifted.replace(grip_force=less, load=(0, 1.5 * 4.0, 0, 0, 0, 0))
    assert pushed.check().word != "HELD"


def test_friction_to_spare_is_what_a_solve_with_less_friction_has():
    task = ran("what_if_friction_drops")
    less = task["grasp"].replace(friction=0.9 * task["friction"]).solve()
    # All contacts stick, so that forces do not change and the margin is linear in the friction
    assert set(less.contact_state) == {"sticking"}
    assert task["margin"] + task["drop"] == pytest.approx(less.friction_margin, rel=1e-9)
    assert task["drop"] == pytest.approx(-0.08 * task["solution"].normal_force, rel=1e-9)


def test_the_stiffness_and_the_squeeze_keep_the_cube_within_a_millimetre():
    task = ran("stiffness_and_squeeze")
    hand = task["hand"].replace(joint_stiffness=task["stiffness"])
    cube = task["cube"]
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=task["squeeze"])
    loaded = grasp.follow((0, -5.0, 0, 0, 0, 0), steps=80)
    assert loaded.reached
    assert np.linalg.norm(loaded.displacement[:3]) < 1e-3
    assert abs(loaded.solution.torques).max() == pytest.approx(task["torque"], rel=1e-3)


def test_the_least_pull_that_is_too_much_is_where_a_simulation_loses_the_cube():
    """MuJoCo holds it up to 3.28 N along -x, as `tests.mujoco.limit_cases` has the load grow; it slides before."""
    task = ran("how_much_does_it_hold")
    least = task["weakest"]
    assert least.wrench[0] == -1.0
    assert least.lost == pytest.approx(3.28, rel=0.03)
    assert least.factor == least.slides < least.lost
    assert {b.kind for b in least.binds} == {"slides"}


def test_what_the_verdict_advises_holds():
    task = ran("why_it_fails")
    assert (task["verdict"].word, task["better"].word) == ("NOT HELD", "HELD")


def test_an_stl_a_model_and_a_planned_posture_make_a_grasp():
    grasp = ran("own_inputs")["grasp"]
    volume = np.pi * 0.018**2 * (0.06 + 4 / 3 * 0.018)
    assert grasp.target.mass == pytest.approx(1000.0 * volume, rel=0.03)  # of a capsule with flat facets
    assert grasp.check().ok


def test_the_table_has_a_row_for_each_of_500_variants():
    task = ran("variants")
    table = task["table"]
    assert len(table) == 500
    k = 337
    mu, kg, squeeze = task["variants"][k]
    one = task["grasp"].replace(friction=mu, mass=kg, squeeze=squeeze).solve(throw=False)
    assert bool(table.held.iloc[k]) == one.held
    if one.held:
        assert table.utilisation.iloc[k] == pytest.approx(one.torque_check.utilisation.max(), rel=1e-9)
    assert 0 < table.held.sum() < 500


def test_the_audit_of_an_unknown_hand_doubts_its_torque_limits():
    task = ran("audit_a_hand")
    assert set(task["hand"].fingertips) == {f"link_{k}.0_tip" for k in (3, 7, 11, 15)}
    assert "15 N·m" in str(task["audit"])


def test_contacts_given_by_hand_bear_the_moment_in_equal_parts():
    task = ran("contacts_by_hand")
    s = task["solution"]
    np.testing.assert_allclose(s.forces_world[:, 2], 0.5, rtol=1e-9)
    np.testing.assert_allclose(abs(s.torsion), 0.0025, rtol=1e-9)
    assert task["grasp"].required_friction().value == pytest.approx(0.5 * np.sqrt(0.01 + 0.025**2), rel=1e-3)


@pytest.mark.long
def test_the_cube_is_held_where_the_envelope_says_and_lost_beyond():
    task = ran("envelope")
    grasp, mass, pull = task["grasp"], task["mass"], task["pull"]
    weak = mass.weakest
    assert pull.geometry == mass.geometry == "followed"
    for share, holds in ((0.98, True), (1.02, False)):
        turned = grasp.replace(mass=share * weak.factor, gravity=G * weak.direction)
        assert turned.check().ok is holds
        pulled = grasp.replace(load=(*(share * pull.weakest.factor * pull.weakest.direction), 0, 0, 0))
        assert pulled.check().ok is holds
    assert task["page"].stat().st_size > 100_000


def test_the_chance_that_the_cube_is_held_is_less_than_certain_and_friction_decides():
    task = ran("how_sure")
    sure, worst = task["sure"], task["sure"].worst
    assert sure.chance_held.value == pytest.approx(0.995, abs=2e-3)
    assert sure.chance_held.low < sure.chance_held.value < sure.chance_held.high <= 1.0
    assert sure.influences[0].name == "friction"
    assert sure.influences[0].share > 0.7
    assert not worst.grasp.solve(throw=False).held


@pytest.mark.long
def test_the_payload_is_held_and_a_little_more_is_not():
    task = ran("payload")
    rest, moving, grasp = task["rest"], task["moving"], task["grasp"]
    assert rest.mass == pytest.approx(0.182, rel=1e-2)
    assert moving.mass == pytest.approx(rest.mass * G / (G + 5.0), rel=1e-2)  # the worst is against gravity here
    for share, holds in ((0.97, True), (1.03, False)):
        assert grasp.replace(mass=share * rest.mass, gravity=G * rest.direction).check().ok is holds
    assert task["picture"].stat().st_size > 10_000


@pytest.mark.long
def test_the_split_cylinder_measures_what_one_half_presses_on_the_other():
    task = ran("grip_strength")
    pinch = task["pinch"]
    assert pinch.force == pytest.approx(9.99, rel=1e-2)
    assert pinch.word == "HELD"
    assert pinch.solution.torque_check.utilisation.max() == pytest.approx(1.0, abs=1e-6)
    contacts = pinch.around
    half = contacts.forces[contacts.positions @ pinch.normal > 0.0].sum(axis=0)
    assert -half @ pinch.normal == pytest.approx(pinch.force, rel=1e-6)
    assert task["picture"].stat().st_size > 10_000


@pytest.mark.long
def test_published_tests_have_the_numbers_of_levers_and_friction():
    task = ran("published_tests")
    hand, slip, shaken = task["hand"], task["slip"], task["shaken"]
    straight = next(row for row in task["strength"].rows if row.posture == "neutral")
    assert straight.force == pytest.approx(hand.torque_limits[0] / 0.09, rel=1e-6)  # links of 50 and 40 mm
    both = 0.5 * (slip.along.factor + slip.against.factor)  # fingers turn, and press less one way, more the other
    assert both == pytest.approx(3 * 0.6 * 4.0, rel=0.05)
    assert shaken.passed
