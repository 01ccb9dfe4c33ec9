"""A second opinion on every answer: the laws of a grasp recomputed from contacts and solution alone.

It knows nothing of the package's certifier, matrices or units. With F the size of the forces and V_i the size of the
terms that add up to the motion of contact i, each law is missed by a number without unit:

    balance    |Σ f + w| and |Σ moments| over the spread of the contacts, over F
    normal     a pull / F, an overlap / V_i, or the smaller of push / F and gap / V_i, where V_i is made of the terms
               along the normal only: an object that slides away for metres must not excuse microns of overlap
    cone       how far the tangential force lies outside its polygon (disc, interval), / F
    slip       how far it is from the point of that polygon which friction would choose against this slip
    reported   the solution's own gap and slip against those recomputed here, / V_i (elastic compatibility)
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, tan

import numpy as np

GROWTH = 1e3  # forces larger than this many times the load excuse no more


@dataclass(frozen=True)
class Laws:
    """By how much each law is missed."""

    balance: float
    normal: float
    cone: float
    slip: float
    reported: float

    @property
    def worst(self) -> float:
        """The largest; infinite where anything is not a number."""
        values = (self.balance, self.normal, self.cone, self.slip, self.reported)
        return max(values) if np.isfinite(values).all() else np.inf


def reach(mu, faces):
    """Distance of the sides of an inscribed polygon from the axis, per newton of normal force."""
    return mu * cos(pi / faces) if isinstance(faces, int) and faces > 2 else mu


def corners(faces):
    """(m, 2) corners of the polygon whose sides are at distance one, the first side's normal along x."""
    a = 2 * pi * (np.arange(faces) + 0.5) / faces
    return np.column_stack([np.cos(a), np.sin(a)]) / cos(pi / faces)


def nearest(point, radius, faces):
    """The point of the polygon (faces ≥ 3), disc ("cone") or interval along x (2) nearest to `point` (2,).

    Polygon: among the point itself, if inside, and its nearest points on all sides, one after the other.
    """
    point = np.asarray(point, float)
    if radius <= 0:
        return np.zeros(2)
    if faces == "cone":
        size = float(np.hypot(*point))
        return point if size <= radius else point * (radius / size)
    if faces == 2:
        return np.array([np.clip(point[0], -radius, radius), 0.0])
    a = 2 * pi * np.arange(faces) / faces
    out = np.column_stack([np.cos(a), np.sin(a)])
    if (out @ point <= radius).all():
        return point
    along = np.column_stack([-out[:, 1], out[:, 0]])
    half = radius * tan(pi / faces)
    feet = radius * out + np.clip(along @ point, -half, half)[:, None] * along
    return feet[np.argmin(((feet - point) ** 2).sum(1))]


def spread(p):
    """Rms distance of contacts from their centre; where they coincide but for rounding, of the centre from the origin,
    or one.
    """
    c = p.mean(0)
    s, far = float(np.sqrt(((p - c) ** 2).sum(1).mean())), float(np.linalg.norm(c))
    return s if s > 1e-12 * far else far or 1.0


def motion(case, forces, twist):
    """(v, size): object minus fingertip in contact axes (n, 3), and for each component the size of the terms in it."""
    n, about = len(case.mu), case.p.mean(0)
    shift = np.einsum("nji,j->ni", case.R, twist[:3] + np.cross(twist[3:], about))
    turned = np.einsum("nji,nj->ni", case.R, np.cross(twist[3:], case.p - about))
    bent = (case.E @ forces.ravel()).reshape(n, 3)
    most = (abs(case.E) @ abs(forces.ravel())).reshape(n, 3)
    return shift + turned + bent + case.d, np.maximum(np.maximum(abs(shift) + abs(turned), most), abs(case.d))


def laws(case, solution) -> Laws:
    """The laws of `case` (see `scenes.Case`) at a solution."""
    f, u = np.asarray(solution.forces), np.asarray(solution.object_displacement)
    gap, slip = np.asarray(solution.gap), np.asarray(solution.slip)
    if not all(np.isfinite(a).all() for a in (f, u, gap, slip)):
        return Laws(*[np.inf] * 5)
    n, centre, L = len(case.mu), case.p.mean(0), spread(case.p)
    faces = 2 if case.plane is not None else case.faces
    world = np.einsum("nij,nj->ni", case.R, f)
    moment = case.w[3:] - np.cross(centre, case.w[:3])
    load = float(np.hypot(np.linalg.norm(case.w[:3]), np.linalg.norm(moment) / L))
    soft = np.trace(case.E.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)], axis1=1, axis2=2) / 3
    F = max(float(abs(f).max()), load)
    if load > 0:
        F = min(F, GROWTH * load)
    else:  # without load the squeeze is what forces are measured by
        mean = float(soft.mean())
        F = max(F, float(np.sqrt((case.d**2).sum(1).mean())) / mean if mean > 0 else 0.0) or 1.0
    lost = np.linalg.norm(case.w[:3] + world.sum(0))
    turned = np.linalg.norm(moment + np.cross(case.p - centre, world).sum(0))
    u = np.r_[u[:3] - np.cross(u[3:], case.reference), u[3:]]
    v, size = motion(case, f, u)
    V = np.maximum(size.max(1), soft * F)
    V = np.maximum(V, 1e-12 * (V.max() or 1.0))
    along = np.maximum(np.maximum(size[:, 2], soft * F), 1e-7 * V)  # rounding of the large terms stays allowed
    normal = cone = miss = 0.0
    for i in range(n):
        push, g = f[i, 2] / F, v[i, 2] / along[i]
        normal = max(normal, -push, -g, min(abs(push), abs(g)))
        radius, t, s = reach(case.mu[i], faces) * push, f[i, :2] / F, v[i, :2] / V[i]
        if faces == 2:
            s = np.array([s[0], 0.0])
        cone = max(cone, float(np.linalg.norm(t - nearest(t, radius, faces))))
        if case.mu[i] > 0:
            miss = max(miss, float(np.linalg.norm(t - nearest(t - s, radius, faces))))
    said = np.column_stack([slip, gap]) - v
    if case.plane is not None:
        said[:, 1] = 0.0
    return Laws(float(np.hypot(lost, turned / L)) / F, float(normal), cone, miss, float((abs(said) / V[:, None]).max()))


def escapes(case, twist) -> bool:
    """Whether `twist` about the reference proves by signs that nothing holds: no contact's force resists it beyond
    rounding, the load drives it. Exact cone: the least work of a force in it is v_N - μ|v_T|.
    """
    t = np.asarray(twist, float)
    centre, L = case.p.mean(0), spread(case.p)
    at_c = t[:3] + np.cross(t[3:], centre - case.reference)
    moment = case.w[3:] - np.cross(centre, case.w[:3])
    size = np.hypot(np.linalg.norm(at_c), L * np.linalg.norm(t[3:]))
    load = np.hypot(np.linalg.norm(case.w[:3]), np.linalg.norm(moment) / L)
    if not (np.isfinite(t).all() and size > 0 and load > 0):
        return False
    gain = (case.w[:3] @ at_c + moment @ t[3:]) / (load * size)
    faces = 2 if case.plane is not None else case.faces
    resisting = 0.0
    for p, R, mu in zip(case.p, case.R, case.mu, strict=True):
        v = R.T @ (at_c + np.cross(t[3:], p - centre)) / size
        r = reach(mu, faces)
        if faces == "cone":
            least = v[2] - r * np.hypot(v[0], v[1])
        elif faces == 2:
            least = v[2] - r * abs(v[0])
        else:
            least = v[2] + r * (corners(faces) @ v[:2]).min() if r > 0 else v[2]
        resisting = max(resisting, -least)
    return bool(gain > 1e-9 and resisting < 1e-3 * gain and resisting < 1e-6)
