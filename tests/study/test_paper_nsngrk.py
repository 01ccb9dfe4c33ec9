"""NSNGRK as printed: seeds disagree in newtons and metres, and agree in natural units."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.study import RES, STEPS, run_case

SEEDS = range(5)


@pytest.mark.parametrize(("number", "faces", "least"), [(3, 8, 0.05), (5, 6, 0.05)])
def test_seeds_disagree_unscaled_and_agree_in_natural_units(number: int, faces: int, least: float) -> None:
    case = run_case(number, faces, SEEDS)
    assert all(r.res <= RES and r.steps < STEPS for r in case.printed), "each run met the paper's stop rule"
    assert case.spread > least
    assert case.natural_spread < 1e-6
    for r in case.natural:
        np.testing.assert_allclose(r.normal, case.ours, rtol=1e-6)


def test_table_6_comes_out_in_natural_units() -> None:
    case = run_case(3, 8, range(2))
    for r in case.natural:
        np.testing.assert_allclose(r.normal, [0.934263, 0.934263, 3.96422], rtol=2e-6)


def test_agreement_of_seeds_proves_nothing() -> None:
    case = run_case(2, 16, SEEDS)
    assert case.spread < 1e-5
    assert case.range[1] == pytest.approx(5.4627, abs=1e-4)
    assert case.ours[case.finger] == pytest.approx(5.656)


@pytest.mark.parametrize(("number", "faces"), [(1, 8), (2, 4)])
def test_where_compliance_does_not_matter_the_printed_rule_is_good_enough(number: int, faces: int) -> None:
    case = run_case(number, faces, range(2))
    assert case.off < 1e-5


def test_equal_seeds_give_equal_runs() -> None:
    a, b = (run_case(3, 8, [7]).printed[0] for _ in range(2))
    np.testing.assert_array_equal(a.normal, b.normal)
