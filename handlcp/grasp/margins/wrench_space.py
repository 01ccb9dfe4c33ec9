"""The grasp wrench space: which wrenches the contacts exert while their normal forces add up to 1 N.

    conv({0} ∪ {w(r) : r within friction, r_N = 1}),   w = (force, moment about the contacts' centre / length)

ε is the radius of the largest ball about the origin in it: the grasp resists any load (F, M/length) of size ε in every
direction. On the friction cone, ε lies between that of pyramids within it, which get more edges where the ball touches
until half a percent is left or the hulls become too large, and the distance of a plane that touches the true hull.
The volume lies between those of pyramids within the cone and around it. Source: Ferrari & Canny, IEEE
Int. Conf. Robotics and Automation (1992), their L1 measure; hulls by qhull.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Cone, Interval, Pyramid, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.holdable import generators
from handlcp.record import Record
from handlcp.tolerances import RANK

_FACES = (12, 8, 6, 4)  # of pyramids in place of the cone: the most with which there are not too many corners
_CORNERS, _CORNERS_OF_SOFT = 50, 80
_CLOSE, _ROUNDS, _MORE = 5e-3, 12, 4  # ε on the cone: how close is enough; hulls, and corners added to each
_NOTHING = 1e-9  # of the largest wrench: an ε that is rounding


@dataclass(frozen=True, slots=True, eq=False)
class WrenchSpace(Record):
    """The wrenches of contacts whose normal forces add up to 1 N, moments over `length` [m], about their centre.

    epsilon : radius of the largest ball, [N per N of normal force]; 0 where some load is not resisted at all. On the
    cone it is at least that, and at most epsilon_most; without the cone both are the same.
    volume, volume_most : between these, in the units of the ball to the power of `dimension`.
    dimension : of the space that contact wrenches span, at most `of`: 6, or 3 in a plane. Where it is less, ε and
    volume are those within it, and loads outside it are not resisted at all.
    weakest : (6,) the load about the grasp's reference that is resisted least, N and N·m per newton of normal force;
    of size ε. faces : of the pyramids, where the volume is theirs; 0: exact. why : in words, why there is no number; ε
    and volume are NaN then.
    """

    entries = (
        "epsilon", "epsilon_most", "volume", "volume_most", "dimension", "of", "length_m", "weakest (6,)", "faces",
        "why",
    )  # fmt: skip

    epsilon: float
    epsilon_most: float
    volume: float
    volume_most: float
    dimension: int
    of: int
    length: float
    weakest: Array
    faces: int
    why: str = ""


def wrench_space(scene: Scene, section: Section, reference: Array, length: float | None) -> WrenchSpace:
    """Of the contacts whose force is not prescribed, those of the environment included; length : that moments are
    divided by [m]; None: the root mean square of the contacts' distances from their centre.
    """
    L = scene.units.length if length is None else length
    scale = np.ones(scene.dof)
    scale[2 if scene.plane is not None else 3 :] = scene.units.length / L
    within, around, faces = _sections(scene, section)
    W = scale[:, None] * generators(scene, within)[1]
    u, s, _ = np.linalg.svd(W, full_matrices=False)
    U = u[:, s > RANK * s.max(initial=0.0)]
    d, nothing = U.shape[1], np.full(6, np.nan)
    if d == 0:
        return WrenchSpace(0.0, 0.0, 0.0, 0.0, 0, scene.dof, L, nothing, faces, "no contact has an unknown force")
    try:
        hull, most = _Hull(U.T @ W), None
        if isinstance(section, Cone) and faces:
            most = _refined(hull, scene, scale[:, None] * scene.natural.every, U)
        outer = _Hull(U.T @ (scale[:, None] * generators(scene, around)[1])) if faces and around != within else hull
    except _qhull_error():
        why = "qhull finds no hull: the contact wrenches are too near to lying in fewer dimensions"
        return WrenchSpace(np.nan, np.nan, np.nan, np.nan, d, scene.dof, L, nothing, faces, why)
    radius, facet = hull.ball()
    load = -radius * (U @ facet)  # contact wrenches reach least along the facet's normal, the load points against it
    k = scene.dof - (3 if scene.plane is None else 1)
    load[k:] *= L
    about = load @ scene.freedom
    about[3:] += np.cross(scene.units.centre - reference, about[:3])
    return WrenchSpace(
        radius, radius if most is None else max(most, radius), hull.volume, max(outer.volume, hull.volume), d,
        scene.dof, L, read_only(about), faces,
    )  # fmt: skip


def _sections(scene: Scene, section: Section) -> tuple[Section, Section, int]:
    """The pyramids within the friction and around it, and how many faces they have where they are not exact."""
    if isinstance(section, Interval) or not scene.frictional:
        return section, section, 0
    if isinstance(section, Pyramid):
        return section, section, 0
    most = _CORNERS_OF_SOFT if scene.soft else _CORNERS
    for faces in _FACES:
        if generators(scene, Pyramid(faces))[1].shape[1] <= most:
            break
    return Pyramid(faces), Pyramid(faces, inscribed=False), faces


def _refined(hull: _Hull, scene: Scene, every: Array, U: Array) -> float:
    """An upper bound of ε on the cone; the hull gets corners until its ball comes close, or for so many rounds."""
    own = scene.kind.contact_components
    normals = [(U.T @ every[:, at[0]], U.T @ every[:, at[1 : 1 + t]], mu) for at, t, mu
               in zip(own, scene.kind.tangents, scene.mu, strict=True) if at[0] >= 0]  # fmt: skip
    most = np.inf
    for _ in range(_ROUNDS):
        facets, offsets = hull.facets()
        low = np.flatnonzero(offsets < most)
        low = low[np.argsort(offsets[low])][: 10 * _MORE]
        reach, corners = _supports(normals, facets[low])
        most = min(most, float(np.maximum(reach.max(axis=0), 0.0).min(initial=np.inf)))
        if hull.ball()[0] >= most * (1.0 - _CLOSE):
            break
        best = reach.argmax(axis=0)
        gain = reach[best, np.arange(len(low))] - offsets[low]
        few = np.flatnonzero(gain > _NOTHING)[:_MORE]
        if not len(few):
            break
        hull.add(corners[best[few], :, few].T)
    return most


def _supports(contacts: list[tuple[Array, Array, float]], facets: Array) -> tuple[Array, Array]:
    """(n, k) how far each contact's wrenches of 1 N reach along facets' normals (k, d), and (n, d, k) where."""
    reach, corners = [], []
    for w, T, mu in contacts:
        along = facets @ T
        size = np.sqrt((along * along).sum(axis=1)) if T.shape[1] else np.zeros(len(facets))
        way = along / np.where(size > 0.0, size, 1.0)[:, None]
        corners.append(w[:, None] + mu * T @ way.T)
        reach.append(facets @ w + mu * size)
    return np.array(reach), np.array(corners)


class _Hull:
    """The convex hull of points (d, k) and the origin; d = 1 is an interval."""

    def __init__(self, points: Array) -> None:
        self._points = np.column_stack([points, np.zeros(len(points))])
        self._make()

    def _make(self) -> None:
        from scipy.spatial import ConvexHull  # a tenth of a second that few grasps should pay

        P = self._points
        self._facets: tuple[Array, Array]
        if len(P) == 1:
            ends = np.array([[1.0], [-1.0]])
            self._facets = ends, np.maximum((ends @ P).max(axis=1), 0.0)
            self.volume = float(P.max() - P.min())
            return
        try:
            hull = ConvexHull(P.T, qhull_options="Qt Q12" if len(P) < 5 else "Qx Qt Q12")
        except _qhull_error():
            hull = ConvexHull(P.T, qhull_options="QJ")  # joggled by rounding's size
        self._facets = hull.equations[:, :-1], np.maximum(-hull.equations[:, -1], 0.0)
        self.volume = float(hull.volume)

    def add(self, points: Array) -> None:
        """More points (d, k)."""
        self._points = np.column_stack([self._points, points])
        self._make()

    def facets(self) -> tuple[Array, Array]:
        """Unit normals (f, d) and distances from the origin (f,)."""
        return self._facets

    def ball(self) -> tuple[float, Array]:
        """The radius of the largest ball about the origin, and the normal (d,) of a facet that it touches."""
        normals, offsets = self._facets
        k = int(offsets.argmin())
        size = float(np.sqrt((self._points**2).sum(axis=0)).max())
        return (float(offsets[k]) if offsets[k] > _NOTHING * size else 0.0), normals[k]


def _qhull_error() -> Any:
    from scipy.spatial import QhullError

    return QhullError
