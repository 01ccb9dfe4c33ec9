"""Synergies: how fewer actuators than joints move a hand, and what its stiffness becomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.explanation import Description
from handlcp.hand.elasticity.elasticity import TRANSMISSION, Effort, Elasticity, Transmission, check_numbers, spanned
from handlcp.hand.elasticity.stiffness import (
    JointStiffness,
    given_rows,
    read_rows,
    read_springs,
    read_stiffness,
)
from handlcp.keywords import helped_init
from handlcp.tolerances import SEMIDEFINITE

# ----------------------------------------------------------------
# Soft synergies: each actuator moves many joints at once, through a spring.
#
# q = S z,    C = K_q⁻¹ + S K_z⁻¹ Sᵀ,    η = Sᵀ τ
#
# Each column of S is a posture towards which one actuator pulls the hand. Actuator springs K_z and joint springs K_q
# are in series: both carry the torque τ, the actuators as η, so their compliances add. With rigid joints (K_q = ∞) the
# hand gives way in as many directions as it has actuators; C is then singular and has no inverse. A column with one
# joint and the joints that mimic it acts as a mimic joint.

SYNERGIES = Description(
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


_spring = partial(number, above=0.0, finite=False)


@helped_init()
@dataclass(frozen=True, eq=False)
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

    S: Any
    stiffness: Any
    joint_stiffness: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the joints. `S` becomes rows, one for each actuator."""
        columns = self.S if isinstance(self.S, Mapping) else array("Synergies.S", self.S, (-1, -1)).T
        rows = given_rows("Synergies.S", columns)
        object.__setattr__(self, "S", rows)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(rows))]
            read_springs("Synergies.stiffness", self.stiffness, "synergy", numbers, _spring)
        if isinstance(self.joint_stiffness, Transmission):
            expected = "the springs of the joints themselves, or None where they are rigid"
            raise InputError("Synergies.joint_stiffness", expected, type(self.joint_stiffness).__name__)
        if not (self.joint_stiffness is None or isinstance(self.joint_stiffness, Elasticity)):
            check_numbers("Synergies.joint_stiffness", self.joint_stiffness, _spring)

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> SynergyCompliance:
        """C over these joints."""
        names, rows = read_rows("Synergies.S", self.S, "synergy", joints)
        springs = read_springs("Synergies.stiffness", self.stiffness, "synergy", names, _spring)
        root = rows.T @ JointStiffness(springs).root
        if self.joint_stiffness is not None:
            own = read_stiffness(self.joint_stiffness, joints, "Synergies.joint_stiffness")
            root = np.hstack([own.root, root])
        return SynergyCompliance(names, rows, root)


class SynergyCompliance(Elasticity):
    """C = A Aᵀ with A = (K_q^-½, S K_z^-½), and the synergies behind it: names (k,), columns (k, nv) of S as rows."""

    def __init__(self, names: tuple[str, ...], columns: Array, root: Array) -> None:
        super().__init__(root)
        self.names, self.columns = names, columns

    @property
    def matrix(self) -> Array:
        """(nv, nv) K = C⁻¹. Raises Unsupported where C is singular: some joints only move together."""
        U, s, _ = np.linalg.svd(self.root, full_matrices=False)
        nv = len(self.root)
        if len(s) < nv or s[-1] ** 2 <= SEMIDEFINITE * s[0] ** 2:
            raise Unsupported(
                f"{len(self.names)} synergies move {nv} joints that are rigid but for them: these have a compliance "
                "(hand.joint_compliance) and no stiffness"
            )
        return read_only((U / s**2) @ U.T)

    @property
    def commands(self) -> Array:
        """The columns of S: an actuator moves its joints together."""
        return spanned(self.columns.T)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The force η = Sᵀ τ [N·m where S has no unit] of each actuator."""
        none = len(self.names)
        free = read_only(np.full(none, np.inf)), read_only(np.zeros(none))
        return Effort("actuator force", "N·m", self.names, read_only(self.columns @ torque), *free)

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        k, nv = self.columns.shape
        return SYNERGIES.equation, f"{k} synerg{'ies' if k > 1 else 'y'} over {nv} joints"
