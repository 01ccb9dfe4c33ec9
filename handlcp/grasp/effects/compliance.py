"""`ContactCompliance` and `SoftWrist`: what gives way beside the joints, the object's surface and the palm.

Contact compliance: the object's surface, or a patch between it and a fingertip, gives way under the contact's force.

    E_ii += C_i,    ε_i += C_i r_i

In series with the finger: a force that travels through both moves the contact by the sum. Each contact feels its own
force alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from annotated_types import Len

from handlcp.check import (
    Array,
    check_array,
    check_init_call,
    check_number,
    check_psd,
    check_symmetric,
    count_dimensions,
    read_only,
)
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Placement, block_diagonal
from handlcp.grasp.model.effect import Effect, FileKey, Finite, From0, Three, values_by_finger
from handlcp.grasp.model.scene import Scene, wrench_map


@check_init_call()
@dataclass(frozen=True, init=False, eq=False)
class ContactCompliance(Effect):
    """Flexibility of the object's surface at the contacts [m/N], contact axes (x, y tangents, z normal).

    flexibility : a number ≥ 0 or a (3,) diagonal for every contact, or (n, 3, 3) symmetric positive semidefinite
        blocks; 0 is a rigid surface, the same as none. Blocks for the fingers alone leave it rigid where it meets the
        environment. A planar scene uses the parts in its plane, x and z.

    Raises InputError.
    """

    flexibility: Array

    title = "contact compliance"
    equation = "E_ii += C_i"
    when = "An object that is itself soft: foam, fruit, a rubber skin."
    in_python = "effects=[ContactCompliance(1e-4)]"
    in_file = "effects.contact_compliance_m_per_N = 1e-4"
    brings = "none: part of E"
    source = "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989)"
    order = 260
    file_key = FileKey(
        "contact_compliance_m_per_N",
        From0 | list[From0] | dict[str, From0 | list[From0]],
        "a number ≥ 0, three of them, or a table by finger",
        "of the object's surface at the contacts, in contact axes (x, y, normal); a table by finger: 0 for the others",
    )

    def __init__(self, flexibility: Any) -> None:
        argument = "ContactCompliance.flexibility"
        if count_dimensions(flexibility) == 0:
            flexibility = np.full(3, check_number(argument, flexibility, minimum=0.0))
        value = validate.blocks(argument, check_array(argument, flexibility, (3,), (-1, 3, 3)))
        object.__setattr__(self, "flexibility", read_only(value.copy()))

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        each = values_by_finger(key, value, fingers, 0.0)
        yield cls([np.diag(np.ones(3) * c) for c in each] if isinstance(value, dict) else each)

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """As many blocks as fingers or contacts."""
        if self.flexibility.ndim == 3 and len(self.flexibility) not in (at.of_hand, at.n):
            raise InputError(f"{argument}.flexibility", f"{at.n} blocks, one for each contact", len(self.flexibility))

    def why(self, scene: Scene) -> str:
        mean = float(np.trace(self.flexibility, axis1=-2, axis2=-1).mean() / 3)
        return f"asked for: the object's surface gives way by {mean:.3g} m/N in the mean"

    def added_flexibility(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """Blocks on the diagonal; nothing about the normals."""
        return np.pad(block_diagonal(self.flexibility, at.n), (0, len(soft)))


# ----------------------------------------------------------------
# A soft wrist or palm: what all fingers push against gives way, and takes every fingertip with it.
#
#     E += Wᵀ C W,    W = [R; skew(p - a) R] per contact
#
# The fingers push the object with r, so the palm feels the wrench -W r about the point a and moves by the twist -C W r;
# the tips move along by Wᵀ of that (virtual work), which is motion of the object relative to them by +Wᵀ C W r. It
# couples every finger with every other: the blocks off the diagonal of E.


_Softness = From0 | Annotated[list[From0], Len(3, 3)]
_Six = Annotated[list[Finite], Len(6, 6)]


def _softness_key(name: str, meaning: str) -> FileKey:
    return FileKey(name, _Softness, "a number ≥ 0 or three of them", meaning, default=0.0)


@check_init_call()
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
            _softness_key("translation_m_per_N", "how the palm moves along x, y, z under a force"),
            _softness_key("rotation_rad_per_Nm", "how it turns about x, y, z under a torque"),
            FileKey(
                "flexibility",
                Annotated[list[_Six], Len(6, 6)],
                "six rows of six finite numbers",
                "instead of both: the (6, 6) matrix from force and torque to motion and rotation, "
                "in m/N, rad/N and rad/(N·m)",
            ),
            FileKey(
                "at_m",
                Three,
                "three finite numbers",
                "the point of the palm where it does so, world axes",
                default=[0.0, 0.0, 0.0],
            ),
        ),
        "a table",
        "a palm that gives way under all fingers",
    )

    def __init__(self, flexibility: Any, at: Any = (0.0, 0.0, 0.0)) -> None:
        argument = "SoftWrist.flexibility"
        value = check_array(argument, flexibility, (6, 6), (6,))
        value = np.diag(value) if value.ndim == 1 else check_symmetric(argument, value)
        diagonal = np.diagonal(value)
        if (diagonal < 0).any():
            raise InputError(argument, "entries ≥ 0 on the diagonal", diagonal.tolist())
        size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))  # metres and radians: no eigenvalue mixes them unscaled
        check_psd(argument, value / np.outer(size, size))
        object.__setattr__(self, "flexibility", read_only(value.copy()))
        object.__setattr__(self, "at", check_array("SoftWrist.at", at, (3,)))

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
        linear, angular = np.diagonal(self.flexibility).reshape(2, 3).mean(axis=1)
        mean = f"{linear:.3g} m/N and {angular:.3g} rad/(N·m) in the mean"
        return f"asked for: the palm gives way by {mean} at {self.at.tolist()}"

    def added_flexibility(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """Wᵀ C W, symmetric to the last bit; a moment about a soft finger's normal is felt as it is."""
        W = self.carried(at, soft)
        E = W.T @ self.flexibility @ W
        return np.asarray((E + E.T) / 2)

    def carried(self, at: Placement, soft: tuple[int, ...]) -> Array:
        """The wrench that the wrist carries about `at` as a map W (6, c) of the forces; it does not carry the
        environment.
        """
        W = wrench_map(at.positions, self.at, at.frames, at.frames[list(soft)][:, :, 2].T.copy())
        W[:, 3 * at.of_hand : 3 * at.n] = 0.0
        W[:, 3 * at.n :][:, np.array(soft, dtype=int) >= at.of_hand] = 0.0
        return np.asarray(W)
