"""A door into load limits: many directions at once, and whether a loading ends in balance."""

import numpy as np

from handlcp.grasp.limits.load_limit import limits_of
from tests.support.grasp import section_of


def limits_of_grasp(grasp, wrenches, faces="cone", geometry="fixed"):
    """Limits of loads (m, 6) in one call."""
    return limits_of(grasp.spec, section_of(grasp, faces), wrenches, geometry)


def balanced(end, load):
    """Whether the contacts balance the load (6,) where the loading ends, and no damper does."""
    spec, forces, lost = end.steps.grasp.spec, end.steps.forces[-1], np.array(load, dtype=float)
    size = float(np.linalg.norm(spec.positions - spec.reference, axis=1).max())
    for i, R in enumerate(spec.frames):
        f = R @ forces[i]
        lost[:3] += f
        lost[3:] += np.cross(spec.positions[i] - spec.reference, f)
        if end.steps.states[-1].read.torsion[i]:
            lost[3:] += end.steps.states[-1].read.torsion[i] * R[:, 2]
    lost[3:] /= size
    return bool(abs(lost).max() <= 1e-6 * abs(forces).max())
