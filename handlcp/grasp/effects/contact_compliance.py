"""Contact compliance: the object's surface, or a patch between it and a fingertip, gives way under the contact's force.

    E_ii += C_i,    ε_i += C_i r_i

In series with the finger: a force that travels through both moves the contact by the sum. Each contact feels its own
force alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp.check import Array, array, dimensions, number, psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.compliance import Compliance
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene

__all__ = ["ContactCompliance"]


@dataclass(frozen=True, init=False, eq=False)
class ContactCompliance(Compliance):
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

    def __init__(self, flexibility: Any) -> None:
        argument = "ContactCompliance.flexibility"
        if dimensions(flexibility) == 0:
            value = np.eye(3) * number(argument, flexibility, minimum=0.0)
        else:
            value = array(argument, flexibility, (3,), (-1, 3, 3))
            if value.ndim == 1:
                if (value < 0).any():
                    raise InputError(argument, "entries ≥ 0", value.tolist())
                value = np.diag(value)
            else:
                value = np.array([psd(f"{argument}[{i}]", block) for i, block in enumerate(value)]).reshape(-1, 3, 3)
        object.__setattr__(self, "flexibility", read_only(value))

    def for_fingers(self, argument: str, fingers: int, n: int) -> Self:
        """Blocks of zeros for the environment's contacts, where there are blocks for the fingers alone."""
        if self.flexibility.ndim == 3 and len(self.flexibility) == fingers:
            return type(self)(np.concatenate([self.flexibility, np.zeros((n - fingers, 3, 3))]))
        return self

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """As many blocks as contacts."""
        if self.flexibility.ndim == 3 and len(self.flexibility) != n:
            raise InputError(f"{argument}.flexibility", f"{n} blocks, one for each contact", len(self.flexibility))
        return self

    def why(self, scene: Scene) -> str:
        """Asked for."""
        mean = float(np.trace(self.flexibility, axis1=-2, axis2=-1).mean() / 3)
        return f"asked for: the object's surface gives way by {mean:.3g} m/N in the mean"

    def matrix(self, positions: Array, frames: Array, soft: tuple[int, ...]) -> Array:
        """Blocks on the diagonal; nothing about the normals."""
        n = len(positions)
        out, each = np.zeros((n, 3, n, 3)), np.arange(n)
        out[each, :, each] = self.flexibility
        E = out.reshape(3 * n, 3 * n)
        return np.pad(E, (0, len(soft))) if soft else E
