"""Least and largest forces against an oracle of its own, and against members that other solvers and seeds find."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from functools import cache
from typing import Any

import clarabel
import numpy as np
from scipy import sparse

import handlcp as hl
from tests.support.grasp import arrays, changed

__all__ = ["NEAR", "examine", "grasps", "outside"]

NEAR = 1e-6  # of the forces: what an oracle and a perturbed solver may be off by
_REST = 1e-7


# ---------------------------------------------------------------- random grasps that leave forces open
def points(rng: np.random.Generator, count: int, mu: float) -> list[hl.Contact]:
    """On a box, normals inwards."""
    found = []
    for _ in range(count):
        axis, side = rng.integers(3), rng.choice([-1.0, 1.0])
        p = rng.uniform(-0.03, 0.03, 3)
        p[axis] = 0.03 * side
        n = np.zeros(3)
        n[axis] = -side
        found.append(hl.Contact(p, n, hl.Coulomb(mu) if mu else hl.Frictionless()))
    return found


def grasps(seed: int) -> Any:
    """One of five kinds: all is rigid; fingers and a rigid environment; joints without pads; almost rigid; a hand."""
    rng, kind = np.random.default_rng(seed), seed % 5
    n, mu = int(rng.integers(4, 13)), float(rng.choice([0.3, 0.6, 1.0]))
    wrench = np.append(rng.normal(size=3), 0.01 * rng.normal(size=3)) * 5.0
    contacts = points(rng, n, mu)
    if kind == 1:
        k = n // 2
        rigid = hl.Environment(contacts[k:])
        return hl.Grasp(contacts[:k], wrench, flexibility=1e-4, preload=2e-3, environment=rigid)
    if kind == 2:
        J = rng.normal(size=(3 * n, int(rng.integers(2, 6)))) * 0.05
        pushed = (-J @ abs(rng.normal(size=J.shape[1])) * 0.02).reshape(n, 3)
        return hl.Grasp(contacts, wrench, flexibility=J @ J.T / 5.0, offset=pushed)
    if kind == 4:
        return held_by_a_hand(rng, mu)
    E = 1e-12 * np.diag(rng.uniform(0.5, 2.0, 3 * n)) if kind == 3 else 0.0
    return hl.Grasp(contacts, wrench, flexibility=E)


@cache
def closed(name: str, what: int) -> tuple[Any, Any]:
    """An object, and the posture in which a shipped hand touches it."""
    place = (0, 0, 0.08)
    obj = [hl.Box(0.05, place, mass=0.2), hl.Cylinder(0.025, 0.05, place, 0.3), hl.Sphere(0.03, place, mass=0.2)][what]
    return obj, hl.example_hand(name, joint_stiffness=6.0).close_on(obj)


def held_by_a_hand(rng: np.random.Generator, mu: float) -> Any:
    """A shipped hand without pads, with some rigid joints, perhaps with a single actuator, over a rigid table."""
    name = str(rng.choice(["three_finger", "five_finger"]))
    obj, q = closed(name, int(rng.integers(3)))
    joints = hl.example_hand(name, joint_stiffness=6.0).joint_names
    stiffness: Any = {joint: np.inf if rng.random() < 0.5 else 6.0 for joint in joints}
    if rng.random() < 0.3:
        stiffness = hl.Synergies(np.ones((len(joints), 1)), 6.0)
    hand = hl.example_hand(name, joint_stiffness=stiffness, pad_flexibility=0.0)
    under = hl.Table((0, 0, 0.055)) if rng.random() < 0.8 else None
    push = float(rng.choice([0.0, 1e-3]))
    return hand.at(q).grasp(obj, hl.Coulomb(mu), preload=push, environment=under)


# ---------------------------------------------------------------- the oracle: the laws over all forces and motions
def _choices(s: hl.GraspSolution) -> Iterator[tuple[str, ...]]:
    """Contact states, with what touches without force sticking ("pushing" where it slips) or separated; "any" where
    there are many of them.
    """
    slow = _REST * max(s.residuals.motion_scale, arrays(s).units.motion_unit)
    rest = [i for i, state in enumerate(s.contact_state) if state == "separated" and s.gap[i] <= slow]
    ways = itertools.product(("separated", "sticking"), repeat=len(rest)) if len(rest) <= 4 else [("any",) * len(rest)]
    for way in ways:
        states = list(s.contact_state)
        for i, state in zip(rest, way, strict=True):
            slips = np.linalg.norm(s.slip[i]) > slow
            states[i] = "pushing" if state == "sticking" and slips else state
        yield tuple(states)


class Oracle:
    """The largest of a linear reading of forces with these contact states, by Clarabel over (r, u), natural units."""

    def __init__(self, s: hl.GraspSolution, states: tuple[str, ...], faces: int, wider: tuple[str, ...]) -> None:
        g, n = arrays(s), len(s.names)
        self.F, L, D = g.units.force_unit, g.units.length_unit, g.units.motion_unit
        T = np.diag([1.0] * 3 + [1.0 / L] * 3)
        G, E = T @ g.grasp_matrix[:, : 3 * n], np.asarray(g.flexibility)[: 3 * n, : 3 * n] * self.F / D
        d, w = np.asarray(g.offset).reshape(-1)[: 3 * n] / D, T @ np.asarray(g.wrench) / self.F
        V = np.hstack([E, G.T])
        R = np.eye(3 * n, 3 * n + 6)
        equal, right, lines, room, cones, more = [np.hstack([G, np.zeros((6, 6))])], [-w], [], [], [], []
        for i, state in enumerate(states):
            x, z, mu = [3 * i, 3 * i + 1], 3 * i + 2, float(g.mu[i])
            if state != "any":
                rows = R[3 * i : z + 1] if state == "separated" else V[[z]]
                equal.append(rows)
                right.append(np.zeros(3) if state == "separated" else -d[[z]])
            if state in ("separated", "any"):
                lines.append(V[[z]])
                room.append(d[[z]])
            if state == "separated":
                continue
            lines.append(R[[z]])
            room.append(np.zeros(1))
            if mu == 0.0:
                equal.append(R[x])
                right.append(np.zeros(2))
                continue
            a = 2 * np.pi * np.arange(faces) / max(faces, 1)
            normals = np.column_stack([np.cos(a), np.sin(a)])
            reach = mu * (np.cos(np.pi / faces) if faces else 1.0)
            if state == "sliding" and (faces or s.names[i] not in wider):
                if faces:
                    used = normals @ s.forces[i, :2] / (reach * s.forces[i, 2])
                    on = normals[used > 1.0 - 1e-6]
                else:
                    on = -s.slip[[i]] / np.linalg.norm(s.slip[i])
                slow = _REST * max(s.residuals.motion_scale, D)
                kept = on[-np.linalg.pinv(on.T) @ s.slip[i] > slow]
                equal.append(kept @ R[x] - reach * R[z])
                right.append(np.zeros(len(kept)))
                lines.append(-np.linalg.pinv(on.T) @ V[x])
                room.append(-np.linalg.pinv(on.T) @ d[x])
                if len(on) == 1:
                    across = np.array([[-on[0, 1], on[0, 0]]])
                    equal.append(across @ V[x])
                    right.append(-across @ d[x])
                    if not faces:
                        equal.append(across @ R[x])
                        right.append(np.zeros(1))
                        continue
            elif state == "sticking":
                equal.append(V[x])
                right.append(-d[x])
            if faces:
                lines.append(reach * R[z] - normals @ R[x])
                room.append(np.zeros(faces))
            else:
                more.append(np.vstack([mu * R[z], R[x]]))
                cones.append(3)
        A, b = np.concatenate(equal), np.concatenate(right)
        B, h = np.concatenate(lines), np.concatenate(room)
        curved = np.concatenate([np.zeros((0, 3 * n + 6)), *more])
        self.rows = sparse.csc_matrix(np.concatenate([A, -B, -curved]))
        self.right = np.concatenate([b, h, np.zeros(len(curved))])
        self.cones = [
            clarabel.ZeroConeT(len(b)),
            clarabel.NonnegativeConeT(len(h)),
            *map(clarabel.SecondOrderConeT, cones),
        ]

    def most(self, along: np.ndarray) -> tuple[str, np.ndarray]:
        """(status, forces (n, 3) [N]) at the largest along · r, along (3n,)."""
        v, settings = self.rows.shape[1], clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
        cost = np.zeros(v)
        cost[: len(along)] = -along
        nothing = sparse.csc_matrix((v, v))
        found = clarabel.DefaultSolver(nothing, cost, self.rows, self.right, self.cones, settings).solve()
        return str(found.status), np.array(found.x)[: len(along)].reshape(-1, 3) * self.F


# ---------------------------------------------------------------- one grasp
def outside(bounds: hl.ForceBounds, forces: np.ndarray, size: float) -> float:
    """By how much forces (n, 3) lie outside, of their size."""
    low, high = bounds.forces[..., 0], bounds.forces[..., 1]
    return float(max((low - forces).max(), (forces - high).max(), 0.0)) / max(size, float(abs(forces).max()))


def _same_states(a: hl.GraspSolution, b: hl.GraspSolution, bounds: hl.ForceBounds) -> bool:
    """Whether b keeps the states of a, directions of sliding included, but where these may turn."""
    if a.contact_state != b.contact_state:
        return False
    for name, state, one, other in zip(a.names, a.contact_state, a.slip, b.slip, strict=True):
        if state == "sliding" and name not in bounds.wider:
            size = np.linalg.norm(one) * np.linalg.norm(other)
            if size == 0.0 or one @ other < (1.0 - 1e-9) * size:
                return False
    return True


def examine(grasp: Any, faces: Any, seed: int, readings: int = 4) -> Counter[str]:
    """What was compared of one grasp. Raises AssertionError where it lies outside, or a bound is not attained."""
    rng, count = np.random.default_rng(seed), Counter[str]()
    s = grasp.solve(faces, throw=False)
    if not s.held:
        return Counter({"not held": 1})
    bounds = s.force_bounds()
    n, size = len(s.names), arrays(s).units.force_unit
    assert outside(bounds, s.forces, size) <= 0.0
    if not bounds.open:
        np.testing.assert_allclose(bounds.normal, s.normal_force[:, None] * [1.0, 1.0], rtol=0.0, atol=1e-12 * size)
    count["open" if bounds.open else "determined"] += 1
    count["wider"] += bool(bounds.wider)
    count["unbounded"] += bool(np.isinf(bounds.normal).any())
    m = 0 if faces == "cone" else int(faces)
    oracles = [Oracle(s, states, m, bounds.wider) for states in _choices(s)]
    for _ in range(readings):
        along = rng.normal(size=3 * n)
        for o in oracles:
            status, forces = o.most(along)
            if status == "Solved":
                assert outside(bounds, forces, size) < NEAR, (seed, faces, outside(bounds, forces, size))
                count["members"] += 1
    every, rows = bounds.forces.reshape(3 * n, 2), np.eye(3 * n)
    if bounds.joints:
        every, rows = np.concatenate([every, bounds.torques]), np.concatenate([rows, 20.0 * grasp.jacobian.T])
        every[3 * n :] *= 20.0  # torques as forces at levers of 5 cm
    for k in rng.permutation(2 * len(rows))[:readings].tolist():
        i, side = k // 2, k % 2
        along = rows[i] * (1.0 if side else -1.0)
        bound, best = every[i, side], -np.inf
        ends = [o.most(along) for o in oracles]
        if any(status not in ("Solved", "DualInfeasible", "PrimalInfeasible") for status, _ in ends):
            continue
        for status, forces in ends:
            value = np.inf if status == "DualInfeasible" else float(forces.reshape(-1) @ along)
            best = max(best, value if status != "PrimalInfeasible" else -np.inf)
        if best == -np.inf:
            continue
        most = bound if side else -bound
        near = most == best if np.isinf(best) else abs(most - best) <= NEAR * max(size, abs(best))
        assert near, (seed, faces, i, side, most, best)
        count["bounds attained"] += 1
    for other in _others(grasp, faces, rng):
        if other.held and _same_states(s, other, bounds):
            assert outside(bounds, other.forces, size) < NEAR, (seed, faces, outside(bounds, other.forces, size))
            count["other solvers"] += 1
    return count


def _others(grasp: Any, faces: Any, rng: np.random.Generator) -> Iterator[hl.GraspSolution]:
    """From other seeds, and with all that is rigid a little soft."""
    for seed in (2, 3):
        yield grasp.solve(faces, solver=hl.Auto(seed=seed), throw=False)
    E = arrays(grasp).flexibility
    size = 1e-9 * (float(np.diagonal(E).mean()) or 1e-3)
    for _ in range(3):
        more = np.diag(size * 10.0 ** rng.uniform(-1, 1, len(E)))
        yield changed(grasp, flexibility=E + more).solve(faces, throw=False)
