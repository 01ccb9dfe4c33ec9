"""What a sample's grasp does: held or not, and how far contacts slide over edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp import GraspSolution, Solutions, solve_many
from handlcp.grasp.answer.reasons import friction_margin
from handlcp.grasp.answer.verdict import HELD, NOT_HELD, OVER_LIMIT, UNDECIDED
from handlcp.grasp.cause.judge import exceeded
from handlcp.grasp.friction import Pyramid, as_section
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.verdict.check import judged
from handlcp.hand.objects.object import BOX, CYLINDER, Object, touched
from handlcp.lcp import Status
from handlcp.study.reliability.spread import Dimension

# ----------------------------------------------------------------
# The values of many samples as arrays, parameter by parameter.


@dataclass(frozen=True, slots=True)
class Values:
    """rows (m, d) : of m samples, in the order of the dimensions."""

    dimensions: Sequence[Dimension]
    rows: Array

    def one(self, parameter: str) -> list[float | None]:
        """(m,) of a parameter with one value; None where it does not vary."""
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == parameter:
                return list(column.tolist())
        return [None] * len(self.rows)

    def each(self, parameter: str, count: int, default: Array | float) -> Array | None:
        """(m, count) of a parameter with a value for each contact, joint or tip; None where it does not vary."""
        out: Array | None = None
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == parameter:
                if out is None:
                    out = np.broadcast_to(default, (len(self.rows), count)).astype(float)
                out[:, list(d.at) if d.at else slice(None)] = column[:, None]
        return out

    def shifts(self, count: int) -> Array | None:
        """(m, count, 2) of contacts along their tangents [m]; None where none moves."""
        out: Array | None = None
        for d, column in zip(self.dimensions, self.rows.T, strict=True):
            if d.parameter == "positions":
                out = np.zeros((len(self.rows), count, 2)) if out is None else out
                out[:, d.at[0], d.at[1]] = column
        return out


# ----------------------------------------------------------------
# Contacts slid along the object's surface, many at once.
#
# Past an edge of a box or a rim of a cylinder a contact has no normal: it is on two faces, and a fingertip rolls around
# the edge. Such a contact keeps its axes, and is named as one that is past an edge.

_TURNED = 1e-6  # of a normal that has one direction on a whole face: more is another face


def slid(positions: Array, frames: Array, shifts: Array, obj: Object | None) -> tuple[Array, Array, Bools]:
    """Positions (m, k, 3) and frames (m, k, 3, 3) of k contacts after m shifts (m, k, 2) [m] along their tangents, and
    which of them (m, k) are past an edge.

    On a ball, a box, a cylinder or an ellipsoid a contact stays on the surface, and its normal turns with that. On
    anything else, or without an object (None), it moves in its tangent plane, and keeps its normal.
    """
    m, k = len(shifts), len(positions)
    goal = positions + np.einsum("kab,mkb->mka", frames[:, :, :2], shifts)
    if obj is None or obj.known is None:
        return goal, np.broadcast_to(frames, (m, k, 3, 3)), np.zeros((m, k), bool)
    on, inward = _nearest(np.concatenate([positions, goal.reshape(-1, 3)]), obj)
    moved = positions + (on[k:].reshape(m, k, 3) - on[:k])
    turned = inward[k:].reshape(m, k, 3) - inward[:k]
    past = _past_an_edge(turned, obj)
    z = frames[:, :, 2] + np.where(past[..., None], 0.0, turned)
    z = z / np.sqrt((z * z).sum(axis=-1, keepdims=True))
    x = frames[:, :, 0] - z * (z * frames[:, :, 0]).sum(axis=-1, keepdims=True)
    x = x / np.sqrt((x * x).sum(axis=-1, keepdims=True))
    made = np.stack([x, np.cross(z, x), z], axis=-1)
    stays = (turned == 0.0).all(axis=-1) | past
    return moved, np.where(stays[..., None, None], frames, made), past


def _past_an_edge(turned: Array, obj: Object) -> Bools:
    """(m, k) from how normals (m, k, 3) have turned: on a box not at all; on a cylinder not towards its axis."""
    assert obj.known is not None
    kind, (R, _) = obj.known[0], obj.frame
    if kind == BOX:
        return np.asarray((abs(turned) > _TURNED).any(axis=-1))
    if kind == CYLINDER:
        return np.asarray(abs(turned @ R[:, 2]) > _TURNED)
    return np.zeros(turned.shape[:-1], bool)


def _nearest(points: Array, obj: Object) -> tuple[Array, Array]:
    """(n, 3) nearest points of the surface, and (n, 3) the normals into the object there."""
    assert obj.known is not None
    (kind, sizes), (R, p) = obj.known, obj.frame
    on, inward = np.empty_like(points), np.empty_like(points)
    touched(kind, sizes, R, p, points, np.zeros(len(points)), on, inward, np.empty(len(points)))
    return on, inward


# ----------------------------------------------------------------
# What becomes of many samples: held, over a torque limit, not held, or undecided; and by how much.
#
# margin = 1 - the larger of  Σ|f_T| / Σ μ f_N  over all contacts with friction,  and  max |τ| / τ_max
#
# The first is the share of all friction that is used: 1 where every contact slides. The margin is below 0 where a joint
# is over its limit, and there is none (NaN) where nothing holds the object.

SOLVE, CHECK = "solve", "check"
WORDS = (HELD, OVER_LIMIT, NOT_HELD, UNDECIDED)  # by their codes


@dataclass(frozen=True, slots=True)
class Outcomes:
    """codes (m,) : of `WORDS`. margin (m,). again (m,) : which samples were left by the solver's first stage, and were
    solved in full. unplaced (m,) : which ones are no grasp that could be judged; they are UNDECIDED.
    """

    codes: Ints
    margin: Array
    again: Bools
    unplaced: Bools


def joined(parts: Sequence[Outcomes]) -> Outcomes:
    """One after the other."""
    names = [one.name for one in fields(Outcomes)]
    return Outcomes(*[np.concatenate([getattr(p, name) for p in parts]) for name in names])


def among(found: Outcomes, placed: Bools) -> Outcomes:
    """Of all samples (m,), where `found` is of those that could be placed."""
    if placed.all():
        return found
    m = len(placed)
    codes, margin, again = np.full(m, WORDS.index(UNDECIDED)), np.full(m, np.nan), np.zeros(m, bool)
    codes[placed], margin[placed], again[placed] = found.codes, found.margin, found.again
    return Outcomes(codes, margin, again, ~placed)


def solved(grasps: Sequence[Grasp], faces: int | str | Pyramid, workers: int | None, decide: int) -> Outcomes:
    """By one certified solve each. decide : how many of those that the first stage leaves are solved in full."""
    found = solve_many(grasps, faces, workers=workers, proof=False)
    codes, margin = _codes(found), _margins(grasps, found)
    again = np.zeros(len(grasps), bool)
    chosen = np.flatnonzero(codes == WORDS.index(UNDECIDED))[:decide]
    if len(chosen):
        some = [grasps[k] for k in chosen.tolist()]
        fully = solve_many(some, faces, workers=workers)
        codes[chosen], margin[chosen], again[chosen] = _codes(fully), _margins(some, fully), True
    return Outcomes(codes, margin, again, np.zeros(len(grasps), bool))


def checked(grasps: Sequence[Grasp], faces: int | str | Pyramid) -> Outcomes:
    """By `Grasp.check` each, without its advice: squeezed, then loaded, contacts followed."""
    codes, margin = np.empty(len(grasps), np.int64), np.full(len(grasps), np.nan)
    for k, g in enumerate(grasps):
        section = as_section(faces, planar=g.scene.kind.planar)
        one = g.solve(faces, throw=False, proof=False)
        verdict = judged(g.spec, g.scene, section, ("squeeze", "load"), one)
        codes[k] = WORDS.index(verdict.word)
        path = verdict.loading
        end = one if path is None else path.solution if path.held else None
        if end is not None and end.held:
            margin[k] = margin_of(end)
    return Outcomes(codes, margin, np.zeros(len(grasps), bool), np.zeros(len(grasps), bool))


def margin_of(solution: GraspSolution) -> float:
    """Of one answer."""
    scene = solution.scene
    assert scene is not None  # every solution that is looked at here was made from one
    slack = friction_margin(scene, solution.forces, getattr(solution, "torsion", None))
    limit = float((scene.mu * scene.lawful(_padded(scene, solution.forces))[2 : 3 * scene.n : 3]).sum())
    used = 0.0 if limit <= 0.0 else 1.0 - float(np.nansum(slack)) / limit
    check = getattr(solution, "torque_check", None)
    return 1.0 - max(used, 0.0 if check is None else float(check.utilisation.max(initial=0.0)))


def _padded(scene: Any, forces: Array) -> Array:
    return np.append(forces, np.zeros(len(scene.soft)))


def _codes(found: Solutions) -> Ints:
    """(m,) of solutions: held ones are over a limit where a joint is."""
    codes = np.full(len(found), WORDS.index(UNDECIDED))
    names = found.status
    none = (names == Status.NOT_HOLDABLE.name) | (names == Status.NO_EQUILIBRIUM.name)
    codes[none] = WORDS.index(NOT_HELD)
    codes[found.held] = WORDS.index(HELD)
    codes[found.held & exceeded(_most_used(found))] = WORDS.index(OVER_LIMIT)
    return codes


def _most_used(found: Solutions) -> Array:
    """(m,) the largest utilisation of any joint; 0 without a hand or an answer."""
    if not len(found) or getattr(found[0], "torque_check", None) is None:
        return np.zeros(len(found))
    return np.asarray(np.nan_to_num(found.utilisation).max(axis=1, initial=0.0))


def _margins(grasps: Sequence[Grasp], found: Solutions) -> Array:
    """(m,) NaN where nothing is held."""
    if any(g.scene.scale is not None for g in grasps):  # forces in coordinates of their own: one by one
        return np.array([margin_of(s) if s.held else np.nan for s in found])
    forces, mu = found.forces, np.array([g.scene.mu for g in grasps])
    limit = (mu * forces[:, :, 2]).sum(axis=1)
    tangential = (np.hypot(forces[:, :, 0], forces[:, :, 1]) * (mu > 0.0)).sum(axis=1)
    used = np.divide(tangential, limit, out=np.zeros(len(grasps)), where=limit > 0.0)
    return np.where(found.held, 1.0 - np.maximum(used, _most_used(found)), np.nan)
