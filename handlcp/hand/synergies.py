"""Soft synergies: a few actuators move many joints at once, each through springs of its own.

    q = S z,    C = K_q⁻¹ + S K_z⁻¹ Sᵀ,    η = Sᵀ τ

Each column of S is a posture that one actuator pulls the hand towards. Actuator and joint are in series: both feel the
torque τ, the actuators as η, so their compliances add. With rigid joints (K_q = ∞) the hand gives way in as many
directions as there are actuators; C is then singular, and nothing inverts it. One column for a joint and those that
mimic it is a mimic joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.entry import Entry
from handlcp.hand.actuators import Given, given_rows, read_rows, read_springs
from handlcp.hand.elasticity import TRANSMISSION, Effort, Elasticity, Transmission
from handlcp.hand.stiffness import JointStiffness, read_stiffness
from handlcp.tolerances import SEMIDEFINITE

__all__ = ["SYNERGIES", "Synergies", "SynergyCompliance"]

SYNERGIES = Entry(
    title=f"{TRANSMISSION}: synergies",
    equation="C = K_q⁻¹ + S K_z⁻¹ Sᵀ,  η = Sᵀ τ",
    when="A few actuators move many joints at once; joints that mimic another.",
    in_python='joint_stiffness=Synergies({"fist": {"finger_1_distal": 1, "finger_2_distal": 1}}, 4.0, 8.0)',
    in_file="[hand.synergies]\n"
    "columns = { fist = { finger_1_distal = 1, finger_2_distal = 1 } }\n"
    "stiffness_Nm_per_rad = 4.0\n"
    "joint_stiffness_Nm_per_rad = 8.0",
    brings="none: part of K",
    source="Gabiccini, Bicchi, Prattichizzo & Malvezzi, Autonomous Robots 31 (2011); Brown & Asada, IROS 2007",
    module=__name__,
)


@dataclass(frozen=True, init=False, eq=False)
class Synergies(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    S : (nv, k), a column for each actuator [rad or m of a joint per unit of z], or a mapping of synergy names to
        mappings of joint names to entries (joints left out: 0).
    stiffness : K_z of the actuators, a number, (k,), a mapping by synergy name, or an SPD matrix (k, k); [N·m/rad]
        where S has no unit. numpy.inf: that actuator is rigid.
    joint_stiffness : K_q [N·m/rad] of the joints' own springs, in series with the actuators, as for a hand without
        synergies; None: the joints are rigid.

    Raises InputError, UnknownName.
    """

    S: Given
    stiffness: Any
    joint_stiffness: Any

    def __init__(self, S: Any, stiffness: Any, joint_stiffness: Any = None) -> None:
        columns = S if isinstance(S, Mapping) else array("Synergies.S", S, (-1, -1)).T
        object.__setattr__(self, "S", given_rows("Synergies.S", columns))
        if not isinstance(stiffness, Mapping):
            read_springs("Synergies.stiffness", stiffness, "synergy", [str(i) for i in range(len(self.S))], rigid=True)
        if isinstance(joint_stiffness, Transmission):
            expected = "the springs of the joints themselves, or None where they are rigid"
            raise InputError("Synergies.joint_stiffness", expected, type(joint_stiffness).__name__)
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "joint_stiffness", joint_stiffness)

    def for_joints(self, joints: Sequence[str]) -> SynergyCompliance:
        """C over these joints."""
        names, rows = read_rows("Synergies.S", self.S, "synergy", joints)
        springs = read_springs("Synergies.stiffness", self.stiffness, "synergy", names, rigid=True)
        own = (
            None
            if self.joint_stiffness is None
            else read_stiffness(self.joint_stiffness, joints, "Synergies.joint_stiffness")
        )
        through = rows.T @ JointStiffness(springs).root
        root = through if own is None else np.hstack([own.root, through])
        return SynergyCompliance(names, read_only(rows.copy()), read_only(np.ascontiguousarray(root)))


class SynergyCompliance(Elasticity):
    """C = A Aᵀ with A = (K_q^-½, S K_z^-½), and the synergies behind it: names (k,), columns (k, nv) of S as rows."""

    __slots__ = ("_root", "columns", "names")

    def __init__(self, names: tuple[str, ...], columns: Array, root: Array) -> None:
        self.names, self.columns, self._root = names, columns, root

    @property
    def root(self) -> Array:
        """(nv, m) A."""
        return self._root

    @property
    def matrix(self) -> Array:
        """(nv, nv) K = C⁻¹. Raises Unsupported where synergies leave joints that only move together."""
        U, s, _ = np.linalg.svd(self._root, full_matrices=False)
        nv = len(self._root)
        if len(s) < nv or s[-1] ** 2 <= SEMIDEFINITE * s[0] ** 2:
            raise Unsupported(
                f"{len(self.names)} synergies move {nv} joints that are rigid but for them: these have a compliance "
                "(hand.joint_compliance) and no stiffness"
            )
        return read_only((U / s**2) @ U.T)

    def effort(self, torque: Array) -> Effort:
        """The force η = Sᵀ τ [N·m where S has no unit] of each actuator."""
        return Effort("actuator force", "N·m", self.names, read_only(self.columns @ torque))

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        k, nv = self.columns.shape
        return SYNERGIES.equation, f"{k} synerg{'ies' if k > 1 else 'y'} over {nv} joints"
