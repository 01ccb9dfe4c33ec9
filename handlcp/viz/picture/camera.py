"""`Camera`: an orthographic camera: the direction from which a grasp is seen, and the limits of the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp
from handlcp.grasp.model.contact import contact_frame as frame_about
from handlcp.hand import HandGrasp
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.lcp.kernels.dense import kernel
from handlcp.viz.picture.body import Body, coarsen_triangles

# ----------------------------------------------------------------
# The depth buffer behind the pictures, in one compiled loop.


def blank_image(h: int, w: int) -> Array:
    """(h, w, 3) white, in single precision: half the memory, and no difference that 256 shades could show."""
    return np.ones((h, w, 3), dtype=np.float32)


@compile_now()  # a picture has a million pixels
def fill_triangles(colour: Array, depth: Array, triangles: Array, rgb: Array) -> None:
    """Draw triangles (m, 3, 3) with their colours rgb (m, 3) into the buffers colour (h, w, 3) and depth (h, w).

    Corners are in pixels; z grows towards the viewer. A pixel belongs to the nearest triangle over its centre.
    """
    _fill_buffers(colour, depth, triangles, rgb)


def compile_fill() -> None:
    """Draw nothing, so that the kernel is compiled."""
    fill_triangles(blank_image(1, 1), np.zeros((1, 1)), np.zeros((1, 3, 3)), np.ones((1, 3)))


@kernel
def _fill_buffers(colour: Array, depth: Array, triangles: Array, rgb: Array) -> None:
    h, w = depth.shape
    for k in range(len(triangles)):
        ax, ay, az = triangles[k, 0]
        bx, by, bz = triangles[k, 1]
        cx, cy, cz = triangles[k, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        left, right = max(int(np.floor(min(ax, bx, cx))), 0), min(int(np.ceil(max(ax, bx, cx))) + 1, w)
        low, high = max(int(np.floor(min(ay, by, cy))), 0), min(int(np.ceil(max(ay, by, cy))) + 1, h)
        for i in range(low, high):
            y = i + 0.5
            for j in range(left, right):
                x = j + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                s = 1.0 - u - v
                if u >= -1e-9 and v >= -1e-9 and s >= -1e-9:
                    z = u * az + v * bz + s * cz
                    if z > depth[i, j]:
                        depth[i, j] = z
                        for c in range(3):
                            colour[i, j, c] = rgb[k, c]


# ----------------------------------------------------------------

VIEW_ELEVATIONS = (16.0, 28.0, -14.0, -26.0)  # [degrees] above the horizon; from below only when that shows more
AZIMUTH_STEP = 15.0  # of the azimuth [degrees]
COMPARISON_PIXELS = (96, 80)  # pixels of the images that are compared
COMPARISON_CELL = 0.05  # of the grasp's size: details of a finely meshed hand that are not compared
MAX_HAND_REACH, CUT_DISTANCE = (
    3.8,
    2.5,
)  # a hand that reaches farther from the object than FAR times its radius is cut at NEAR times
FADE_DISTANCE = 0.3  # radii of the object between it and where the hand begins to fade
# Sizes of the grasp: arrows that are this far apart are not nearer to each other than they need to be
MAX_LOAD_CLEARANCE = 0.25
VISIBILITY_WEIGHT = 0.9  # what it is worth to see all of the object
SCALES_HEIGHT, TOP_MARGIN = 0.62, 0.12  # inches for the scales below, and of air above
WORLD_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Camera:
    """An orthographic camera, given by its axes alone.

    axes (3, 3) : rows are screen right, screen up and the direction towards the viewer, world axes.
    """

    axes: Array

    def project(self, points: Array) -> Array:
        """Screen coordinates (…, 2) [m] of points (…, 3) [m], world axes: right and up."""
        return np.asarray(points @ self.axes[:2].T)


@dataclass(frozen=True, slots=True)
class ScreenMarks:
    """What should lie apart on the screen, as points [m] in world axes; empty where there is none.

    points (n, 3) : each apart from the others. load (m, 3) : along the load's arrow, which should not cover
    forces (n, k, 3) : along the first halves of the forces' arrows.
    """

    points: Array
    load: Array
    forces: Array

    def load_clearance(self, camera: Camera) -> float:
        """How far apart the load and the nearest force are on the screen [m]."""
        if not len(self.load) or not len(self.forces):
            return 0.0
        a, b = camera.project(self.load), camera.project(self.forces).reshape(-1, 2)
        return float(np.linalg.norm(a[:, None] - b[None], axis=2).min())


@dataclass(frozen=True, slots=True)
class ViewLimits:
    """The limits of a picture on the screen, and its scale on paper.

    box : limits x0, x1, y0, y1 of the picture [m], screen axes. inner : the same of the scene without labels.
    inch : metres on the screen that are one inch on paper.
    is_cut : whether parts of the hand lie beyond `inner`.
    """

    box: tuple[float, float, float, float]
    inner: tuple[float, float, float, float]
    inch: float
    is_cut: bool


def camera_against(normal: Array, up: Array) -> Camera:
    """Looking against `normal`, with `up` as near to screen up as it can be."""
    towards = normal / np.linalg.norm(normal)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return Camera(np.array([right, np.cross(towards, right), towards]))


def choose_camera(grasp: Grasp, solids: Sequence[Body], glass: Body | None, marks: ScreenMarks) -> Camera:
    """Along the normal for a planar grasp, otherwise from where most can be seen; the load points down if possible.

    glass : the object. marks : what should lie apart on the screen.
    """
    scene = grasp.scene
    load = float(np.linalg.norm(scene.force))
    if scene.plane is not None:
        normal = scene.plane * (1.0 if scene.plane[int(np.argmax(abs(scene.plane)))] > 0 else -1.0)
        up = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else WORLD_UP
        above = _nearest_up_axis(-scene.force / load) if load > 0 else up
        return camera_against(normal, up if abs(above @ normal) > 0.9 else above)  # where `above` points at the viewer
    down = scene.force
    if isinstance(grasp, HandGrasp) and grasp.target is not None and grasp.target.mass > 0.0:
        # An object with a weight hangs in the picture, whatever else pushes it
        down = grasp.given_gravity if grasp.given_gravity.any() else down
    size = float(np.linalg.norm(down))
    up = _nearest_up_axis(-down / size) if size > 0 else WORLD_UP
    return _choose_best_view(marks, scene.frames[:, :, 2], solids, glass, up, scene.units.length_unit)


def fit_view(
    camera: Camera,
    solids: Sequence[Body],
    glass: Body | None,
    reach: Array,
    inches: tuple[float, float],
    margin: float,
    least: float = 0.0,
) -> ViewLimits:
    """Limits around the object and the points of `reach` (k, 3), and around the hand unless that makes them small.

    inches : (width, height) of the picture on paper. margin : inches at each side for labels. least : metres that are
    one inch at least, for a scale that several pictures share.
    """
    core = [camera.project(reach)]
    if glass is not None:
        core.append(camera.project(glass.triangles).reshape(-1, 2))
    inner = np.concatenate(core)
    low, high = inner.min(0), inner.max(0)
    centre, radius = (low + high) / 2, float((high - low).max()) / 2
    cut = False
    if solids:
        rest = np.concatenate([camera.project(b.triangles).reshape(-1, 2) for b in solids])
        far = float(abs(rest - centre).max()) / radius
        cut = far > MAX_HAND_REACH and 2.0 * far * radius > least * min(inches)
        if cut:
            rest = rest[(abs(rest - centre) <= CUT_DISTANCE * radius).all(1)]
            low, high = low - FADE_DISTANCE * radius, high + FADE_DISTANCE * radius
        low, high = np.vstack([low, rest]).min(0), np.vstack([high, rest]).max(0)
    tall = inches[1] - SCALES_HEIGHT - TOP_MARGIN
    inch = max(float(high[0] - low[0]) / (inches[0] - 2 * margin), float(high[1] - low[1]) / tall, least)
    middle = (low + high) / 2
    x0, x1 = middle[0] - inches[0] / 2 * inch, middle[0] + inches[0] / 2 * inch
    y0 = middle[1] - tall / 2 * inch - SCALES_HEIGHT * inch
    y1 = y0 + inches[1] * inch
    box = (float(x0), float(x1), float(y0), float(y1))
    return ViewLimits(box, (float(low[0]), float(high[0]), float(low[1]), float(high[1])), inch, cut)


def _choose_best_view(
    marks: ScreenMarks, arrows: Array, solids: Sequence[Body], glass: Body | None, up: Array, size: float
) -> Camera:
    """The side where marks lie apart, arrows (k, 3; unit vectors) keep their length, and the object is seen."""
    first, second, _ = frame_about(up).T
    hand = (
        coarsen_triangles(np.concatenate([b.triangles for b in solids]), COMPARISON_CELL * size)
        if solids
        else np.zeros((0, 3, 3))
    )
    shape = None if glass is None else coarsen_triangles(glass.triangles, COMPARISON_CELL * size)
    views: list[tuple[float, Camera]] = []  # without what is seen of the object, which takes longest
    for elevation in VIEW_ELEVATIONS:
        for azimuth in np.arange(0.0, 360.0, AZIMUTH_STEP) + 5.0:
            a, e = np.radians(azimuth), np.radians(elevation)
            c = camera_against(np.cos(e) * (np.cos(a) * first + np.sin(a) * second) + np.sin(e) * up, up)
            s = c.project(marks.points)
            apart = np.linalg.norm(s[:, None] - s[None], axis=2)[np.triu_indices(len(s), 1)] / size
            score = float(min(apart.min(initial=1.0), 0.7)) + 0.3 * float(apart.mean()) if len(apart) else 0.0
            length = np.linalg.norm(c.project(arrows), axis=1)
            score += 0.9 * min(float(length.min(initial=1.0)), 0.8) + 0.3 * float(length.mean()) if len(arrows) else 0.0
            score += 2.0 * min(marks.load_clearance(c) / size, MAX_LOAD_CLEARANCE)
            views.append((score - (0.15 if elevation < 0 else 0.0), c))
    scores = np.array([score for score, _ in views])
    if shape is not None:
        best, seen = -np.inf, np.full(len(views), -np.inf)
        for k in np.argsort(-scores, kind="stable"):
            if scores[k] + VISIBILITY_WEIGHT < best:
                break  # nor can any of the others be better
            seen[k] = scores[k] + VISIBILITY_WEIGHT * _visible_share(views[k][1], hand, shape)
            best = max(best, seen[k])
        scores = seen
    return views[int(np.argmax(scores >= scores.max() - 1e-9))][1]


def _visible_share(camera: Camera, hand: Array, glass: Array) -> float:
    """Share of the object's silhouette that no part of the hand covers."""
    w, h = COMPARISON_PIXELS
    s = camera.project(glass).reshape(-1, 2)
    low, high = s.min(0), s.max(0)
    scale = min(w / float(high[0] - low[0]), h / float(high[1] - low[1]))

    def depths(triangles: Array) -> Array:
        page = triangles @ camera.axes.T
        page[..., :2] = (page[..., :2] - low) * scale
        depth = np.full((h, w), -np.inf)
        fill_triangles(blank_image(h, w), depth, page, np.zeros((len(page), 3)))
        return depth

    near, before = depths(glass), depths(hand)
    shape = np.isfinite(near)
    return float((shape & (before < near)).sum()) / max(int(shape.sum()), 1)


def _nearest_up_axis(up: Array) -> Array:
    """The nearest axis where `up` is almost along one, else z: an oblique load does not tilt the hand."""
    axis = int(np.argmax(abs(up)))
    return np.asarray(np.eye(3)[axis] * np.sign(up[axis])) if abs(up[axis]) > 0.95 else WORLD_UP
