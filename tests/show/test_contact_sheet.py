"""Small pictures of several grasps in one file."""

from __future__ import annotations

import io

import numpy as np

import handlcp as hl
from tests.support.show import contact_sheet


def test_each_grasp_has_its_picture_and_a_missing_one_none():
    """Five places in a row: the first holds dark and coloured pixels, the second none but those of its name."""
    from matplotlib.image import imread

    hand = hl.example_hand("three_finger", joint_stiffness=5.0)
    found = hl.find_grasp(hand, hl.Sphere(0.03, mass=0.2), tries=24)
    png = contact_sheet([("ball", found[0]), ("box", None)])
    pixels = imread(io.BytesIO(png), format="png")[..., :3]
    high, wide = pixels.shape[:2]
    assert wide == 5 * high
    dark = (pixels < 0.7).any(axis=2)
    first, second = (dark[: high * 3 // 4, k * high : (k + 1) * high] for k in (0, 1))
    assert np.mean(first) > 0.1
    assert not second.any()
