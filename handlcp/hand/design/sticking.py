"""Contact forces where nothing slips and nothing opens: linear in the grip and in the load.

    d = d₀ + D f

with the grip forces f (k,) that are commanded. While all contacts stick, the path of forces from squeeze to load is a
straight line. Where it stays within friction it is the answer, whatever the order of the loading.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.assembly.build import build
from handlcp.grasp.design.least import without_slip
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec


@dataclass(frozen=True, slots=True, eq=False)
class Sticking:
    """Forces r = by_grip f + rest in the laws' coordinates (c,), and torques τ = levers r + held (nv,) [N·m].

    scene : without a command. by_grip (c, k) : one column a finger. rest (c,) : without a grip, under the load;
    unloaded (c,) : without the load, too.
    """

    scene: Scene
    by_grip: Array
    rest: Array
    unloaded: Array
    levers: Array
    held: Array


def sticking(spec: GraspSpec, gripped: Callable[[GraspSpec, Array], GraspSpec]) -> Sticking:
    """Of this grasp under its load. gripped : the grasp with grip forces (k,) [N]; 0 for none."""
    k = spec.of_fingers
    bare = build(gripped(spec, np.zeros(k)))
    shifts = [build(gripped(spec, row)).offset - bare.offset for row in np.eye(k)]
    loads = np.zeros((6, 2 + k))
    loads[:, 0] = bare.geometry.wrench
    r, _ = without_slip(bare, bare.flexibility, np.column_stack([bare.offset, bare.offset, *shifts]), loads)
    mechanism, scale = bare.mechanism, 1.0 if bare.scale is None else bare.scale
    assert mechanism is not None
    return Sticking(bare, r[:, 2:], r[:, 0], r[:, 1], mechanism.rows(bare.soft).T * scale, bare.held_torque)
