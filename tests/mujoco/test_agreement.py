"""Two ends agree where they are near: a tolerance of forces, torques and motion, which is printed."""

from dataclasses import replace
from functools import cache

import pytest

pytest.importorskip("mujoco")

from handlcp.simulator import compare
from tests.support import squeezed


@cache
def near():
    return compare(squeezed.cube(), seconds=0.5, steps=8)


def changed(**factors):
    """As if MuJoCo had said so many times what it said."""
    found = near()
    return replace(found, simulation=replace(
        found.simulation, **{name: factor * getattr(found.simulation, name) for name, factor in factors.items()}
    ))  # fmt: skip


def test_what_is_near_agrees_and_says_within_which_tolerance():
    found = near()
    assert found.agree
    for part in ("agree", "forces 5 %", "torques 5 %", "motion 10 %"):
        assert part in str(found).partition("\n")[0]
    assert found.to_dict()["tolerance"] == {"force": 0.05, "torque": 0.05, "motion": 0.1, "least_m": 2e-5}


@pytest.mark.parametrize(
    ("factors", "agree"),
    [
        ({"displacement": 1.35}, False), ({"displacement": 1.05}, True), ({"torques": 1.07}, False),
        ({"torques": 1.03}, True), ({"forces_world": 1.07}, False), ({"forces_world": 1.03}, True),
    ],
)  # fmt: skip
def test_what_is_farther_apart_than_the_tolerance_does_not_agree(factors, agree):
    found = changed(**factors)
    assert found.both_hold
    assert found.agree is agree
    assert str(found).startswith("agree" if agree else "DIFFER")


def test_micrometres_of_an_object_that_hardly_moves_are_no_difference():
    still = changed(displacement=1e-3)
    assert still.motion_error > 10.0
    assert not still.agree
    little = replace(
        near(), simulation=replace(near().simulation, displacement=near().loading.displacement + 1e-5)
    )  # fmt: skip
    assert little.agree


def test_an_object_that_slid_away_is_not_held_whether_mujoco_finds_it_at_rest_or_not():
    slid = squeezed.cube().replace(friction=0.3).follow(steps=8)
    assert slid.reached
    found = replace(near(), loading=slid)
    assert not found.both_hold
    assert not found.agree
    assert found.to_dict()["handlcp"]["held"] is False
    assert "handlcp: NOT HELD: finger_1_tip has slid 1 mm" in " ".join(str(found).split())
