"""What scans call a jump: a step that stays when its neighbours come together, with a name where mechanics has one."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.paths.scans import HALVINGS, Limit, find_jumps

AT = np.linspace(0.0, 1.0, 40)
WHERE = 0.37


def limit(factor, kind="slips", lost=None):
    """A limit that one thing ends."""
    bind = SimpleNamespace(kind=kind, who="finger 1")
    return Limit(SimpleNamespace(factor=factor, binds=(bind,), lost=lost, events=()))


def test_a_limit_that_rises_steeply_has_no_jump():
    assert not list(find_jumps(AT, lambda x: limit(1.0 + np.tanh((x - WHERE) / 2e-3))))


@pytest.mark.parametrize(
    ("low", "name"),
    [({}, ""), ({"kind": "torque"}, "finger 1 torque"), ({"kind": "undecided"}, "")],
)
def test_a_jump_is_found_where_it_is_and_named_by_what_ends_the_lower_path(low, name):
    (jump,) = find_jumps(AT, lambda x: limit(1.0 + x, **low) if x < WHERE else limit(2.0 + x))
    assert jump.at <= WHERE <= jump.until
    assert jump.until - jump.at == pytest.approx((AT[1] - AT[0]) / 2**HALVINGS)
    assert jump.name == name


def test_a_path_without_rest_beyond_its_limit_is_lost():
    (jump,) = find_jumps(AT, lambda x: limit(1.0, lost=1.0) if x < WHERE else limit(2.0, lost=2.0))
    assert jump.name == "lost, finger 1 slips"
    (same,) = find_jumps(AT, lambda x: limit(1.0, lost=1.5) if x < WHERE else limit(2.0, lost=2.5))
    assert same.name == ""
    assert "WITHOUT A NAME" in str(same)
