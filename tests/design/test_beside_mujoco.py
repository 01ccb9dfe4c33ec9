"""The motors that a brief takes, in MuJoCo: with the answer the object stays, with less grip it slips, and falls."""

import pytest

pytest.importorskip("mujoco")

from handlcp.simulator import compare, simulate_limit
from tests.design.hands import cube_grasp
from tests.design.optima import run
from tests.examples.test_examples import script

SAFETY = 1.5


@pytest.mark.long
def test_a_simulated_hand_holds_the_cube_with_these_motors_and_loses_it_with_less_grip():
    grasp = cube_grasp()
    r = grasp.required_torque(safety=SAFETY)
    heavy = grasp.replace(mass=SAFETY * grasp.target.mass)
    safe = {name: 1.03 * force for name, force in r.grip.items()}  # a thousandth less than the grip itself is lost
    held = compare(heavy.replace(grip_force=safe), steps=8, seconds=1.0)
    assert held.simulation.held
    assert (abs(held.simulation.torques) <= 1.04 * r.torque).all()
    assert held.torque_error < 0.01
    share = 0.75
    less = {name: share * force for name, force in r.grip.items()}
    lost = compare(heavy.replace(grip_force=less), steps=8)
    assert not lost.simulation.held
    record = lost.simulation.record
    reached = max(x for x, stage in zip(record.shares, record.stages, strict=True) if stage == "load")
    assert reached == pytest.approx(share, rel=0.03)  # what this grip carries; then it slides through


@pytest.mark.long
def test_an_optimised_hand_holds_a_third_more_with_the_same_motors_and_mujoco_loses_it_where_it_says():
    before, best = script("optimise_hand").main()
    grasp = best.evaluation().cases["ball"].candidate.grasp
    held = grasp.payload()
    assert held.mass == pytest.approx(best.evaluation().payload, rel=1e-5)
    assert held.mass > 1.3 * before.payload
    found = simulate_limit(grasp.replace(mass=0.0), held.worst.limit.wrench, 1.1 * held.mass)
    assert 0.95 * held.mass < found.factor < 1.1 * held.mass


@pytest.mark.long
def test_an_optimisation_gives_back_what_mujoco_holds_where_that_is_asked_for():
    best = run(budget=6, mujoco=True)
    grasp = best.evaluation().cases["object"].candidate.grasp
    assert compare(grasp).simulation.held
