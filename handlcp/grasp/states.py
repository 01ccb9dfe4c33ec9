"""What each contact does at an answer: separated, sticking or sliding, and against which faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import Verdict
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.lcp.kernels.compile import kernel
from handlcp.tolerances import ACTIVE

__all__ = ["GLIDING", "NAMES", "RESTING", "SEPARATED", "SLIDING", "STICKING", "VERTEX", "States", "classify"]

# VERTEX slides against two faces at once, GLIDING pushes without friction, RESTING touches without pushing
SEPARATED, STICKING, SLIDING, VERTEX, GLIDING, RESTING = 0, 1, 2, 3, 4, 5
NAMES = ("separated", "sticking", "sliding", "sliding", "sliding", "separated")


@dataclass(frozen=True, slots=True)
class States:
    """kind (n,) int: one of the constants above. faces (n, 2, 2): outward normals, in rows, that it slides against.
    turn (n,): slip over friction [m/N] of a contact that slides on the exact cone, where both turn together; else 0.
    soft (k,): for each soft contact the outward normals (3, j) of its limit surface that it slides against.
    """

    kind: Ints
    faces: Array
    turn: Array
    soft: tuple[Array, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """For each contact "separated", "sticking" or "sliding"."""
        return tuple(NAMES[k] for k in self.kind.tolist())


def classify(scene: Scene, section: Section, candidate: Candidate, verdict: Verdict) -> States:
    """States of all contacts, of a candidate that was judged."""
    forces, motion, residuals = candidate.forces, verdict.motion, verdict.residuals
    planar = scene.plane is not None
    limits = section.limit(scene.mu)
    slow = ACTIVE * max(residuals.motion_scale, scene.units.motion)
    kind, faces, turn = classify_contacts(
        forces, motion, limits, section.normals, section.faces == 0, planar, ACTIVE * residuals.force_scale, slow
    )
    if not all(scene.governed):
        kind[~scene.governed_mask] = STICKING  # a finger under force control follows the object
    if not scene.soft:
        return States(kind, faces, turn)
    surface, weak, soft = limit_surface(section), ACTIVE * residuals.force_scale, []
    bounds = surface.limit(scene.mu)
    for k, (i, at) in enumerate(zip(scene.soft, scene.soft_index.tolist(), strict=True)):
        r, slip, normals = candidate.components[at], np.append(motion[i, :2], verdict.turn[k]), _NO_NORMAL
        if forces[i, 2] > weak:
            kind[i], turn[i] = STICKING, 0.0
            size, speed = float(np.sqrt(r @ r)), float(np.sqrt(slip @ slip))
            if speed > slow and size > 0.0:
                kind[i] = SLIDING
                if surface.exact:
                    normals, turn[i] = r[:, None] / size, speed / size
                else:
                    normals = surface.normals[:, bounds[i] * forces[i, 2] - surface.normals.T @ r <= weak][:, :3]
        soft.append(normals)
    return States(kind, faces, turn, tuple(soft))


_NO_NORMAL = np.zeros((3, 0))


@kernel
def classify_contacts(
    forces: Array, motion: Array, limits: Array, normals: Array, cone: bool, planar: bool, weak: float, slow: float
) -> tuple[Ints, Array, Array]:
    n, m = len(forces), normals.shape[1]
    kind, faces, turn = np.zeros(n, np.int64), np.zeros((n, 2, 2)), np.zeros(n)
    for i in range(n):
        r = forces[i]
        slip = abs(motion[i, 0]) if planar else np.hypot(motion[i, 0], motion[i, 1])
        if not r[2] > weak:
            kind[i] = RESTING if motion[i, 2] <= slow else SEPARATED
        elif limits[i] <= 0.0:
            kind[i] = GLIDING
        elif not slip > slow:
            kind[i] = STICKING
        elif cone:  # one face, the tangent plane at the force
            size = np.hypot(r[0], r[1])
            if size == 0.0:  # a friction too small for a float64 acts like none
                kind[i] = GLIDING
                continue
            kind[i], faces[i, 0, 0], faces[i, 0, 1] = SLIDING, r[0] / size, r[1] / size
            turn[i] = slip / size
        else:
            found = 0
            for j in range(m):
                if limits[i] * r[2] - normals[0, j] * r[0] - normals[1, j] * r[1] <= weak and found < 2:
                    faces[i, found, 0], faces[i, found, 1] = normals[0, j], normals[1, j]
                    found += 1
            kind[i] = VERTEX if found == 2 else SLIDING
    return kind, faces, turn
