"""Colours of an envelope tell causes apart, also for people who lack red or green cones; its page shows the weakest
direction.
"""

import json
import re

import numpy as np
import pytest

import handlcp as hl
from handlcp.viz.envelope.page import choose_view_axes as facing_weakest
from tests.support.show import ENVELOPE_COLOURS, ENVELOPE_GREYS

_TO_XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                    [0.0193339, 0.1191920, 0.9503041]])  # fmt: skip
SEEN = {  # Machado, Oliveira and Fernandes (2009), severity 1
    "everyone": np.eye(3),
    "no green cones": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                                [-0.011820, 0.042940, 0.968881]]),
    "no red cones": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                              [-0.003882, -0.048116, 1.051998]]),
}  # fmt: skip
LEAST = {"everyone": 13.0, "no green cones": 8.0, "no red cones": 8.0}  # a just noticeable difference is 2.3


def lab(colours, seen):
    """(k, 3) CIE 1976 L*, a*, b* of hexadecimal colours."""
    rgb = np.array([[int(c[k : k + 2], 16) / 255 for k in (1, 3, 5)] for c in colours])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    x, y, z = (np.clip(linear @ SEEN[seen].T, 0, 1) @ _TO_XYZ.T / (0.95047, 1.0, 1.08883)).T
    f, g, h = (np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116) for t in (x, y, z))
    return np.stack([116 * g - 16, 500 * (f - g), 200 * (g - h)], axis=1)


@pytest.mark.parametrize("seen", SEEN)
def test_no_two_colours_look_alike(seen):
    every = [c for shades in ENVELOPE_COLOURS.values() for c in shades] + list(ENVELOPE_GREYS)
    points = lab(every, seen)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + 1e3 * np.eye(len(every))
    i, j = np.unravel_index(apart.argmin(), apart.shape)
    assert apart.min() > LEAST[seen], f"{every[i]} and {every[j]}"


def test_kinds_differ_in_hue_and_shades_stay_near_the_hue_of_their_kind():
    mean = {}
    for kind, shades in ENVELOPE_COLOURS.items():
        _, a, b = lab(shades, "everyone").T
        ways = (a + 1j * b) / np.hypot(a, b)
        if np.hypot(a, b).max() > 20.0:  # neither grey nor white
            mean[kind] = np.angle(ways.mean(), deg=True)
            assert abs(np.angle(ways / ways.mean(), deg=True)).max() < 50.0, kind
    kinds = list(mean)
    assert len(kinds) > 3
    for k, one in enumerate(kinds):
        for other in kinds[k + 1 :]:
            assert abs((mean[one] - mean[other] + 180.0) % 360.0 - 180.0) > 25.0, (one, other)


@pytest.mark.parametrize("way", [(1, 0, 0), (0, 0, 1), (0, 0, -1), (-0.6, 0.3, -0.7)])
def test_the_camera_looks_at_the_weakest_direction_upright_and_past_what_is_before_it(way):
    way = np.array(way) / np.linalg.norm(way)
    usual, up = np.array([[0, 1, 0], [-0.5, 0, np.sqrt(0.75)], [np.sqrt(0.75), 0, 0.5]]), np.array([0, 0, 1.0])
    wall = way + 0.4 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1.0]])  # a triangle across the direction
    for solids in (np.zeros((0, 3, 3)), 3.0 * wall[None]):
        axes = facing_weakest(0.5 * way, usual, up, np.zeros(3), solids)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        assert axes[0] @ up == pytest.approx(0.0, abs=1e-12)
        assert axes[2] @ way > 0.5


def test_the_page_opens_with_the_weakest_direction_towards_the_viewer(tmp_path):
    sides = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), 0.5) for s in (-1, 1)]
    env = hl.envelope(hl.Grasp(sides, flexibility=1e-3, preload=2e-3), 42)
    source = env.page(tmp_path / "pinch.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', source, re.S)[1])
    assert np.array(data["view"]["axes"])[2] @ env.weakest.direction > 0.5
    assert len(data["surface"]["row_colours"]) == len(env.causes)
