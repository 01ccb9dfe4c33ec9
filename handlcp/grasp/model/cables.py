"""Tendons that move joints, as far as the mechanics need to know them: they pull, and never push."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints, read_only

_CONVERGED = 1e-14  # of the cost
_EXACT, _MADE = 1e6, 1e-6  # times as heavy as small tensions: that these make the torques; to this share of them


NO_SIDES = read_only(np.zeros((0, 3)))


class Cables(NamedTuple):
    """Tendons that move joints. names (t,). arms (t, nv) : R, 0 of a joint that gives way to nothing [m/rad, m/m].
    springs (t, t) : k [N/m]. passive (nv, nv) : K_p of the joints' own springs [N·m/rad]; rest (nv,) : where these are
    at rest, from the grasp's posture [rad, m]. pretension (t,) : T₀ in the grasp's posture before the hand closes [N];
    inf : taut whatever comes, as a rod is. limits (t,) : what they bear [N], inf where nothing is known.
    Posts that tendons wrap around, m of them, those of a tendon in the order from its drive on: of (m,) : number of the
    tendon. grips (m,) : μθ, friction times the angle of the wrap [rad]. posts (m, nv) : arms of the tendon at this post
    and beyond.
    Of tendons whose arms change with the posture these are those of one: shift (t,) : l - R q there, with l what joints
    have drawn in [m]; 0 of others. way : from joints at q (nv,) to the tendons there and the
    root of the joints' compliance with them, as in `Elasticity`; None: arms stay. turning : from
    tensions T (t,) to Σ T ∂R/∂q (nv, nv) there [N·m/rad], by which the tendons pull harder as joints move; None: 0.
    around (b,) : round bodies that they pass, in words; sides (b, 3) : on which side of each, a unit vector in the axes
    of its link.
    """

    names: tuple[str, ...]
    arms: Array
    springs: Array
    passive: Array
    rest: Array
    pretension: Array
    limits: Array
    of: Ints
    grips: Array
    posts: Array
    shift: Array
    way: Callable[[Array], tuple[Cables, Array]] | None = None
    turning: Callable[[Array], Array] | None = None
    around: tuple[str, ...] = ()
    sides: Array = NO_SIDES

    @classmethod
    def none(cls, nv: int) -> Cables:
        """Of joints without tendons."""
        none, row = np.zeros(0), np.zeros((0, nv))
        own, rest = np.zeros((nv, nv)), np.zeros(nv)
        return cls((), row, np.zeros((0, 0)), own, rest, none, none, np.zeros(0, dtype=np.int64), none, row, none)

    @property
    def springs_alone(self) -> bool:
        """Whether they act as springs whatever comes, and bear all of it."""
        return bool(np.isinf(self.pretension).all() and np.isinf(self.limits).all()) and not len(self.posts)

    def tensions(self, torque: Array) -> Array:
        """(t,) t [N] that make torques Rᵀ (t - T₀) (nv,) [N·m] with the least pull beyond T₀: none is let go below T₀
        where the others can do without, and none below 0. Of tendons without a known T₀, how much harder they pull.
        """
        begun, more = self.begun, np.asarray(np.linalg.lstsq(self.arms.T, torque)[0])
        known = np.isfinite(self.pretension)
        if (more >= 0.0)[known].all():
            return begun + more
        from scipy.optimize import lsq_linear  # half a second of import that only antagonists should pay

        size = float(abs(self.arms).max())
        rows = np.vstack([_EXACT * self.arms.T / size, np.eye(len(known))])
        asked = np.append(_EXACT * torque / size, np.zeros(len(known)))
        for least in (np.zeros(len(known)), -begun):
            bounds = np.where(known, least, -np.inf), np.inf
            more = lsq_linear(rows, asked, bounds, "bvls", _CONVERGED).x
            if abs(self.arms.T @ more - torque).max() <= _MADE * abs(torque).max():
                break
        return np.where(known, np.maximum(begun + more, 0.0), more)

    def crosses(self, a: Array, b: Array) -> str:
        """The first round body, in words, that a tendon passes on one side with joints at a (nv,) and on the other at b
        (nv,), postures that lie close together; "": none.
        """
        if self.way is None or not self.around:
            return ""
        (before, _), (now, _) = self.way(a), self.way(b)
        turned = np.flatnonzero((before.sides * now.sides).sum(axis=1) < 0.0)
        return self.around[turned[0]] if len(turned) else ""

    @property
    def begun(self) -> Array:
        """(t,) T₀; 0 where it is not known."""
        return np.where(np.isfinite(self.pretension), self.pretension, 0.0)

    def not_made(self, torque: Array) -> Array:
        """(nv,) the part of torques (nv,) [N·m] that no tensions make."""
        return np.asarray(torque - self.arms.T @ (self.tensions(torque) - self.begun))
