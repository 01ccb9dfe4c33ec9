"""Effects meet: every pair of them on four hands, and all at once, against the physics written out in `hand_laws`."""

from __future__ import annotations

from itertools import combinations

import pytest

import handlcp as hl
from tests.hand.composition import EFFECTS, HANDS, made, plain
from tests.support.hand_laws import laws

MISS = 1e-8  # of any law, relative; differences alone leave 1e-12
ALONE = [{"tendons", "synergies"}]  # a hand has one transmission
REFUSED = [{"torque saturation", "geometric stiffness"}, {"soft fingers", "geometric stiffness"}]
YIELDING = {"geometric stiffness"}  # what is left out for those that yield or bear moments
BENDING = {"torque saturation", "soft fingers"}
PAIRS = [pair for pair in combinations(EFFECTS, 2) if set(pair) not in ALONE + REFUSED]


def agrees(asked, faces):
    """The certifier's word, and every law recomputed."""
    s = asked.grasp.solve(faces, throw=False)
    assert s.status is hl.Status.SOLVED, s.trace[-2:]
    assert s.residuals.worst <= 1e-8
    missed = {name: miss for name, miss in laws(asked, s, faces).items() if not miss <= MISS}
    assert not missed
    return s


@pytest.mark.parametrize("name", HANDS)
def test_the_bare_scene_obeys_the_laws_that_the_others_are_held_to(name):
    agrees(made(name), 8)


@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("name", HANDS)
def test_each_effect_alone_obeys_every_law_on_the_cone(name, effect):
    agrees(made(name, [effect]), "cone")


@pytest.mark.parametrize("pair", PAIRS, ids=" + ".join)
@pytest.mark.parametrize("name", HANDS)
def test_every_two_effects_obey_every_law_together(name, pair):
    """Balance of forces and moments, motions term by term, contact, friction, limits, work and energy: in SI."""
    agrees(made(name, pair), "cone" if len("".join(pair)) % 3 == 0 else 8)


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize(
    "without",
    [{"tendons"} | YIELDING, {"synergies"} | YIELDING, {"tendons"} | BENDING, {"synergies"} | BENDING],
    ids=lambda without: " and ".join(sorted(without)),  # the same in every process
)
@pytest.mark.parametrize("name", HANDS)
def test_all_effects_that_go_together_obey_every_law(name, without, faces):
    everything = set(EFFECTS) - without
    agrees(made(name, everything), faces)


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e != "environment"])
def test_an_answer_that_knows_nothing_of_an_effect_misses_a_law_by_far(effect):
    """The checker sees every effect: the bare hand's answer, held to the laws of the scene with it."""
    missed = laws(made("mimic", [effect]), plain("mimic"), 8)
    assert max(missed.values()) > 1e-3


def test_a_checker_told_of_a_stiffer_table_sees_it():
    asked = made("mimic", ["environment"])
    s = asked.grasp.solve(8)
    asked.environment *= 0.99
    assert laws(asked, s, 8)["reported"] > 1e-5


@pytest.mark.parametrize("name", [name for name in HANDS if name != "ring"])
def test_what_cannot_go_together_is_refused(name):
    """Joints that yield have no spring to add to, and moments no potential; in a plane there are no such moments."""
    for pair in REFUSED:
        with pytest.raises(hl.InputError, match="geometric stiffness"):
            made(name, pair)
