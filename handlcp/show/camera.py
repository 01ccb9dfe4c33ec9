"""An orthographic camera: screen axes, a side from which much can be seen, and the frame of the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.show.bodies import Body
from handlcp.show.raster import fill

__all__ = ["Camera", "Frame", "choose", "facing", "frame"]

ELEVATIONS = (16.0, 28.0, -14.0, -26.0)  # [degrees] above the horizon; from below only when that shows more
STEP = 15.0  # of the azimuth [degrees]
SMALL = (96, 80)  # pixels of the sketches that are compared
FAR = 3.8  # a hand that reaches farther from the object than this many sizes of the grasp is cut ...
NEAR = 2.5  # ... at this many


@dataclass(frozen=True, slots=True)
class Camera:
    """axes (3, 3): rows are screen right, screen up and the direction towards the viewer, world axes."""

    axes: Array

    def project(self, points: Array) -> Array:
        """(…, 3) → (…, 2) screen coordinates [m]."""
        return np.asarray(points @ self.axes[:2].T)


@dataclass(frozen=True, slots=True)
class Frame:
    """box (x0, x1, y0, y1): limits of the picture on the screen [m]. inner : the same of the scene without labels.

    inch : metres on the screen that are one inch on paper.
    """

    box: tuple[float, float, float, float]
    inner: tuple[float, float, float, float]
    inch: float


def facing(normal: Array, up: Array) -> Camera:
    """Looking against `normal`, with `up` as near to screen up as it can be."""
    towards = normal / np.linalg.norm(normal)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return Camera(np.array([right, np.cross(towards, right), towards]))


def choose(points: Array, arrows: Array, solids: Sequence[Body], glass: Body | None, up: Array, size: float) -> Camera:
    """The side where points (n, 3) lie apart, arrows (k, 3; unit vectors) keep their length, and the object is seen."""
    first = np.eye(3)[int(np.argmin(np.round(abs(up), 9)))]
    first = first - up * (up @ first)
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    hand = np.concatenate([b.triangles for b in solids]) if solids else np.zeros((0, 3, 3))
    best, camera = -np.inf, None
    for elevation in ELEVATIONS:
        for azimuth in np.arange(0.0, 360.0, STEP) + 5.0:
            a, e = np.radians(azimuth), np.radians(elevation)
            c = facing(np.cos(e) * (np.cos(a) * first + np.sin(a) * second) + np.sin(e) * up, up)
            s = c.project(points)
            apart = np.linalg.norm(s[:, None] - s[None], axis=2)[np.triu_indices(len(s), 1)] / size
            score = float(min(apart.min(initial=1.0), 0.7)) + 0.3 * float(apart.mean()) if len(apart) else 0.0
            length = np.linalg.norm(c.project(arrows), axis=1)
            score += 0.9 * min(float(length.min(initial=1.0)), 0.8) + 0.3 * float(length.mean()) if len(arrows) else 0.0
            if glass is not None:
                score += 0.9 * _visible(c, hand, glass.triangles)
            score -= 0.15 if elevation < 0 else 0.0
            if score > best + 1e-9:
                best, camera = score, c
    assert camera is not None
    return camera


def frame(camera: Camera, solids: Sequence[Body], glass: Body | None, reach: Array, inches: tuple[float, float],
          margin: float) -> Frame:  # fmt: skip
    """Around the object, what reaches (k, 3), and as much of the hand as leaves them large enough.

    inches : (width, height) of the picture on paper. margin : inches at each side for labels.
    """
    core = [camera.project(reach)]
    if glass is not None:
        core.append(camera.project(glass.triangles).reshape(-1, 2))
    inner = np.concatenate(core)
    low, high = inner.min(0), inner.max(0)
    centre, radius = (low + high) / 2, float((high - low).max()) / 2
    if solids:
        rest = np.concatenate([camera.project(b.triangles).reshape(-1, 2) for b in solids])
        far = float(abs(rest - centre).max()) / radius
        if far > FAR:
            rest = rest[(abs(rest - centre) <= NEAR * radius).all(1)]
        low, high = np.vstack([low, rest]).min(0), np.vstack([high, rest]).max(0)
    foot, head = 0.62, 0.12  # inches for scales below, and air above
    inch = max(float(high[0] - low[0]) / (inches[0] - 2 * margin), float(high[1] - low[1]) / (inches[1] - foot - head))
    middle = (low + high) / 2
    x0, x1 = middle[0] - inches[0] / 2 * inch, middle[0] + inches[0] / 2 * inch
    y0 = middle[1] - (inches[1] - foot - head) / 2 * inch - foot * inch
    y1 = y0 + inches[1] * inch
    box = (float(x0), float(x1), float(y0), float(y1))
    return Frame(box, (float(low[0]), float(high[0]), float(low[1]), float(high[1])), inch)


def _visible(camera: Camera, hand: Array, glass: Array) -> float:
    """Share of the object's silhouette that no part of the hand covers."""
    w, h = SMALL
    s = camera.project(glass).reshape(-1, 2)
    low, high = s.min(0), s.max(0)
    scale = min(w / float(high[0] - low[0]), h / float(high[1] - low[1]))

    def page(t: Array) -> Array:
        out = t @ camera.axes.T
        out[..., :2] = (out[..., :2] - low) * scale
        return np.ascontiguousarray(out)

    nothing = np.empty((h, w, 3))
    near, before = np.full((h, w), -np.inf), np.full((h, w), -np.inf)
    fill(nothing, near, page(glass), np.zeros((len(glass), 3)))
    if len(hand):
        fill(nothing, before, page(hand), np.zeros((len(hand), 3)))
    shape = np.isfinite(near)
    return float((shape & (before < near)).sum()) / max(int(shape.sum()), 1)
