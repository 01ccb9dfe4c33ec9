"""A soft wrist or palm: what all fingers push against gives way, and takes every fingertip with it.

    E += Wᵀ C W,    W = [R; skew(p - a) R] per contact

The fingers push the object with r, so the palm feels the wrench -W r about the point a and moves by the twist -C W r;
the tips move along by Wᵀ of that (virtual work), which is motion of the object relative to them by +Wᵀ C W r. It
couples every finger with every other: the blocks off the diagonal of E.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from handlcp.check import Array, array, psd, read_only, symmetric
from handlcp.errors import InputError
from handlcp.grasp.effects.compliance import Compliance
from handlcp.grasp.natural import wrench_map
from handlcp.grasp.scene import Scene

__all__ = ["SoftWrist"]


@dataclass(frozen=True, init=False, eq=False)
class SoftWrist(Compliance):
    """Flexibility of the palm that carries all fingers of the grasp.

    flexibility : (6, 6) symmetric positive semidefinite, or a (6,) diagonal: the palm's small twist (linear, angular)
        under a wrench (force, torque), both about `at`, world axes [m/N, rad/N = m/(N·m), rad/(N·m)]. 0 is a rigid
        wrist, the same as none.
    at : (3,) the point of the palm that twist and wrench refer to [m], world axes (the hand's base frame).

    In a planar scene the forces act in the plane and their motion out of it is left out; a wrist away from the plane
    that tilts still moves the tips within it. Joint torques don't see the wrist, and contacts of the environment are
    not on it.

    Raises InputError.
    """

    flexibility: Array
    at: Array
    fingers: int | None = field(repr=False)  # the contacts that it carries, the first ones; None: all

    title = "soft wrist"
    equation = "E += Wᵀ C W"
    when = "A wrist or palm that gives way, and takes all fingers along."
    in_python = "effects=[SoftWrist([1e-4] * 3 + [0.01] * 3)]"
    in_file = "effects.soft_wrist = { translation_m_per_N = 1e-4, rotation_rad_per_Nm = 0.01 }"
    brings = "none: part of E"
    source = "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989), compliances in series"

    def __init__(self, flexibility: Any, at: Any = (0.0, 0.0, 0.0)) -> None:
        argument = "SoftWrist.flexibility"
        value = array(argument, flexibility, (6, 6), (6,))
        value = np.diag(value) if value.ndim == 1 else symmetric(argument, value)
        diagonal = np.diagonal(value)
        if (diagonal < 0).any():
            raise InputError(argument, "entries ≥ 0 on the diagonal", diagonal.tolist())
        size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))  # metres and radians: no eigenvalue mixes them unscaled
        psd(argument, value / np.outer(size, size))
        object.__setattr__(self, "flexibility", read_only(value.copy()))
        object.__setattr__(self, "at", array("SoftWrist.at", at, (3,)))
        object.__setattr__(self, "fingers", None)

    def for_fingers(self, argument: str, fingers: int, n: int) -> Self:
        """The wrist carries the fingers alone."""
        made = type(self)(self.flexibility, self.at)
        object.__setattr__(made, "fingers", fingers)
        return made

    def why(self, scene: Scene) -> str:
        """Asked for."""
        linear, angular = np.diagonal(self.flexibility)[:3].mean(), np.diagonal(self.flexibility)[3:].mean()
        return (
            f"asked for: the palm gives way by {linear:.3g} m/N and {angular:.3g} rad/(N·m) in the mean at "
            f"{self.at.tolist()}"
        )

    def matrix(self, positions: Array, frames: Array, soft: tuple[int, ...]) -> Array:
        """Wᵀ C W, symmetric to the last bit; a moment about a soft finger's normal is felt as it is."""
        W = wrench_map(positions - self.at, frames)
        if soft:
            W = np.hstack([W, np.vstack([np.zeros((3, len(soft))), frames[list(soft)][:, :, 2].T])])
        if self.fingers is not None:  # it does not carry the rest
            W[:, 3 * self.fingers : 3 * len(positions)] = 0.0
            W[:, 3 * len(positions) :][:, np.array(soft) >= self.fingers] = 0.0
        E = W.T @ self.flexibility @ W
        return np.asarray((E + E.T) / 2)
