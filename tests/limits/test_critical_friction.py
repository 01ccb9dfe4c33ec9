"""A pinched object is held with a thousandth more friction than it needs, and is not with a thousandth less."""

import numpy as np
import pytest

from tests.limits.critical_friction import (
    FINGERS,
    KINDS,
    SHARES,
    bare_contacts,
    example_hand,
    hand_of_sliders,
    law_of,
    least_friction,
    weight_of,
    words_of,
)  # fmt: skip

SOME_FINGERS = [pytest.param(n, marks=pytest.mark.long) if n == 3 else n for n in FINGERS]  # between two and five
FLIPS = ["NOT HELD", "NOT HELD", "NOT HELD", "HELD", "HELD", "HELD"]
DOWN = (0, 0, -1, 0, 0, 0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fingers", SOME_FINGERS)
def test_the_word_flips_at_the_weight_over_the_sum_of_the_normal_forces(fingers, kind):
    assert words_of(fingers, kind) == FLIPS


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fingers", SOME_FINGERS)
def test_the_word_of_a_hand_whose_geometry_is_followed_flips_there_too(tmp_path, fingers, kind):
    assert words_of(fingers, kind, tmp_path) == FLIPS


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fingers", FINGERS)
def test_the_limit_of_bare_contacts_is_the_share_of_the_weight(fingers, kind):
    for share in (SHARES[0], SHARES[-1]):
        grasp = bare_contacts(fingers, kind, share).replace(wrench=np.zeros(6))
        found = grasp.load_limit(DOWN)
        assert found.factor == pytest.approx(share * weight_of(fingers), rel=1e-9)
        assert {bind.kind for bind in found.binds} == {"slips"}


@pytest.mark.parametrize("fingers", FINGERS)
def test_the_limit_of_a_hand_that_is_followed_is_the_share_of_the_weight(tmp_path, fingers):
    grasp = hand_of_sliders(tmp_path, fingers, "soft", SHARES[-1])
    assert grasp.load_limit(DOWN).factor == pytest.approx((SHARES[-1] - 1.0) * weight_of(fingers), rel=2e-3)


# Two hard fingers do not keep a ball from turning about their line
@pytest.mark.parametrize(
    ("fingers", "kind"),
    [
        (2, "soft"),
        (3, "hard"),
        *(pytest.param(*one, marks=pytest.mark.long) for one in ((3, "soft"), (5, "hard"), (5, "soft"))),
    ],
)
def test_an_example_hand_holds_with_the_friction_that_its_fingers_need_where_they_stick(fingers, kind):
    """What sticking fingers need is read off a path on which nothing slides, whatever the friction."""
    needed = least_friction(example_hand(fingers, law_of(kind, 20.0)))
    assert 0.2 < needed < 1.0
    words = [example_hand(fingers, law_of(kind, share * needed)).check().word for share in SHARES]
    assert words == FLIPS
