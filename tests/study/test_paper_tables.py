"""Tables 1 to 10: the golden ones to every printed digit, the others with what their numbers miss."""

from __future__ import annotations

import numpy as np
import pytest

from handlcp.method.paper import compare, example, table
from tests.support.study import NUMBERS, Mark, Miss, compatibility, mark_of, signed_forces
from tests.support.texts import says


def misses(number: int, equation: str) -> list[Miss]:
    evidence = compare(number).evidence
    assert evidence is not None
    return [m for m in evidence.misses if m.equation.startswith(equation)]


@pytest.mark.parametrize("number", [1, 3, 6])
def test_golden_tables_to_every_printed_digit(number: int) -> None:
    c = compare(number)
    assert c.golden
    assert {r.mark for r in c.golden_rows} == {Mark.DIGITS}
    says(c.verdict, "reproduced to every printed digit")


@pytest.mark.parametrize(("number", "last", "residue"), [(2, 2, 6), (8, 5, 0)])
def test_golden_tables_of_a_loose_stop_rule_to_one_unit_of_the_last_digit(number: int, last: int, residue: int) -> None:
    c = compare(number)
    assert c.ok
    marks = [r.mark for r in c.golden_rows]
    assert (marks.count(Mark.LAST), marks.count(Mark.RESIDUE)) == (last, residue)


@pytest.mark.parametrize("number", [k for k in NUMBERS if table(k).golden])
def test_golden_fails_when_a_force_is_off(number: int) -> None:
    c = compare(number)
    row = max((r for r in c.golden_rows if r.column == "force"), key=lambda r: r.printed.value)
    assert not mark_of(row.printed, row.ours * (1 + 1e-5), row.printed.value).fits


@pytest.mark.parametrize("number", [4, 5, 7, 9, 10])
def test_the_others_are_not_solutions_and_say_so(number: int) -> None:
    c = compare(number)
    assert c.level == "not a solution"
    says(c.verdict, "not a solution", "misses")
    assert c.solution.held
    assert c.solution.residuals.worst < 1e-8


@pytest.mark.parametrize("number", range(3, 11))
def test_ours_satisfies_every_equation_that_printed_numbers_are_held_to(number: int) -> None:
    c = compare(number)
    if number != 9:  # ours is preloaded there
        miss, size = compatibility(c.example.grasp, table(number).faces or 0, c.solution.forces)
        assert miss <= 1e-9 * size


def test_table_4_misses_balance_and_friction() -> None:
    assert misses(4, "balance")[0].amount == pytest.approx(0.296, rel=1e-2)
    assert misses(4, "friction")[0].amount == pytest.approx(1.50224 - 0.3 * np.cos(np.pi / 4) * 5.88661, abs=1e-6)


def test_table_5_prints_the_friction_limit_where_the_fingers_stick() -> None:
    c = compare(5)
    assert c.solution.contact_state[1:] == ("sticking", "sticking")
    np.testing.assert_allclose(abs(c.solution.forces[1:, [2, 1]]), [[5.656, 1.414]] * 2, rtol=1e-9)
    (friction,), (elastic,) = misses(5, "friction"), misses(5, "elastic")
    assert friction.comment == "on a face"
    assert elastic.share == pytest.approx(0.075, rel=0.01)


@pytest.mark.parametrize(("number", "share"), [(7, 0.017), (9, 0.391), (10, 0.317)])
def test_elastic_compatibility_is_missed(number: int, share: float) -> None:
    stated, alternative = misses(number, "elastic")
    assert stated.share == pytest.approx(share, rel=0.01)
    assert alternative.share is not None
    assert alternative.share > 0.05, "nor with the E_T that the printed slips fit"


def test_table_9_balances_once_its_overwritten_forces_are_recovered() -> None:
    printed, recovered = misses(9, "balance")
    assert printed.amount > 1
    assert recovered.holds
    forces = signed_forces(example(4).grasp, table(9))
    assert [(i, k) for i, k, _ in forces.recovered] == [(0, 0), (0, 1), (1, 0)]
    np.testing.assert_allclose([abs(x) for *_, x in forces.recovered], [0.36114, 1.25, 0.41667], rtol=1e-4)


def test_table_10_balances_only_with_its_exponent_corrected_and_leaves_the_pyramid() -> None:
    printed, read = misses(10, "balance")
    assert printed.amount > 1
    assert read.amount < 1e-5
    assert misses(10, "friction")[0].amount == pytest.approx(0.0494, rel=1e-2)


@pytest.mark.parametrize("number", range(3, 11))
def test_no_printed_displacement_keeps_touching_fingers_in_touch(number: int) -> None:
    (slip,), (contact,) = misses(number, "printed slip"), misses(number, "unilateral")
    assert slip.holds, "signs and E_T were found that give the printed slips"
    assert not contact.holds
    assert contact.amount > 0.5e-6


@pytest.mark.parametrize(("number", "fits"), [(3, 6e-6), (5, 6e-6), *((k, 1.5e-6) for k in range(6, 11))])
def test_which_tangential_flexibility_the_printed_slips_fit(number: int, fits: float) -> None:
    evidence = compare(number).evidence
    assert evidence is not None
    assert evidence.fits == fits


@pytest.mark.parametrize("faces", [8, 16])
def test_golden_forces_of_example_3_do_not_depend_on_the_tangential_flexibility(faces: int) -> None:
    a, b = (example(3, tangential=E).grasp.solve(faces).forces for E in (6e-6, 1.5e-6))
    np.testing.assert_allclose(a, b, atol=1e-9)


@pytest.mark.parametrize("number", [6, 8])
def test_the_object_of_example_3_is_loose_and_the_printed_motion_is_no_member(number: int) -> None:
    c = compare(number)
    assert c.solution.uniqueness is not None
    assert c.solution.uniqueness.loose_motions == 1
    assert c.solution.uniqueness.forces_determined
    assert {r.place for r in c.rows if r.mark is Mark.LOOSE} == {"1 o", "2 o", "u_x", "u_y", "φ_z"}
    assert {"φ_x", "φ_y"} <= {r.place for r in c.rows if r.mark is Mark.NO}
