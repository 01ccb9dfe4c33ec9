"""From readings of force and torque sensors in the fingertips to the load on the object."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.model.spec import GraspSpec
from handlcp.keywords import helped

_ROUNDING = 1e-12  # of all that is added up


@helped()
def wrench_from_fingertip_forces(
    grasp: Any, forces: Any, torques: Any = None, *, positions: Any = None, frames: Any = None
) -> Array:
    """(6,) the wrench [N, N·m] about the grasp's reference that the world applies to the object, its weight included.

    grasp : a `Grasp`. forces : (n, 3) N of each finger on the object, in contact axes unless `frames` says otherwise.
    torques : (n, 3) N·m likewise, None: not measured.
    positions, frames : where the readings are taken, (n, 3) [m] and (n, 3, 3) with the sensor's axes in columns, world
        axes; None: at the contact points, in contact axes.

    The object rests, so w = -Σ (R f; p × R f + R τ): the equilibrium w + G r = 0 (model; paper, equation (1)) read
    backwards. `grasp.replace(wrench=w)` is the grasp under that load, and `GraspStream.update(wrench=w)` follows it.
    An environment's contacts are among the n: without their forces the load on the object is not known. What is left
    of components that cancel but for rounding is 0.
    Raises InputError for wrong shapes and numbers not finite.
    """
    spec = getattr(grasp, "spec", None)
    if not isinstance(spec, GraspSpec):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    n = spec.n
    f = array("forces", forces, (n, 3))
    t = np.zeros((n, 3)) if torques is None else array("torques", torques, (n, 3))
    p = spec.positions if positions is None else array("positions", positions, (n, 3))
    R = spec.frames if frames is None else validate.frames(frames, n)
    arms = p - spec.reference
    push = (R @ f[:, :, None])[:, :, 0]
    turn = (R @ t[:, :, None])[:, :, 0]
    twist = turn + cross_rows(arms, push)
    load = -np.concatenate([push.sum(axis=0), twist.sum(axis=0)])
    force, moment = abs(push).sum(), abs(turn).sum() + (np.sqrt((arms**2).sum(axis=1)) * abs(push).sum(axis=1)).sum()
    return read_only(np.where(abs(load) > _ROUNDING * np.repeat([force, moment], 3), load, 0.0))
