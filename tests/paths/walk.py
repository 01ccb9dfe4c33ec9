"""The path of a load in one posture where friction has flat faces, walked from change to change with numpy alone.

Between two changes all is linear in the load. Contacts that press deform and slip, E ḟ + Gᵀ u̇ = -Sᵀ λ; balance stays,
G ḟ = -w; a face of friction at its limit slips or is left behind, 0 ≤ λ ⟂ -A ḟ ≥ 0. Every choice of faces that slip is
tried: one goes on, and where none does the path ends. Forces and flexibility are in the coordinates in which laws are
round, as `Grasp.scene` has them.
"""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from handlcp.contact.friction import as_section, limit_set
from tests.paths.corpus import accepted, case_of

_AT, _SIGN, _SINGULAR = 1e-8, 1e-9, 1e-12
_MOST_FACES, _MOST_CHANGES = 14, 200


class Undetermined(Exception):
    """More than one choice goes on, or there are too many, or forces are not determined."""


class _Face(NamedTuple):
    """Of a contact's law: f · slips ≤ its limit, as f · pushes ≤ 0."""

    contact: int
    pushes: np.ndarray
    slips: np.ndarray


class PostureWalk:
    """A grasp in one posture, and a load (6,) that grows. Without it: forces (n, 3) [N], torsion (n,) [N·m], gaps (n,)
    of contacts that are open [m].
    """

    def __init__(
        self, grasp: Any, load: np.ndarray, faces: int, forces: np.ndarray, torsion: np.ndarray, gaps: np.ndarray
    ) -> None:
        scene = grasp.scene
        self.n, soft, scale = scene.n, list(scene.soft), scene.scale
        rows = np.zeros(3 * self.n + len(soft))
        self.owner = np.array([*np.repeat(np.arange(self.n), 3), *soft])
        arms = scene.positions - grasp.spec.reference
        frames = scene.frames.transpose(0, 2, 1).reshape(-1, 3)
        self.G = np.zeros((6, len(rows)))
        self.G[:3, : 3 * self.n] = frames.T
        self.G[3:, : 3 * self.n] = np.cross(arms[self.owner[: 3 * self.n]], frames).T
        for k, i in enumerate(soft):
            self.G[3:, 3 * self.n + k] = grasp.spec.frames[i][:, 2] * scale[3 * self.n + k]
        self.E, self.load = scene.flexibility, load
        self.f = np.append(forces.reshape(-1), torsion[soft]) / (1.0 if scale is None else scale)
        self.gaps = {i: float(gaps[i]) for i in range(self.n) if not self.f[3 * i + 2] > 0.0}
        self.factor, self.faces = 0.0, list[_Face]()
        for i in range(self.n):
            tangents = [3 * i, 3 * i + 1, *[3 * self.n + k for k, j in enumerate(soft) if j == i]]
            law = limit_set(as_section(faces), len(tangents))
            for normal in law.normals.T if scene.mu[i] > 0.0 else ():
                slips = rows.copy()
                slips[tangents] = normal
                pushes = slips.copy()
                pushes[3 * i + 2] = -law.share * scene.mu[i]
                self.faces.append(_Face(i, pushes, slips))

    def end(self) -> float:
        """The factor at which no choice goes on; inf where nothing ends it. Raises Undetermined."""
        for _ in range(_MOST_CHANGES):
            if not self._go_on():
                return self.factor
            if not np.isfinite(self.factor):
                return np.inf
        raise Undetermined("changes")

    def _go_on(self) -> bool:
        """To the next change; whether anything goes on."""
        used, largest = np.array([face.pushes @ self.f for face in self.faces]), abs(self.f).max()
        closed = ~np.isin(self.owner, list(self.gaps))
        pressed = np.array([face.contact not in self.gaps for face in self.faces])
        at = np.flatnonzero(pressed & (used > -_AT * largest))
        rates = self._rates([self.faces[k] for k in at], np.flatnonzero(closed))
        if not rates:
            return False
        if len(rates) > 1:
            raise Undetermined("choices")
        (force, gap), (step, who) = rates[0], (np.inf, -1)
        for k in np.flatnonzero(pressed):
            grows = self.faces[k].pushes @ force
            if k not in at and grows > _SIGN * abs(force).max():
                step, who = min((step, who), (max(-used[k] / grows, 0.0), -1))
        for i in range(self.n):
            if i in self.gaps and gap[i] < 0.0:
                step, who = min((step, who), (self.gaps[i] / -gap[i], i))
            elif i not in self.gaps and force[3 * i + 2] < 0.0:  # faces meet where it opens
                opens = -self.f[3 * i + 2] / force[3 * i + 2]
                step, who = (opens, i) if opens <= step * (1.0 + _SIGN) else (step, who)
        self.factor += step
        if np.isfinite(step):
            self.f = self.f + step * force
            self.gaps = {i: one + step * gap[i] for i, one in self.gaps.items()}
            if who in self.gaps:
                del self.gaps[who]
            elif who >= 0:
                self.gaps[who] = 0.0
                self.f[self.owner == who] = 0.0
        return True

    def _rates(self, faces: list[_Face], closed: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """(forces (c,), gaps (n,)) by the factor, of each choice of faces that slip."""
        m, a = len(closed), len(faces)
        if a > _MOST_FACES:
            raise Undetermined("faces")
        K = np.zeros((m + 6, m + 6))
        K[:m, :m], K[:m, m:], K[m:, :m] = self.E[np.ix_(closed, closed)], self.G[:, closed].T, self.G[:, closed]
        size = np.sqrt(abs(self.E).max())
        units = np.append(np.full(m, 1.0 / size), np.full(6, size))
        K *= units[:, None] * units
        if np.linalg.cond(K) > 1.0 / _SINGULAR:
            raise Undetermined("forces")
        inverse = np.linalg.inv(K) * units[:, None] * units  # of an oracle: small, and asked for many right sides
        A = np.array([face.pushes[closed] for face in faces]).reshape(a, m)
        S = np.array([face.slips[closed] for face in faces]).reshape(a, m)
        alone, by_slip = inverse @ np.append(np.zeros(m), -self.load), -inverse[:, :m] @ S.T
        q, M, found = -A @ alone[:m], -A @ by_slip[:m], list[tuple[np.ndarray, np.ndarray]]()
        for chosen in itertools.product((False, True), repeat=a):
            slip, those = np.zeros(a), np.flatnonzero(chosen)
            if len(those):
                part = M[np.ix_(those, those)]
                if np.linalg.cond(part) > 1.0 / _SINGULAR:
                    continue
                slip[those] = np.linalg.solve(part, -q[those])
            x, force = alone + by_slip @ slip, np.zeros(len(self.owner))
            force[closed] = x[:m]
            largest = abs(force).max()
            if (slip < -_SIGN * abs(slip).max(initial=0.0)).any() or (q + M @ slip < -1e-7 * largest).any():
                continue
            gap = (self.G.T @ x[m:] + self.E @ force)[2 : 3 * self.n : 3]
            if not any(np.allclose(force, other, atol=1e-6 * largest) for other, _ in found):
                found.append((force, gap))
        return found


def walk_of(case: Any, load: np.ndarray) -> PostureWalk:
    """That of a case of the corpus, from its squeeze and weight on."""
    grasp = case.grasp
    nothing = None if grasp.spec.mechanism is None else np.zeros(6)  # bare contacts keep their own wrench
    begin = grasp.follow(nothing, geometry="fixed", faces=case.faces).last.read
    return PostureWalk(grasp, load, case.faces, begin.forces, begin.torsion, begin.motion[:, 2])


def difference(case: Any, load: np.ndarray) -> tuple[float, float, float] | None:
    """(how far the limit of the package in one posture is off the walk's end, as a share; both); None: nothing is held
    without load. A torque limit only has to come before the end. Raises Undetermined.
    """
    case = case if case.geometry == "fixed" else case.in_posture()
    limit = case.grasp.load_limit(load, geometry="fixed", faces=case.faces, max_slip=np.inf)
    if limit.factor == 0.0:
        return None
    end = walk_of(case, load).end()
    short = limit.factor <= end and any(bind.kind == "torque" for bind in limit.binds)
    off = 0.0 if short or limit.factor == end else limit.factor / end - 1.0
    return off, limit.factor, end


def measure(seed: int, start: int, grasps: int, directions: int, within: float) -> int:
    """Limits in one posture beside the walk's: grasps of the corpus with six faces. How many differ by more."""
    counts, offs = dict.fromkeys(("agree", "differ", "undetermined", "not held"), 0), list[float]()
    for number in [n for n in accepted()[str(seed)] if case_of(seed, n).faces == 6][start : start + grasps]:
        case = case_of(seed, number)
        for k, load in enumerate(case.directions[:directions]):
            try:
                found = difference(case, load)
            except Undetermined:
                counts["undetermined"] += 1
                continue
            if found is None:
                counts["not held"] += 1
                continue
            counts["differ" if abs(found[0]) > within else "agree"] += 1
            if abs(found[0]) > within:
                offs.append(abs(found[0]))
                print(
                    f"{case.name}, direction {k}: {found[1]:.9g}, the walk {found[2]:.9g}, {found[0]:.1e}", flush=True
                )
    print(counts, {f"above {x:g}": sum(off > x for off in offs) for x in (1e-4, 1e-3, 1e-2, 1e-1)})
    return counts["differ"]
