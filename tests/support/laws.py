"""A second opinion on every answer: the laws of a grasp recomputed, knowing nothing of the package's certifier.

With F the size of the forces and V that of the motions at a contact, each law is missed by a number without unit:

    balance    |Σ f + w| and |Σ moments| over the size of the grasp, over F
    normal     a pull / F, an overlap / V, or the smaller of push / F and gap / V
    cone       how far the tangential force, and moment, lies outside what friction allows, / F
    slip       how far it is from the point of that set which friction would choose against this slip, / F
    work       by how much its work against the slip falls short of the most that friction allows, / (F V)
    reported   the solution's own gaps and slips against those recomputed, / V (elastic compatibility)

`of_case` takes a scene as plain arrays; a hand with effects has more laws, in `hand_laws`, on top of the same ones.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tests.support.friction_sets import limit

GROWTH = 1e3  # forces larger than this many times the load excuse no more


@dataclass(frozen=True)
class Laws:
    """By how much each law is missed."""

    balance: float
    normal: float
    cone: float
    slip: float
    work: float
    reported: float

    @property
    def worst(self):
        """The largest; infinite where anything is not a number."""
        values = [getattr(self, f.name) for f in fields(self)]
        return max(values) if np.isfinite(values).all() else np.inf


# ---------------------------------------------------------------- the laws, whoever asks
def balance(arms, world, load, size, F, couples=None):
    """Forces (n, 3) in world axes at arms (n, 3) from the point that the load (6,) refers to; couples (n, 3)."""
    lost = world.sum(0) + load[:3]
    turned = np.cross(arms, world).sum(0) + load[3:] + (0.0 if couples is None else couples.sum(0))
    return float(np.hypot(np.linalg.norm(lost), np.linalg.norm(turned) / size)) / F


def contact(limits, push, gap, tangential, slides, F, V, along):
    """(normal, cone, slip, work), each the worst of all contacts.

    push, gap (n,). tangential, slides : forces [N] and motions [m] of each contact in the law's coordinates. V (n,) :
    what its slides are measured by. along (n,) : what its gap is.
    """
    normal = cone = slip = work = 0.0
    for i, allowed in enumerate(limits):
        r, g = push[i] / F, gap[i] / along[i]
        normal = max(normal, -r, -g, min(abs(r), abs(g)))
        t, s = np.asarray(tangential[i]) / F, np.asarray(slides[i]) / V[i]
        cone = max(cone, _apart(t, allowed.nearest(t, r)))
        if allowed.most(np.ones(len(t)), 1.0) > 0:  # where there is no friction, any slip will do
            slip = max(slip, _apart(t, allowed.nearest(t - s, r)))
            work = max(work, abs(allowed.most(-s, r) + float(s @ t)))
    return float(normal), cone, slip, work


def reported(said, moved, V):
    """Motions (n, 3) as the solution has them and as they are."""
    return float((abs(said - moved) / np.asarray(V)[:, None]).max(initial=0.0))


def spread(p):
    """Rms distance of contacts from their centre; where they coincide but for rounding, of the centre from the origin,
    or one.
    """
    c = p.mean(0)
    s, far = float(np.sqrt(((p - c) ** 2).sum(1).mean())), float(np.linalg.norm(c))
    return s if s > 1e-12 * far else far or 1.0


def _apart(a, b):
    return float(np.linalg.norm(a - b))


# ---------------------------------------------------------------- a scene as plain arrays
def of_case(case, solution):
    """The laws of `case` at a solution: p (n, 3), R (n, 3, 3), mu (n,), E (3n, 3n), d (n, 3), w (6,) about the origin,
    faces, plane (3,) or None, and the reference (3,) of the solution's motion.

    F is at most 1000 loads. V of a contact is the size of the terms that add up to its motion, and `along` that of
    those along the normal: an object that slides away for metres must not excuse microns of overlap.
    """
    f, u = np.asarray(solution.forces), np.asarray(solution.object_displacement)
    gap, slip = np.asarray(solution.gap), np.asarray(solution.slip)
    if not all(np.isfinite(a).all() for a in (f, u, gap, slip)):
        return Laws(*[np.inf] * 6)
    n, centre, L = len(case.mu), case.p.mean(0), spread(case.p)
    moment = case.w[3:] - np.cross(centre, case.w[:3])
    soft = np.trace(case.E.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)], axis1=1, axis2=2) / 3
    F = _size_of_forces(case, f, float(np.hypot(np.linalg.norm(case.w[:3]), np.linalg.norm(moment) / L)), soft)
    v, size = _motion(case, f, np.r_[u[:3] - np.cross(u[3:], case.reference), u[3:]])
    least = _least_motions(soft * F, case.d, L)
    V = np.maximum(size.max(1), least)
    V = np.maximum(V, 1e-12 * (V.max() or 1.0))
    along = np.maximum(np.maximum(size[:, 2], least), 1e-7 * V)  # rounding of the large terms stays allowed
    said, faces = np.column_stack([slip, gap]), case.faces
    if case.plane is not None:
        faces, v[:, 1], said[:, 1] = 2, 0.0, 0.0
    limits = [limit(mu, faces) for mu in case.mu.tolist()]
    world = np.einsum("nij,nj->ni", case.R, f)
    missed = contact(limits, f[:, 2], v[:, 2], f[:, :2], v[:, :2], F, V, along)
    load = np.r_[case.w[:3], moment]
    return Laws(balance(case.p - centre, world, load, L, F), *missed, reported(said, v, V))


def _least_motions(give, d, size):
    """(n,) what a contact's motion is measured by at least: how far F bends it, and where it is rigid, the stiffest of
    the others, whose force changes with it. Where all are rigid no force does: a share of the offsets, or of the size.
    """
    bends = give > 0
    stiffest = give[bends].min() if bends.any() else 1e-3 * (float(np.sqrt((d**2).mean())) or size)
    return np.where(bends, give, stiffest)


def _size_of_forces(case, f, load, soft):
    """F: of forces and load."""
    F = max(float(abs(f).max()), load)
    if load > 0:
        return min(F, GROWTH * load)
    mean = float(soft.mean())  # without load the squeeze is what forces are measured by
    return max(F, float(np.sqrt((case.d**2).sum(1).mean())) / mean if mean > 0 else 0.0) or 1.0


def _motion(case, forces, twist):
    """(v, size): object minus fingertip in contact axes (n, 3), and for each component the size of the terms in it."""
    n, about = len(case.mu), case.p.mean(0)
    shift = np.einsum("nji,j->ni", case.R, twist[:3] + np.cross(twist[3:], about))
    turned = np.einsum("nji,nj->ni", case.R, np.cross(twist[3:], case.p - about))
    bent = (case.E @ forces.ravel()).reshape(n, 3)
    most = (abs(case.E) @ abs(forces.ravel())).reshape(n, 3)
    return shift + turned + bent + case.d, np.maximum(np.maximum(abs(shift) + abs(turned), most), abs(case.d))
