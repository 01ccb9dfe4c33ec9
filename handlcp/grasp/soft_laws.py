"""The certifier's part for soft fingers: unilateral contact, and friction with the moment about the normal."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.tolerances import GROWTH

__all__ = ["soft_laws"]


def soft_laws(
    scene: Scene, section: Section, candidate: Candidate, v: Array, turn: Array, F: float, opened: Array
) -> tuple[float, float, float]:
    """Worst (normal, cone, slip) residual over the soft contacts, as `kernels.check_contacts` measures those of points.

    v (n, 3), turn (k,) as in `Verdict`; F [N]; opened (c,) what effects add to the motion. A contact's motions are
    relative to the largest term of their own sums, as far as its finger could give way.
    """
    surface, c = limit_surface(section), candidate.components
    E = scene.flexibility
    offset = opened + scene.every_offset
    terms = np.maximum(abs(scene.grasp_matrix.T @ candidate.twist), np.maximum(abs(E @ c), abs(offset)))
    limits = surface.limit(scene.mu)
    normal, cone, slip = 0.0, 0.0, 0.0
    for k, (i, at) in enumerate(zip(scene.soft, scene.soft_index.tolist(), strict=True)):
        every = [*at, 3 * i + 2]
        retreat = float(np.diagonal(E)[every].mean()) * F
        give = max(retreat, float(abs(offset[every]).max()))
        own = float(terms[every].max())
        V = max(min(own, GROWTH * give) if give > 0.0 else own, retreat, 1e-12 * scene.units.motion)
        r, w, push = c[at] / F, np.append(v[i, :2], turn[k]) / V, c[3 * i + 2] / F
        normal = max(normal, abs(min(push, v[i, 2] / V)))
        cone = max(cone, float(np.linalg.norm(r - surface.nearest(r, limits[i] * push))))
        slip = max(slip, float(np.linalg.norm(r - surface.nearest(r - w, limits[i] * push))))
    return normal, cone, slip
