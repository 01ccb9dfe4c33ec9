"""Effects meet: every pair on four hands and all at once, against the physics in `hand_laws`; every call."""

import copy
import pickle
from itertools import combinations

import numpy as np
import pytest

import handlcp as hl
from tests.hand.composition import EFFECTS, HANDS, made, plain
from tests.support.grasp import arrays
from tests.support.hand_laws import laws

MISS = 1e-8  # of any law, relative; differences alone leave 1e-12
ALONE = [{"tendons", "synergies"}]  # a hand has one transmission
REFUSED = [{"torque saturation", "geometric stiffness"}, {"soft fingers", "geometric stiffness"}]
YIELDING = {"geometric stiffness"}  # what is left out for those that yield or bear moments
BENDING = {"torque saturation", "soft fingers"}
PAIRS = [pair for pair in combinations(EFFECTS, 2) if set(pair) not in ALONE + REFUSED]
# Each pair on one hand here, and each hand with a quarter of the pairs; the others when long tests run
ON_HANDS = [
    pytest.param(name, pair, id=f"{name}-{' + '.join(pair)}", marks=pytest.mark.long if (k + j) % len(HANDS) else ())
    for j, name in enumerate(HANDS)
    for k, pair in enumerate(PAIRS)
]


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


@pytest.mark.parametrize(("name", "pair"), ON_HANDS)
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


# ---------------------------------------------------------------- whatever one can do with a grasp, one can do with a
MIXED = {
    "yielding": set(EFFECTS) - {"geometric stiffness", "tendons"},
    "bending": set(EFFECTS) - {"torque saturation", "soft fingers", "synergies", "prescribed force"},
    "patches by a table": {"soft fingers", "environment", "finger weight", "commanded joints"},
    "ellipses by a table": {"anisotropic friction", "environment", "object weight"},
    "a patch whose force is given": {"soft fingers", "prescribed force", "torque saturation"},
}


def close(a, b, miss=1e-7):
    """The same forces; both hold."""
    assert a.held
    assert b.held
    np.testing.assert_allclose(a.forces, b.forces, atol=miss * abs(b.forces).max())
    np.testing.assert_allclose(a.torques, b.torques, atol=miss * abs(b.torques).max())


@pytest.fixture(
    params=[(name, mix) for name in HANDS for mix in MIXED], ids=lambda p: f"{p[0]}, {p[1]}", scope="module"
)
def case(request):
    name, mix = request.param
    asked = made(name, MIXED[mix])
    return asked, asked.grasp, asked.grasp.solve()


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_solve_that_starts_at_the_answer_stays_there(case, faces):
    _, grasp, _ = case
    s = grasp.solve(faces)
    close(grasp.solve(faces, start=s), s)


def test_numbers_replaced_by_themselves_change_nothing(case):
    asked, grasp, s = case
    k = len(grasp.fingertips)
    same = (
        {"wrench": asked.wrench}, {"offset": asked.given["offset"]}, asked.given, {"joint_offset": asked.command},
        {"flexibility": grasp.flexibility[: 3 * k, : 3 * k]},
    )  # fmt: skip
    for numbers in same:
        made_again = grasp.replace(**numbers)
        for part in ("frames", "flexibility", "offset", "wrench"):
            mine, other = getattr(arrays(grasp), part), getattr(arrays(made_again), part)
            said = f"{part} after {list(numbers)}"
            np.testing.assert_allclose(other, mine, atol=1e-12 * abs(mine).max(), err_msg=said)
        close(made_again.solve(), s)


def test_copies_and_what_was_pickled_answer_alike_and_cannot_be_written_to(case):
    _, grasp, s = case
    for other in (pickle.loads(pickle.dumps(grasp)), copy.copy(grasp)):
        np.testing.assert_array_equal(other.solve().forces, s.forces)
        with pytest.raises(ValueError, match="read-only"):
            other.offset[0, 0] = 1.0
        with pytest.raises(ValueError, match="read-only"):
            arrays(other).flexibility[0, 0] = 1.0


def test_every_effect_that_is_on_is_accounted_for(case):
    _, grasp, _ = case
    for faces in (8, "cone"):
        e, problem = grasp.explain(faces), grasp.problem(faces)
        assert e.unknowns == sum(u.count for u in problem.groups) == sum(line.cost for line in e.effects)
        assert e.size == problem.n


def test_readings_of_forces_and_moments_give_the_load_back(case):
    """Sensors at the contacts feel the moments of soft fingers about z."""
    asked, grasp, s = case
    moments = np.zeros((len(s.forces), 3))
    if s.torsion is not None:
        moments[:, 2] = s.torsion
    load = hl.wrench_from_fingertip_forces(grasp, s.forces, moments)
    np.testing.assert_allclose(load, asked.wrench, atol=1e-9 * abs(s.forces).max())


def test_many_at_once_are_what_each_is_alone(case):
    _, grasp, s = case
    for one in hl.solve_many([grasp, grasp], workers=1):
        np.testing.assert_array_equal(one.forces, s.forces)
