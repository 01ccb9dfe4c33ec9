"""`WrenchSpace`: the classic tests of closure, by linear programs, each with what proves its answer.

Force closure: friction can balance any load, if the fingers only press hard enough. So it is where the wrenches W of
the contacts span all loads and internal forces lie strictly within friction: W has full rank, W a = 0 for some a > 0.
Form closure: no motion is possible, even without friction. The same with the wrenches of the normals alone.

Where there is none, a motion t proves it: Wᵀ t ≥ 0, so that no contact ever resists it. This is the test of first
order: bodies that fewer contacts lock by their curvature fail it. Springs, squeeze and torque limits play no part, nor
whether anything commands the fingers to press. Sources: Murray, Li & Sastry, A Mathematical Introduction to Robotic
Manipulation (1994), chapter 5; Nguyen, Int. J. Robotics Research 7 (1988), two fingers with friction; Lakshminarayana,
ASME paper 78-DET-32 (1978), four contacts in a plane and seven in space; Rimon & Burdick, IEEE Trans. Robotics and
Automation 14 (1998), the second order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from handlcp.check import Array, read_only
from handlcp.contact.friction import Cone, Interval, Pyramid, Section
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solution.diagnosis import DiagnosisText
from handlcp.grasp.solve.solve_spec import escape_certificate
from handlcp.grasp.verify.load_capacity import edge_forces, escape_in_si
from handlcp.record import Record
from handlcp.tolerances import CERTIFY_TOLERANCE, RANK_TOLERANCE

_PYRAMID_FACES = (8, 32, 128, 512)  # of pyramids in the cone and around it, until one of them tells
_SOFT_PYRAMID_FACES = (8, 24, 64)
_STRICT_SHARE = 1e-6  # share of the mean force along an edge: what is less is not strictly within friction


@dataclass(frozen=True, slots=True, eq=False)
class Closure(Record):
    """One test and its proof.

    kind : "force" or "form". closed : whether there is closure; None: so near to the edge that rounding decides.
    forces : (n, 3) contact axes, for a sum of normal forces of 1 N: internal forces strictly within friction (of form
    closure: normal forces, all > 0) that balance one another; None where there is no closure.
    motion : (6,) small motion about the grasp's reference that no contact resists, for one metre of travel [m, rad];
    None where there is closure. sentence : the answer in words.
    """

    entries = ("closed", "sentence", "forces_N (n, 3)", "motion (6,)")

    kind: str
    closed: bool | None
    forces: Array | None
    motion: Array | None
    sentence: str


def force_closure(spec: GraspSpec, scene: Scene, section: Section) -> Closure:
    """With the friction of a scene. The cone has it where a pyramid within has it, and lacks it where one around it
    does; contacts whose force is prescribed take no part, those of the environment do.
    """
    if not isinstance(section, Cone) or not scene.frictional:
        return _make_closure(spec, scene, "force", *_test_closure(*edge_forces(scene, section)))
    for faces in _SOFT_PYRAMID_FACES if scene.soft else _PYRAMID_FACES:
        inner = _test_closure(*edge_forces(scene, Pyramid(faces)))
        if inner[0] is not None:
            return _make_closure(spec, scene, "force", *inner)
        outer = _test_closure(*edge_forces(scene, Pyramid(faces, inscribed=False)))
        if outer[1] is not None:
            return _make_closure(spec, scene, "force", None, outer[1])
    return _make_closure(spec, scene, "force", None, None)


def form_closure(spec: GraspSpec, scene: Scene) -> Closure:
    """As if no contact had friction."""
    at = scene.kind.normal_index
    F = np.zeros((scene.components, len(at)))
    F[at, np.arange(len(at))] = 1.0
    return _make_closure(spec, scene, "form", *_test_closure(F, scene.natural.full_G[:, at]))


def _test_closure(F: Array, W: Array) -> tuple[Array | None, Array | None]:
    """The proof of closure (c,), forces with a sum of normal forces of one; or that against it (dof,), a motion; or
    neither. F (c, g) forces along edges, W (dof, g) their wrenches.
    """
    dof = len(W)
    few = np.zeros((dof, max(dof - W.shape[1], 0)))  # so that there are as many directions as dimensions
    u, s, _ = np.linalg.svd(np.hstack([W, few]), full_matrices=False)
    rank = int((s > RANK_TOLERANCE * s.max(initial=0.0)).sum())
    if rank < dof:
        # Which basis of all motions that are left a decomposition finds says nothing: the one nearest to a translation
        # along an axis or to a turn about one
        free = u[:, rank:]
        near = (free * free).sum(axis=1)  # how much of each axis they hold: its cosine, squared
        t = free @ free[int(np.argmax(near >= near.max() - _STRICT_SHARE))]
        return None, np.asarray(t / np.sqrt(t @ t))
    g, size = W.shape[1], np.sqrt((W * W).sum(axis=0))
    # The widest least share s: a = s + b, b ≥ 0, W a = 0, mean of a is one
    lp = scipy.optimize.linprog(
        np.append(np.zeros(g), -1.0),
        A_eq=np.vstack([np.column_stack([W, W.sum(axis=1)]), np.append(np.ones(g), g)]),
        b_eq=np.append(np.zeros(dof), g),
        bounds=[(0.0, None)] * g + [(0.0, None)],
        method="highs",
    )
    if lp.x is not None and lp.x[-1] > _STRICT_SHARE:
        a = (lp.x[:-1] + lp.x[-1]) / g
        a = a - np.linalg.pinv(W) @ (W @ a)  # balance to the last bit
        if a.min() > 0.0:
            return F @ (a / a.sum()), None
    lp = scipy.optimize.linprog(
        -(W / size).sum(axis=1), A_ub=-(W / size).T, b_ub=np.zeros(g), bounds=[(-1.0, 1.0)] * dof, method="highs"
    )
    if lp.x is not None:
        t = lp.x / (np.sqrt(lp.x @ lp.x) or 1.0)
        work = W.T @ t / size
        if work.max(initial=0.0) > _STRICT_SHARE and work.min(initial=0.0) > -CERTIFY_TOLERANCE:
            return None, t
    return None, None


def _make_closure(spec: GraspSpec, scene: Scene, kind: str, forces: Array | None, motion: Array | None) -> Closure:
    """In SI, and in words."""
    if forces is not None:
        own = scene.forces_to_contact_axes(forces)[: 3 * scene.n].reshape(-1, 3)
        text = (
            "friction balances any load, if the fingers press hard enough (by geometry alone, whatever squeeze and "
            "motors)"
        )
        if kind == "form":
            text = "the contacts leave no motion, even without friction"
        return Closure(kind, True, read_only(own), None, text)
    if motion is None:
        text = "so near to the edge between yes and no that rounding decides"
        return Closure(kind, None, None, None, text)
    t = escape_certificate(spec, scene, escape_in_si(scene, motion))
    say = DiagnosisText(spec.names, scene.positions, spec.reference, scene.environment, who=spec.who)
    way = say.motion(t, "slides", "turns")
    less = "without friction " if kind == "form" else ""
    return Closure(kind, False, None, t, f"{less}the object {way}, and no contact resists")


# ----------------------------------------------------------------
# The grasp wrench space: which wrenches the contacts exert while their normal forces add up to 1 N.
#
#     conv({0} ∪ {w(r) : r within friction, r_N = 1}),   w = (force, moment about the contacts' centre / length)
#
# ε is the radius of the largest ball about the origin in it: the grasp resists any load (F, M/length) of size ε in
# every direction. On the friction cone, ε lies between that of pyramids within it, which get more edges where the
# ball touches until half a percent is left or the hulls become too large, and the distance of a plane that touches
# the true hull. The volume lies between those of pyramids within the cone and around it. Source: Ferrari & Canny,
# IEEE Int. Conf. Robotics and Automation (1992), their L1 measure; hulls by qhull.


_HULL_FACES = (12, 8, 6, 4)  # of pyramids in place of the cone: the most with which there are not too many corners
_MAX_CORNERS, _MAX_SOFT_CORNERS = 50, 80
_EPSILON_GAP, _MAX_HULLS, _CORNERS_PER_HULL = (
    5e-3,
    12,
    4,
)  # ε on the cone: how close is enough; hulls, and corners added to each
_ZERO_EPSILON = 1e-9  # of the largest wrench: an ε that is rounding


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
        "epsilon",
        "epsilon_most",
        "volume",
        "volume_most",
        "dimension",
        "of",
        "length_m",
        "weakest (6,)",
        "faces",
        "why",
    )

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
    L = scene.units.length_unit if length is None else length
    scale = np.ones(scene.dof)
    scale[2 if scene.plane is not None else 3 :] = scene.units.length_unit / L
    within, around, faces = _bounding_sections(scene, section)
    W = scale[:, None] * edge_forces(scene, within)[1]
    u, s, _ = np.linalg.svd(W, full_matrices=False)
    U = u[:, s > RANK_TOLERANCE * s.max(initial=0.0)]
    d, nothing = U.shape[1], np.full(6, np.nan)
    if d == 0:
        return WrenchSpace(0.0, 0.0, 0.0, 0.0, 0, scene.dof, L, nothing, faces, "no contact has an unknown force")
    try:
        hull, most = _ConvexHull(U.T @ W), None
        if isinstance(section, Cone) and faces:
            most = _refine_hull(hull, scene, scale[:, None] * scene.natural.full_G, U)
        outer = (
            _ConvexHull(U.T @ (scale[:, None] * edge_forces(scene, around)[1])) if faces and around != within else hull
        )
    except scipy.spatial.QhullError:
        why = "qhull finds no hull: the contact wrenches are too near to lying in fewer dimensions"
        return WrenchSpace(np.nan, np.nan, np.nan, np.nan, d, scene.dof, L, nothing, faces, why)
    radius, facet = hull.ball()
    load = -radius * (U @ facet)  # contact wrenches reach least along the facet's normal, the load points against it
    k = scene.dof - (3 if scene.plane is None else 1)
    load[k:] *= L
    about = load @ scene.freedom
    about[3:] += np.cross(scene.units.centre - reference, about[:3])
    return WrenchSpace(
        radius,
        radius if most is None else max(most, radius),
        hull.volume,
        max(outer.volume, hull.volume),
        d,
        scene.dof,
        L,
        read_only(about),
        faces,
    )


def _bounding_sections(scene: Scene, section: Section) -> tuple[Section, Section, int]:
    """The pyramids within the friction and around it, and how many faces they have where they are not exact."""
    if isinstance(section, Interval) or not scene.frictional:
        return section, section, 0
    if isinstance(section, Pyramid):
        return section, section, 0
    most = _MAX_SOFT_CORNERS if scene.soft else _MAX_CORNERS
    for faces in _HULL_FACES:
        if edge_forces(scene, Pyramid(faces))[1].shape[1] <= most:
            break
    return Pyramid(faces), Pyramid(faces, inscribed=False), faces


def _refine_hull(hull: _ConvexHull, scene: Scene, every: Array, U: Array) -> float:
    """An upper bound of ε on the cone; the hull gets corners until its ball comes close, or for so many rounds."""
    own = scene.kind.contact_components
    normals = [
        (U.T @ every[:, at[0]], U.T @ every[:, at[1 : 1 + t]], mu)
        for at, t, mu in zip(own, scene.kind.tangent_count, scene.mu, strict=True)
        if at[0] >= 0
    ]
    most = np.inf
    for _ in range(_MAX_HULLS):
        facets, offsets = hull.normals, hull.offsets
        low = np.flatnonzero(offsets < most)
        low = low[np.argsort(offsets[low])][: 10 * _CORNERS_PER_HULL]
        reach, corners = _supports(normals, facets[low])
        most = min(most, float(np.maximum(reach.max(axis=0), 0.0).min(initial=np.inf)))
        if hull.ball()[0] >= most * (1.0 - _EPSILON_GAP):
            break
        best = reach.argmax(axis=0)
        gain = reach[best, np.arange(len(low))] - offsets[low]
        few = np.flatnonzero(gain > _ZERO_EPSILON)[:_CORNERS_PER_HULL]
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


class _ConvexHull:
    """The convex hull of points (d, k) and the origin; d = 1 is an interval.

    normals (f, d), offsets (f,) : of its facets, units and distances from the origin.
    """

    def __init__(self, points: Array) -> None:
        self._points = np.zeros((len(points), 0))
        self.add(np.column_stack([points, np.zeros(len(points))]))

    def add(self, points: Array) -> None:
        """Add points, the columns of (d, k), to the hull."""
        self._points = P = np.column_stack([self._points, points])
        if len(P) == 1:
            self.normals = np.array([[1.0], [-1.0]])
            self.offsets = np.maximum((self.normals @ P).max(axis=1), 0.0)
            self.volume = float(P.max() - P.min())
            return
        try:
            hull = scipy.spatial.ConvexHull(P.T, qhull_options="Qt Q12" if len(P) < 5 else "Qx Qt Q12")
        except scipy.spatial.QhullError:
            hull = scipy.spatial.ConvexHull(P.T, qhull_options="QJ")  # joggled by rounding's size
        self.normals, self.offsets = hull.equations[:, :-1], np.maximum(-hull.equations[:, -1], 0.0)
        self.volume = float(hull.volume)

    def ball(self) -> tuple[float, Array]:
        """The radius of the largest ball about the origin, and the normal (d,) of a facet that it touches."""
        k = int(self.offsets.argmin())
        size = float(np.sqrt((self._points**2).sum(axis=0)).max())
        return (float(self.offsets[k]) if self.offsets[k] > _ZERO_EPSILON * size else 0.0), self.normals[k]
