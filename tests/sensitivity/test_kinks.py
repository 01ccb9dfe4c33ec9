"""Where a contact's next state depends on the direction of a change: both sides, against closed forms and solves."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.sensitivity import pair, quantities, three_pairs

PAD, SQUEEZE, MU = 1e-4, 1e-3, 0.25
DOWN = np.array([0, 0, -1.0, 0, 0, 0])


def touched(load):
    """A pinch, and a pad below that just touches."""
    contacts = [*pair(0, 0.8), hl.Contact((0, 0, -1.0), (0, 0, 1), hl.Coulomb(0.5), name="below")]
    return hl.Grasp(contacts, load, flexibility=PAD, preload=[SQUEEZE, SQUEEZE, 0.0])


def three(load):
    """Three pinches that share the load; the first is at the limit of its friction under 15 N."""
    return hl.Grasp(three_pairs(MU), load, flexibility=PAD, preload=SQUEEZE)


def compare(make, load, faces, free):
    """(sensitivity, along) of more load downwards, both sides compared with one-sided differences of solves of a
    piecewise linear answer. free : by quantity, the entries that nothing determines on some side.
    """
    here = make(load).solve(faces)
    before, found = quantities(here), here.sensitivity()
    along = found.along("wrench", DOWN)
    for side, h in ((along.ahead, 1e-3), (along.behind, -1e-3)):
        after = quantities(make(load + h * DOWN).solve(faces, start=here))
        truth = {name: (after[name] - before[name]) / h for name in ("forces", "displacement", "slip", "gap")}
        for name, value in truth.items():
            size = abs(truth["forces" if name == "forces" else "displacement"]).max()
            known = np.isfinite(side[name])
            assert set(np.flatnonzero(~known)) <= set(free.get(name, ())), name
            assert abs(side[name] - value)[known].max() <= 1e-6 * size, name
    return found, along


@pytest.mark.parametrize("faces", ["cone", 8, 4])
def test_a_contact_that_just_touches_pushes_or_opens(faces):
    found, along = compare(touched, np.zeros(6), faces, {"displacement": [3], "slip": [5]})
    assert np.isnan(along.behind["displacement"][3])  # a pinch alone turns about its axis
    assert np.isfinite(along.ahead["displacement"]).all()
    assert [str(k) for k in found.kinks] == ["below touches without force"]
    assert along.ahead["displacement"][2] == pytest.approx(-PAD / 3, rel=1e-9)  # three pads
    assert along.behind["displacement"][2] == pytest.approx(-PAD / 2, rel=1e-9)  # two
    assert along.behind["gap"][2] == pytest.approx(-PAD / 2, rel=1e-9)
    up = found.along("wrench", -DOWN).ahead  # entries are those of a parameter that grows
    assert found.displacement_by_wrench[:, 2] == pytest.approx(up["displacement"], abs=1e-15, nan_ok=True)
    assert found.displacement_by_wrench[2, 2] == pytest.approx(PAD / 2, rel=1e-9)


@pytest.mark.parametrize("faces", ["cone", 8, 4])
def test_a_contact_at_its_limit_slides_or_sticks(faces):
    """Weak fingers bear mu · 10 N each along z, where a face of an inscribed pyramid is cos(π/m) of that away."""
    share = 1.0 if faces == "cone" else np.cos(np.pi / faces)
    found, along = compare(three, 60.0 * MU * share * DOWN, faces, {})
    assert [k.who for k in found.kinks] == ["weak +1.0", "weak -1.0"]
    assert along.ahead["displacement"][2] == pytest.approx(-PAD / 4, rel=1e-7)
    assert along.behind["displacement"][2] == pytest.approx(-PAD / 6, rel=1e-7)


def test_no_answer_on_one_side_is_no_number():
    """A pinch at its limit: more load is not held, less is."""
    solution = hl.Grasp(pair(0, MU), 5.0 * DOWN, flexibility=PAD, preload=SQUEEZE).solve()
    along = solution.sensitivity().along("wrench", DOWN)
    assert np.isnan(along.ahead["displacement"]).all()
    assert along.behind["displacement"][2] == pytest.approx(-PAD / 2, rel=1e-9)


def test_away_from_kinks_both_sides_are_the_same():
    found, way = three((1.0, 0, -3.0, 0, 0, 0)).solve().sensitivity(), np.array([0.3, 0.1, 1.0, 0, 0.2, 0])
    assert found.kinks == ()
    along = found.along("wrench", way)
    for name in along.ahead:
        assert along.ahead[name] == pytest.approx(along.behind[name], rel=1e-9, abs=1e-15, nan_ok=True)
    assert along.ahead["forces"] == pytest.approx(found.forces_by_wrench @ way, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("share", [1.0, 0.9], ids=["at the limit of friction", "within friction"])
def test_moments_that_nothing_determines_are_no_numbers_also_at_the_limit_of_friction(share):
    """Two soft fingers whose pads do not twist: they may turn the object against each other as much as they like."""
    law = hl.SoftFinger(MU, 0.01)
    contacts = [hl.Contact(c.position, c.rotation[:, 2], law, tangent=(0, 0, 1)) for c in pair(0, MU)]
    found = hl.Grasp(contacts, 5.0 * share * DOWN, flexibility=PAD, preload=SQUEEZE).solve().sensitivity()
    assert len(found.kinks) == (2 if share == 1.0 else 0)
    assert found.free
    for parameter in ("squeeze", "friction"):  # more of both sticks
        assert np.isnan(found.of("torsion", parameter)).all()
    lighter = found.along("wrench", -DOWN).ahead
    assert np.isnan(lighter["torsion"]).all()
    assert lighter["forces"][:, 0] == pytest.approx([-0.5, -0.5], rel=1e-6)


# ---------------------------------------------------------------- derivatives by posture and lengths of fingertips
HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
TOUCHING = HAND.close_on(CUBE)
COMMANDS = {
    "squeeze": {"squeeze": 0.005}, "grip force": {"grip_force": 5.0},
    "joint offset": {"joint_offset": HAND.at(TOUCHING).grasp(CUBE, friction=0.8, squeeze=0.005).joint_offset},
}  # fmt: skip
WAYS = {"a joint": np.eye(6)[3], "all joints": np.array([1.0, -3.0, 2.0, 1.0, -1.0, -2.0]) / 3.0}
STEP = 4e-4  # [rad]: overlaps of some micrometres, of which one counts as touching


def solved(q, command, start=None):
    return HAND.at(q).grasp(CUBE, friction=0.8, **COMMANDS[command]).solve(start=start)


def extrapolated(here, q, way, command):
    """Of forces, from two steps, the error of the first order taken out."""
    half, whole = ((solved(q + h * way, command, here).forces - here.forces) / h for h in (STEP / 2, STEP))
    return 2 * half - whole


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("command", COMMANDS)
def test_the_two_sides_of_touching_are_those_of_whole_solves(command, way):
    here = solved(TOUCHING, command)
    both = here.sensitivity().along("posture", way)
    truths = extrapolated(here, TOUCHING, way, command), -extrapolated(here, TOUCHING, -way, command)
    apart = abs(truths[0] - truths[1]).max()
    assert apart > 1e-3 * abs(truths[0]).max()
    for found, truth in zip((both.ahead, both.behind), truths, strict=True):
        assert abs(found["forces"] - truth).max() < 0.02 * apart


def test_fingers_that_just_touch_are_kinks_of_posture_and_lengths_alone():
    found = solved(TOUCHING, "squeeze").sensitivity()
    assert [(k.contact, k.by) for k in found.kinks] == [(i, ("posture", "lengths")) for i in range(3)]
    assert str(found.kinks[0]) == "finger_1_tip just touches where it was detected (by posture and lengths)"
    assert "Two sides" not in str(found)  # the table has no row of these
    for parameter, shape in (("wrench", (6,)), ("stiffness", (6,)), ("positions", (3, 3))):
        both = found.along(parameter, np.ones(shape))
        np.testing.assert_allclose(both.ahead["forces"], both.behind["forces"], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("parameter", ["posture", "lengths"])
def test_entries_by_posture_and_lengths_are_those_that_grow(parameter):
    found = solved(TOUCHING, "squeeze").sensitivity()
    whole = found.of("forces", parameter)
    for index in np.ndindex(whole.shape[2:]):
        way = np.zeros(whole.shape[2:])
        way[index] = 1.0
        ahead = found.along(parameter, way).ahead["forces"]
        np.testing.assert_allclose(whole[(..., *index)], ahead, rtol=1e-9, atol=1e-9)


def test_fingertips_that_are_inside_or_that_leave_a_gap_have_no_kink():
    for deeper in (2e-3, -2e-3):  # rad
        q = TOUCHING + deeper
        here = solved(q, "squeeze")
        found = here.sensitivity()
        assert found.kinks == ()
        way = WAYS["a joint"]
        step = 1e-5  # too small to touch
        truth = (solved(q + step * way, "squeeze", here).forces - solved(q - step * way, "squeeze", here).forces) / 2e-5
        assert abs(found.forces_by_posture @ way - truth).max() < 1e-5 * abs(truth).max()
