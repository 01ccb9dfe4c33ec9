"""`explain()` lists all that a loading counts of joints, motors and tendons, and which answers count it."""

from __future__ import annotations

import pytest

import handlcp as hl

CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
FOLLOWED = "followed loadings alone"
ARMS = {f"cable_{k}": {f"finger_{k}_proximal": 0.012, f"finger_{k}_distal": 0.008} for k in (1, 2, 3)}


def grasp(**more):
    hand = hl.example_hand("three_finger", **({"joint_stiffness": 6.0} | more))
    return hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, squeeze=0.009)


def lines(g):
    return {line.title: line for line in g.explain().effects if line.on}


RUBBING = {
    "joint friction": {"joint_friction": 0.04},
    "motor friction": {"motors": hl.Motor(0.012, 0.04, reduction=50, friction=0.04)},
    "tendon friction": {"joint_stiffness": hl.Tendons(ARMS, 2e4, 4.0, friction=0.3)},
}


@pytest.mark.parametrize("title", RUBBING)
def test_friction_that_loadings_count_and_a_solve_does_not_is_listed_so(title):
    rubs = grasp(**RUBBING[title])
    found = lines(rubs)[title]
    assert found.answers == FOLLOWED
    said = " ".join(str(rubs.explain()).split())
    assert f"on {title}: " in said
    assert "check, follow, load_limit" in said
    plain = grasp(joint_stiffness=hl.Tendons(ARMS, 2e4, 4.0)) if "tendon" in title else grasp()
    assert title not in lines(plain)
    one, other = (g.solve().forces for g in (rubs, plain))
    assert abs(one - other).max() < 1e-9 * abs(other).max(), "one solve does not count it"
    ends = [g.follow(order="squeeze", steps=8).steps.forces[-1] for g in (rubs, plain)]
    assert abs(ends[0] - ends[1]).max() > 0.02 * abs(ends[1]).max(), "a loading does"


def test_springs_and_slack_of_tendons_are_listed():
    found = lines(grasp(joint_stiffness=hl.Tendons(ARMS, 2e4, 4.0, pretension=3.0)))
    assert "4 N·m/rad" in found["springs at joints"].why
    assert found["springs at joints"].answers == ""
    assert found["tendons that pull alone"].answers == FOLLOWED


def test_an_effect_of_one_solve_alone_is_listed_so():
    bent = grasp().replace(effects=[hl.GeometricStiffness()])
    assert lines(bent)["geometric stiffness"].answers == "one solve alone"
    assert all(line.answers == "" for line in grasp().explain().effects if line.on)
    assert grasp().explain().notes == ()
