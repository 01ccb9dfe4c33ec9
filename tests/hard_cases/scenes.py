"""Cases and two ways to make them so that an answer is known: backwards from a solution, or contact by contact."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

import numpy as np

import handlcp as hl
from tests.support.escapes import escapes
from tests.support.friction_sets import corners, limit, reach
from tests.support.laws import of_case, spread

FACES = (4, 8, 16, "cone")
HARD = os.environ.get("HANDLCP_HARD") == "1"
ENOUGH = 1e-7  # a SOLVED answer must satisfy every law to this


def count(default):
    """Scenes of a family: few by default, twenty times as many with HANDLCP_HARD=1."""
    return default * (20 if HARD else 1)


@dataclass(frozen=True)
class Case:
    """A scene as plain arrays, SI, about the origin, and what must come out.

    p (n, 3), R (n, 3, 3) columns x, y, z, mu (n,), E (3n, 3n), d (n, 3), w (6,), faces, plane (3,) or None.
    answer: "solvable", "not holdable", "no equilibrium" (holdable all the same). forces (n, 3): where they are unique.
    """

    name: str
    p: np.ndarray
    R: np.ndarray
    mu: np.ndarray
    E: np.ndarray
    d: np.ndarray
    w: np.ndarray
    faces: int | str
    plane: np.ndarray | None = None
    answer: str = "solvable"
    forces: np.ndarray | None = None

    @property
    def reference(self):
        """(3,) what the package is told to refer to: the origin, but a point of the plane in planar scenes."""
        return np.zeros(3) if self.plane is None else self.p.mean(0)

    def grasp(self):
        """The same for the package."""
        contacts = [
            hl.Contact(p, R[:, 2], hl.Coulomb(mu), tangent=R[:, 0])
            for p, R, mu in zip(self.p, self.R, self.mu.tolist(), strict=True)
        ]
        w, c = self.w, self.reference
        w = np.r_[w[:3], w[3:] - np.cross(c, w[:3])]
        if self.plane is not None:
            w[3:] = self.plane * (self.plane @ w[3:])
        return hl.Grasp(contacts, w, flexibility=self.E, offset=self.d, reference=c, plane=self.plane)

    def solve(self):
        """Whatever comes out."""
        return self.grasp().solve(self.faces, throw=False)


@dataclass
class Report:
    """Names of the cases by what became of them; `wrong` with the reason."""

    solved: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    undecided: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def demand(self):
        """Nothing wrong, nothing undecided."""
        assert not self.wrong, f"{len(self.wrong)} wrong: {self.wrong}"
        assert not self.undecided, f"{len(self.undecided)} undecided: {self.undecided}"
        assert self.solved or self.refused, "no case at all"


def verdict(case, s):
    """("solved" | "refused" | "undecided" | "wrong", why)."""
    if s.status is hl.Status.SOLVED:
        if case.answer != "solvable":
            return "wrong", f"SOLVED, but it is {case.answer}"
        missed = of_case(case, s)
        if not missed.worst < ENOUGH:
            return "wrong", f"{missed}"
        if case.forces is not None:
            off = abs(s.forces - case.forces).max() / (abs(case.forces).max() or 1.0)
            if not off < ENOUGH:
                return "wrong", f"forces off by {off:.1e}, residual {missed.worst:.1e}"
        return "solved", ""
    if s.status is hl.Status.NOT_HOLDABLE:
        if case.answer != "not holdable":
            return "wrong", f"NOT_HOLDABLE, but it is {case.answer}"
        return ("refused", "") if escapes(case, s.certificate) else ("wrong", "the certificate proves nothing")
    if case.answer == "no equilibrium":  # undecided is honest here, if poor
        return "refused", s.status.name
    if s.status is hl.Status.NO_EQUILIBRIUM:
        return "wrong", f"NO_EQUILIBRIUM, but it is {case.answer}"
    return "undecided", ""


def examine(cases):
    """Solve and judge all of them."""
    report = Report()
    for case in cases:
        kind, why = verdict(case, case.solve())
        getattr(report, kind).append(f"{case.name} ({why})" if kind == "wrong" else case.name)
    return report


# ---------------------------------------------------------------- geometry
def turn(rng):
    """(3, 3) random rotation."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Q * np.sign(np.linalg.det(Q))


def frames(z, x=None, rng=None):
    """(n, 3, 3) frames with the normals z (n, 3) and tangents near x (n, 3), random ones when None."""
    z = np.asarray(z, float)
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    x = rng.normal(size=z.shape) if x is None else np.asarray(x, float)
    x = x - z * (x * z).sum(1, keepdims=True)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def around(rng, n, radius=0.03, rough=1.0):
    """(p, R): n contacts around a waist, pushing inwards, attitude and place random."""
    t = 2 * np.pi * (np.arange(n) + 0.2 * rough * rng.uniform(-1, 1, n)) / n
    Q, c = turn(rng), rng.uniform(-0.1, 0.1, 3)
    out = np.column_stack([np.cos(t), np.sin(t), np.zeros(n)])
    p = (out + np.column_stack([np.zeros((n, 2)), 0.3 * rough * rng.uniform(-1, 1, n)])) * radius
    z = -out + np.column_stack([np.zeros((n, 2)), 0.1 * rough * rng.uniform(-1, 1, n)])
    return p @ Q.T + c, frames(z @ Q.T, rng=rng)


def ball(rng, n, radius=0.03):
    """(p, R): n contacts all over a ball."""
    out = rng.normal(size=(n, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    return out * radius + rng.uniform(-0.1, 0.1, 3), frames(-out, rng=rng)


def wrench_map(p, R):
    """(6, 3n) contact forces to the wrench about the origin."""
    return np.hstack([np.vstack([Q, np.cross(a, Q.T).T]) for a, Q in zip(p, R, strict=True)])


def fingers(rng, n, rank=2, pad=(2e-4, 2e-4, 1e-4), shared=False, lever=0.05):
    """(3n, 3n) J Jᵀ of `rank` joints a finger (1 N·m/rad), one more for all when `shared`; pads."""
    J = np.zeros((3 * n, rank * n + 1))
    for i in range(n):
        J[3 * i : 3 * i + 3, rank * i : rank * (i + 1)] = rng.normal(size=(3, rank)) * lever
    if shared:
        J[:, -1] = 0.4 * lever * rng.normal(size=3 * n)
    return J @ J.T + np.diag(np.tile(pad, n))


# ---------------------------------------------------------------- backwards from a solution
STATES = ("stick", "slide", "corner", "limit", "touch", "open")


def at_contact(rng, state, mu, faces, force, travel):
    """(f, v) of one contact in `state`: forces of about `force` newtons, slips and gaps of about `travel` metres.

    stick: inside. slide: against a side, on the limit. corner: at a corner, against both of its sides. limit: on the
    limit without slip. touch: no force, no gap, no slip. graze: no force, no gap, but slip. open: a gap.
    """
    f, v = np.zeros(3), np.zeros(3)
    if state in ("touch", "graze", "open"):
        v[2] = travel * rng.uniform(0.5, 2) if state == "open" else 0.0
        if state != "touch":
            v[:2] = travel * rng.normal(size=2)
        return f, v
    push, r = force * rng.uniform(1, 5), reach(mu, faces)
    f[2] = push
    if mu == 0:
        v[:2] = travel * rng.normal(size=2)
    elif faces == 2:
        side = rng.choice([-1.0, 1.0])
        f[0] = side * r * push * (1.0 if state != "stick" else rng.uniform(0, 0.9))
        v[0] = -side * travel * rng.uniform(0.5, 2) if state in ("slide", "corner") else 0.0
    elif faces == "cone":
        a = rng.uniform(0, 2 * np.pi)
        out = np.array([np.cos(a), np.sin(a)])
        f[:2] = r * push * out * (1.0 if state != "stick" else rng.uniform(0, 0.9))
        v[:2] = -travel * rng.uniform(0.5, 2) * out if state in ("slide", "corner") else 0.0
    else:
        k, C = int(rng.integers(faces)), corners(faces)
        one, two = C[k - 1], C[k]  # the ends of side k
        side = np.array([np.cos(2 * np.pi * k / faces), np.sin(2 * np.pi * k / faces)])
        past = np.array([np.cos(2 * np.pi * (k + 1) / faces), np.sin(2 * np.pi * (k + 1) / faces)])
        s = rng.uniform(0.1, 0.9)
        if state == "stick":
            f[:2] = r * push * rng.uniform(0, 0.9) * (one + s * (two - one))
        elif state == "corner" or (state == "limit" and rng.random() < 0.5):
            f[:2] = r * push * two
            if state == "corner":
                v[:2] = -travel * (rng.uniform(0.2, 1) * side + rng.uniform(0.2, 1) * past)
        else:
            f[:2] = r * push * (one + s * (two - one))
            if state == "slide":
                v[:2] = -travel * rng.uniform(0.5, 2) * side
    return f, v


def backwards(name, rng, p, R, mu, E, faces, states=None, force=1.0, travel=None, twist=None, plane=None, unique=False):
    """A case with the solution that these states have: the offsets and the wrench are what it takes."""
    n, section = len(p), 2 if plane is not None else faces
    mu = np.broadcast_to(np.asarray(mu, float), (n,)).copy()
    soft = float(np.trace(E)) / (3 * n)
    travel = (soft * force if soft > 0 else 1e-3) if travel is None else travel
    states = rng.choice(STATES, n) if states is None else states
    f, v = np.array([at_contact(rng, s, m, section, force, travel) for s, m in zip(states, mu, strict=True)]).transpose(
        1, 0, 2
    )
    c, L = p.mean(0), spread(p)
    if twist is None:
        twist = travel * np.r_[rng.normal(size=3), rng.normal(size=3) / L]
        if plane is not None:
            twist = np.r_[twist[:3] - plane * (plane @ twist[:3]), plane * (plane @ twist[3:])]
    G = wrench_map(p - c, R)
    d = v - (G.T @ twist + E @ f.ravel()).reshape(n, 3)
    if plane is not None:
        d[:, 1] = 0.0
    w = -G @ f.ravel()
    w = np.r_[w[:3], w[3:] + np.cross(c, w[:3])]
    return Case(name, p, R, mu, E, d, w, faces, plane, forces=f if unique else None)


# ---------------------------------------------------------------- contact by contact
def springs(name, p, R, mu, soft, faces, d, twist, plane=None, unique=False):
    """Fingers that bend on their own, soft (n, 2): tangential and normal flexibility. For any motion `twist` of the
    object about the contacts' centre each force is a formula: the normal spring pushes or lets go, the tangential one
    is cut off at the limit. The load is what balances them.
    """
    n, section = len(p), 2 if plane is not None else faces
    mu = np.broadcast_to(np.asarray(mu, float), (n,)).copy()
    soft = np.broadcast_to(np.asarray(soft, float), (n, 2))
    c = p.mean(0)
    G = wrench_map(p - c, R)
    s = (G.T @ twist).reshape(n, 3) + d
    f = np.zeros((n, 3))
    f[:, 2] = np.maximum(0.0, -s[:, 2] / soft[:, 1])
    for i in range(n):
        f[i, :2] = limit(mu[i], section).nearest(-s[i, :2] / soft[i, 0], f[i, 2])
    E = np.diag(soft[:, [0, 0, 1]].ravel())
    w = -G @ f.ravel()
    w = np.r_[w[:3], w[3:] + np.cross(c, w[:3])]
    return Case(name, p, R, mu, E, d, w, faces, plane, forces=f if unique else None)
