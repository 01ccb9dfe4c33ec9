"""How the joints of a hand give way, and what stands between its actuators and its joints.

    δq = C τ,    C = K⁻¹ = A Aᵀ,    E = J C Jᵀ = (J A)(J A)ᵀ

A hand asks no more of its joints than this. `JointStiffness` has a spring at every joint; transmissions (`Tendons`,
`Synergies`) couple them, and C may then be singular: A is what they share. Source: model, "Flexibility from the hand".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.grasp.explain import EffectLine
from handlcp.hand.posture import flexibility_through

__all__ = ["TRANSMISSION", "Effort", "Elasticity", "Softener", "Transmission", "transmission_line"]

TRANSMISSION = "transmission"  # what `explain()` calls it

Softener = Callable[[Array, Array, Array], None]


@dataclass(frozen=True, slots=True, eq=False)
class Effort:
    """What the actuators behind a transmission do, one by one.

    kind : "tendon tension" or "actuator force". names : of the tendons or synergies. values : as many, in `unit`.
    """

    kind: str
    unit: str
    names: tuple[str, ...]
    values: Array

    def __str__(self) -> str:
        """A plain table."""
        width = max(len(self.kind), *(len(name) for name in self.names))
        rows = [f"{name:<{width}}  {value:12.4f}" for name, value in zip(self.names, self.values, strict=True)]
        return "\n".join([f"{self.kind:<{width}}  [{self.unit}]", *rows])


class Elasticity:
    """C = A Aᵀ over the nv independent joints, symmetric positive semidefinite.

    uniform : one number was given for all joints. Subclasses give `root` and `matrix`; the rest follows.
    """

    __slots__ = ()

    uniform: bool = False

    @property
    def matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint. Raises Unsupported where C has no inverse."""
        raise NotImplementedError

    @property
    def root(self) -> Array:
        """(nv, m) A with C = A Aᵀ."""
        raise NotImplementedError

    def compliance(self, J: Array) -> Array:
        """J C Jᵀ = B Bᵀ, symmetric to the last bit; J (m, nv), result (m, m)."""
        B = J @ self.root
        return np.asarray(B @ B.T)

    def deflection(self, torque: Array) -> Array:
        """C τ [rad] for torques (nv,) [N·m]."""
        A = self.root
        return np.asarray(A @ (torque @ A))

    def softener(self) -> Softener:
        """(J (3n, nv), pads (n, 3, 3), E (3n, 3n)) → E ← J C Jᵀ + pads, compiled, in contact axes."""
        A = np.ascontiguousarray(self.root)
        return lambda J, pads, E: flexibility_through(J, A, pads, E)

    def effort(self, torque: Array) -> Effort | None:
        """What the actuators do for joint torques (nv,) [N·m]; None where each joint has its own."""
        return None

    @property
    def law(self) -> tuple[str, str]:
        """Equation and words for `explain()`; empty words where each joint has its own spring."""
        return "K = K_p + Rᵀ k R  or  K⁻¹ = K_q⁻¹ + S K_z⁻¹ Sᵀ", ""


class Transmission:
    """What users pass in place of a joint stiffness where actuators reach several joints at once."""

    def for_joints(self, joints: Sequence[str]) -> Elasticity:
        """What it makes of these joints. Raises InputError, UnknownName."""
        raise NotImplementedError


def transmission_line(elasticity: Elasticity) -> EffectLine:
    """What `explain` says of it."""
    equation, words = elasticity.law
    return EffectLine(TRANSMISSION, equation, bool(words), words or "none: the springs are those of the joints", ())
