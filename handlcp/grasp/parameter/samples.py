"""Many grasps that differ from one in numbers, as arrays: what parameters write to, without making a grasp of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from handlcp.check import Array
from handlcp.grasp.model.spec import GraspSpec


@dataclass
class Samples:
    """m samples of the grasp `spec`; what nobody has written to is as it is there.

    written : arrays (m, …) by name.
        friction (m, n) coefficients [-]; slides (m, k, 2) of the fingers' contacts along their tangents [m];
        springs (m, nv), (m, 1) without a hand : factors on the stiffness of the joints; pads (m, k) : on the
        flexibility of the fingertips' pads; joints (m, nv) : how far they stand off [rad, m];
        mass, load, squeeze (m, 1) : factors on the object's weight, on what else loads it, on preloads and commands.
    remade : for parameters without such an array, what makes the grasp with a value, and the values (m,).
    """

    spec: GraspSpec
    count: int
    written: dict[str, Array] = field(default_factory=dict)
    remade: list[tuple[Callable[[GraspSpec, float], GraspSpec], Array]] = field(default_factory=list)

    def array(self, name: str, nominal: Array | float, *shape: int) -> Array:
        """(m, *shape) to write to, full of the nominal values when it is first asked for."""
        if name not in self.written:
            self.written[name] = np.broadcast_to(nominal, (self.count, *shape)).astype(float)
        return self.written[name]

    def put(self, name: str, nominal: Array | float, count: int, at: tuple[int, ...], values: Array) -> None:
        """Write values (m,) into some of `count` entries, () all of them, in place of what was written there."""
        self.array(name, nominal, count)[:, list(at) if at else slice(None)] = values[:, None]

    def times(self, name: str, count: int, at: tuple[int, ...], factors: Array) -> None:
        """Multiply some of `count` factors, () all of them, by factors (m,): two parameters may write the same."""
        self.array(name, 1.0, count)[:, list(at) if at else slice(None)] *= factors[:, None]

    def get(self, name: str) -> Array | None:
        """What was written; None: nothing."""
        return self.written.get(name)
