"""Contact compliance: the object's surface, or a patch between it and a fingertip, gives way under the contact's force.

    E_ii += C_i,    ε_i += C_i r_i

In series with the finger: a force that travels through both moves the contact by the sum. Each contact feels its own
force alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, read_only
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.kind import Placement, block_diagonal
from handlcp.grasp.model.limit import FileKey, From0, by_finger
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init


@helped_init()
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
        if dimensions(flexibility) == 0:
            flexibility = np.full(3, number(argument, flexibility, minimum=0.0))
        value = validate.blocks(argument, array(argument, flexibility, (3,), (-1, 3, 3)))
        object.__setattr__(self, "flexibility", read_only(value.copy()))

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        each = by_finger(key, value, fingers, 0.0)
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
