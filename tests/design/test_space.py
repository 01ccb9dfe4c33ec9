"""A space of parameters: what its entries mean, and where its samples lie."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import handlcp as hl
from handlcp.design.space import Space

MIXED = Space(
    {"length": (0.03, 0.06), "fingers": range(2, 5), "stiffness": (0.1, 10.0, "log"), "pad": ["soft", "hard"], "n": 3}
)


def test_a_point_has_plain_values_of_all_names_in_their_order():
    found = MIXED.point([0.5, 0.99, 0.5, 0.0])
    assert list(found) == ["length", "fingers", "stiffness", "pad", "n"]
    assert found == {"length": 0.045, "fingers": 4, "stiffness": pytest.approx(1.0), "pad": "soft", "n": 3}
    assert {type(value) for value in found.values()} == {float, int, str}


def test_the_ends_of_a_range_are_met_exactly():
    space = Space({"a": (0.1, 0.3), "b": (0.1, 0.7, "log")})
    assert space.point([0, 0]) == {"a": 0.1, "b": 0.1}
    assert space.point([1, 1]) == {"a": 0.3, "b": 0.7}


@given(st.lists(st.floats(0, 1), min_size=4, max_size=4))
def test_the_cube_and_the_values_are_the_same_place(u):
    there = MIXED.point(u)
    assert MIXED.point(MIXED.unit(there)) == pytest.approx(there)


def test_a_grid_has_every_combination_once_with_both_ends():
    points = [MIXED.point(u) for u in MIXED.grid({"length": 3, "stiffness": 2})]
    assert len(points) == 3 * 3 * 2 * 2 == len({tuple(p.values()) for p in points})
    assert sorted({p["length"] for p in points}) == pytest.approx([0.03, 0.045, 0.06])
    assert {p["stiffness"] for p in points} == {0.1, 10.0}
    assert [p["pad"] for p in points[:2]] == ["soft", "hard"]  # the last one changes fastest
    assert len(Space({"a": (0, 1), "b": (0, 1)}).grid(4)) == 16


@pytest.mark.parametrize("n", [1, 5, 16, 33])
def test_a_latin_hypercube_has_one_point_in_each_part(n):
    parts = np.floor(MIXED.lhs(n, seed=3) * n).astype(int)
    assert (np.sort(parts, axis=0) == np.arange(n)[:, None]).all()


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ((2.0, 1.0), "a low end below"), ((0.0, 1.0, "log"), "ends above 0"), ((1, 2, 3), "choices are a list"),
        ([], "at least one choice"), ([1, 1], "choices that differ"), ([1, "a"], "all numbers, or all words"),
        ([[1], 2], "a number or a word"),
        ((0.0, np.nan), "finite"), (None, "low, high"),
    ],
)  # fmt: skip
def test_an_entry_that_cannot_be_is_named(entry, said):
    with pytest.raises(hl.InputError, match=r"space\['length'\]") as raised:
        Space({"length": entry})
    assert said in str(raised.value)


def test_levels_and_values_that_cannot_be_are_named():
    with pytest.raises(hl.UnknownName, match="lenght"):
        MIXED.grid({"lenght": 3})
    with pytest.raises(hl.InputError, match="none of stiffness"):
        MIXED.grid({"length": 3})
    with pytest.raises(hl.InputError, match="samples"):
        MIXED.grid(1)
    with pytest.raises(hl.InputError, match=r"values\['pad'\]"):
        MIXED.unit({"length": 0.04, "fingers": 2, "stiffness": 1.0, "pad": "wet"})
    with pytest.raises(hl.InputError, match="coordinates from 0 to 1"):
        MIXED.point([0, 0, 0, 1.1])
