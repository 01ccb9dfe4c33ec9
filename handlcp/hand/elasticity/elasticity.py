"""How the joints of a hand give way under load, and what stands between its actuators and its joints.

    δq = C τ,    C = K⁻¹ = A Aᵀ,    E = J C Jᵀ = (J A)(J A)ᵀ

Everything follows from the root A of the compliance. `JointStiffness` has a spring at every joint. In a transmission
(`Tendons`, `Synergies`) an actuator moves several joints, and C may be singular. τ is
what the actuators hold: the joints stand at the commanded posture minus δq.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, array, dimensions, read_only, sealed
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.keywords import helped_methods
from handlcp.record import Record
from handlcp.text_table import TextTable
from handlcp.tolerances import SEMIDEFINITE

TRANSMISSION = "transmission"  # the effect's name in `explain()`
TENSION = "tendon tension"  # the kind of effort of a tendon


@dataclass(frozen=True, slots=True, eq=False)
class Effort(Record):
    """What the actuators behind a transmission do, one by one.

    kind : "tendon tension" or "actuator force". names : of the tendons or synergies. values : as many, in `unit`.
    limits : what tendons bear, or their motors hold for good where that is less [N]; inf where there is no limit.
    used : the share of it that the whole tension is, pretension included; 0 of a slack tendon and without a limit.
    """

    entries = ("kind", "unit", "each", "limits (t,)", "used (t,)")

    kind: str
    unit: str
    names: tuple[str, ...]
    values: Array
    limits: Array
    used: Array

    @property
    def each(self) -> dict[str, float]:
        """The values by name."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    @property
    def table(self) -> TextTable:
        """One by one, with limits and the shares of them where there are any."""
        heads: tuple[str, ...] = (self.kind, self.unit)
        columns, align = [words.column(self.values.tolist())], "<>"
        if (limited := np.isfinite(self.limits)).any():
            most = zip(words.column(self.limits.tolist()), limited.tolist(), strict=True)
            shares = zip(self.used.tolist(), limited.tolist(), strict=True)
            heads, align = (*heads, f"limit\n{self.unit}", "of limit"), "<>>>"
            columns.append([text if its else "none" for text, its in most])
            columns.append([words.percent(share) if its else "–" for share, its in shares])
        return TextTable(heads, tuple(zip(self.names, *columns, strict=True)), align)

    def __str__(self) -> str:
        return str(self.table)


class Elasticity:
    """Compliance C = A Aᵀ of the nv independent joints, symmetric positive semidefinite.

    root : (nv, m) A, read-only and C-contiguous; the row of a rigid joint is zero.
    uniform : whether the user gave one number for all joints.
    """

    root: Array
    uniform: bool = False

    def __init__(self, root: Array) -> None:
        self.root = read_only(np.ascontiguousarray(root))

    @property
    def matrix(self) -> Array:
        """(nv, nv) K [N·m/rad]; inf on the diagonal of a rigid joint. Raises Unsupported where C has no inverse."""
        raise NotImplementedError

    @property
    def stated(self) -> bool:
        """Whether it is what the hand's file says."""
        return False

    def compliance(self, J: Array) -> Array:
        """(m, m) J C Jᵀ, symmetric to the last bit; J (m, nv)."""
        return joint_flexibility(J, self.root)

    def deflection(self, torque: Array) -> Array:
        """(nv,) C τ [rad] for torques (nv,) [N·m]."""
        return np.asarray(self.root @ (torque @ self.root))

    @property
    def commands(self) -> Array:
        """(nv, m) joint motions that the actuators can command, in orthonormal columns; a rigid joint can be, too."""
        return np.eye(len(self.root))

    def effort(self, torque: Array, command: Array) -> Effort | None:
        """What the actuators do for joint torques (nv,) [N·m] once they have commanded the joints by so much, (nv,)
        [rad]; None where each joint has its own actuator.
        """
        return None

    def pulled(self, torque: Array, command: Array) -> Array:
        """(nv,) the torques with which the actuators themselves pull at the joints [N·m], springs beside them left out;
        arguments as of `effort`.
        """
        return torque

    @property
    def own_springs(self) -> Array:
        """(nv,) of the springs at joints that K counts beside actuators or tendons [N·m/rad]; 0: none."""
        return np.zeros(len(self.root))

    @property
    def beside(self) -> Array:
        """(nv,) k of springs at joints beside their drives, that have a rest angle of their own [N·m/rad]; 0: none."""
        return np.zeros(len(self.root))

    def against_springs(self, q: Array) -> Array | None:
        """(nv,) with which drives pull against springs beside them with joints at q (nv,) [N·m]; None: there are none
        that this counts.
        """
        return None

    def beyond(self, command: Array) -> Array:
        """(nv,) the part of the torques K δq of a command (nv,) [rad] that no actuator makes [N·m]."""
        return np.zeros(len(command))

    def asked(self, command: Array) -> Array:
        """(nv,) K δq of a command (nv,) [rad], of joints that springs hold [N·m]."""
        free = np.asarray(self.root.any(axis=1))
        return np.where(free, np.where(np.isinf(self.matrix), 0.0, self.matrix) @ command, 0.0)

    def at(self, kinematics: Any, q: Array) -> Elasticity:
        """In a posture q (nv,) of a hand with these kinematics: the same, unless tendons run along routes."""
        return self

    def stiffer(self, factor: float) -> Self:
        """The same with every spring so many times as stiff."""
        made = copy(self)
        made.root = read_only(self.root / np.sqrt(factor))
        return made

    @property
    def law(self) -> tuple[str, str]:
        """Equation and words for `explain()`; no words where each joint has its own spring."""
        return "K = K_p + Rᵀ k R  or  K⁻¹ = K_q⁻¹ + S K_z⁻¹ Sᵀ", ""

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrays stay read-only when pickled."""
        self.__dict__.update(sealed(state))


def spanned(motions: Array) -> Array:
    """(nv, r) orthonormal basis of what columns (nv, m) span, each as good as any other whatever its length."""
    lengths = np.sqrt((motions * motions).sum(axis=0))
    U, s, _ = np.linalg.svd(motions[:, lengths > 0.0] / lengths[lengths > 0.0], full_matrices=False)
    return read_only(U[:, s > SEMIDEFINITE])


def check_numbers(argument: str, value: Any, read: Callable[[str, Any], float]) -> None:
    """Of a number for all, one for each, a mapping by name, or a matrix, what does not depend on how many there are.

    read : checks one, from the argument's name and the value. Raises InputError.
    """
    if isinstance(value, Mapping):
        for name, one in value.items():
            check_numbers(f"{argument}[{name!r}]", one, read)
    elif dimensions(value) == 0:
        read(argument, value)
    elif dimensions(value) == 1:
        for k, one in enumerate(value):
            read(f"{argument}[{k}]", one)
    else:
        array(argument, value, (-1, -1))


@helped_methods
class Transmission:
    """What users pass in place of a joint stiffness where an actuator moves several joints."""

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> Elasticity:
        """The elasticity of these joints, of a hand with kinematics. Raises InputError, UnknownName."""
        raise NotImplementedError
