"""A soft wrist or palm: what all fingers push against gives way, and takes every fingertip with it.

    E += Wᵀ C W,    W = [R; skew(p - a) R] per contact

The fingers push the object with r, so the palm feels the wrench -W r about the point a and moves by the twist -C W r;
the tips move along by Wᵀ of that (virtual work), which is motion of the object relative to them by +Wᵀ C W r. It
couples every finger with every other: the blocks off the diagonal of E.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Len

from handlcp.check import Array, array, psd, read_only, symmetric
from handlcp.errors import InputError
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.grasp_matrix import wrench_map
from handlcp.grasp.model.kind import Placement
from handlcp.grasp.model.limit import FileKey, Finite, From0, Three
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init

_Softness = From0 | Annotated[list[From0], Len(3, 3)]
_Six = Annotated[list[Finite], Len(6, 6)]


@helped_init()
@dataclass(frozen=True, init=False, eq=False)
class SoftWrist(Effect):
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

    title = "soft wrist"
    equation = "E += Wᵀ C W"
    when = "A wrist or palm that gives way, and takes all fingers along."
    in_python = "effects=[SoftWrist([1e-4] * 3 + [0.01] * 3)]"
    in_file = "effects.soft_wrist = { translation_m_per_N = 1e-4, rotation_rad_per_Nm = 0.01 }"
    brings = "none: part of E"
    source = "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989), compliances in series"
    order = 270
    file_key = FileKey(
        "soft_wrist",
        (
            FileKey(
                "translation_m_per_N", _Softness, "a number ≥ 0 or three of them",
                "how the palm moves along x, y, z under a force", default=0.0,
            ),
            FileKey(
                "rotation_rad_per_Nm", _Softness, "a number ≥ 0 or three of them",
                "how it turns about x, y, z under a torque", default=0.0,
            ),
            FileKey(
                "flexibility", Annotated[list[_Six], Len(6, 6)], "six rows of six finite numbers",
                "instead of both: the (6, 6) matrix from force and torque to motion and rotation, "
                "in m/N, rad/N and rad/(N·m)",
            ),
            FileKey(
                "at_m", Three, "three finite numbers", "the point of the palm where it does so, world axes",
                default=[0.0, 0.0, 0.0],
            ),
        ),
        "a table",
        "a palm that gives way under all fingers",
    )  # fmt: skip

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

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        """By translation and rotation, or by the whole matrix."""
        names, at = ("translation_m_per_N", "rotation_rad_per_Nm"), value.get("at_m", (0.0, 0.0, 0.0))
        if "flexibility" not in value:
            yield cls(np.concatenate([np.ones(3) * value.get(name, 0.0) for name in names]), at)
            return
        for name in sorted(names):
            if name in value:
                raise InputError(f"{key}.{name}", "none beside flexibility, the whole matrix", value[name])
        try:
            yield cls(value["flexibility"], at)
        except InputError as error:
            raise InputError(f"{key}.flexibility", error.expected, error.got) from None

    def why(self, scene: Scene) -> str:
        linear, angular = np.diagonal(self.flexibility)[:3].mean(), np.diagonal(self.flexibility)[3:].mean()
        return (
            f"asked for: the palm gives way by {linear:.3g} m/N and {angular:.3g} rad/(N·m) in the mean at "
            f"{self.at.tolist()}"
        )

    def added_flexibility(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """Wᵀ C W, symmetric to the last bit; a moment about a soft finger's normal is felt as it is."""
        W = self.carried(at, soft)
        E = W.T @ self.flexibility @ W
        return np.asarray((E + E.T) / 2)

    def carried(self, at: Placement, soft: tuple[int, ...]) -> Array:
        """(6, c) W: the wrench of the forces about `at`; it does not carry the environment."""
        W = wrench_map(at.positions, self.at, at.frames, at.frames[list(soft)][:, :, 2].T.copy())
        W[:, 3 * at.of_hand : 3 * at.n] = 0.0
        W[:, 3 * at.n :][:, np.array(soft, dtype=int) >= at.of_hand] = 0.0
        return np.asarray(W)
