"""One answer of a stream."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.kind import shifted
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.grasp.verify.contact_laws import in_world
from handlcp.grasp.verify.judge import Residuals
from handlcp.hand.elasticity.elasticity import Effort
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.torque_check import TorqueCheck, torque_check
from handlcp.lcp import Status


class GraspUpdate:
    """Arrays as in `GraspSolution`, read-only; NaN throughout where there is no answer.

    What a stream has no time for is left out: uniqueness, the smallest of several motions (this is the one nearest to
    the last answer), proofs. `stream.grasp.solve()` has them.
    """

    __slots__ = ("_found", "_frames", "_grasp", "_torques", "held")

    def __init__(self, grasp: Grasp, found: CompiledAnswer, held: bool, frames: Array, torques: Array | None) -> None:
        self._grasp, self._found, self.held, self._frames, self._torques = grasp, found, held, frames, torques

    @property
    def status(self) -> Status:
        """SOLVED, the certifier's word, or UNDECIDED."""
        return Status.SOLVED if self.held else Status.UNDECIDED

    @property
    def residuals(self) -> Residuals:
        """How far each law is missed."""
        return self._found.residuals

    @property
    def steps(self) -> int:
        """Newton steps taken; 0: the last answer's contact states hold still, or all contacts stick."""
        return int(self._found.row[1])

    @property
    def forces(self) -> Array:
        """(n, 3) N, of each finger on the object, contact axes."""
        return self._or_nan(self._found.components.reshape(-1, 3))

    @property
    def forces_world(self) -> Array:
        """(n, 3) N, world axes."""
        return self._or_nan(read_only(in_world(self._frames, self._found.components)))

    @property
    def gap(self) -> Array:
        """(n,) m."""
        return self._or_nan(self._found.motion[2::3])

    @property
    def slip(self) -> Array:
        """(n, 2) m, contact axes."""
        return self._or_nan(self._found.motion.reshape(-1, 3)[:, :2])

    @property
    def object_displacement(self) -> Array:
        """(6,) m and rad, about the grasp's reference."""
        return self._or_nan(read_only(shifted(self._found.twist, self._grasp.reference - self._found.centre)))

    @property
    def reference(self) -> Array:
        """(3,) point that the object's motion refers to [m]."""
        return self._grasp.reference

    @property
    def contact_state(self) -> tuple[str, ...]:
        """(n,) "separated", "sticking", "sliding"; "unknown" where there is no answer."""
        return self._found.states if self.held else ("unknown",) * self._grasp.spec.n

    @property
    def torques(self) -> Array:
        """(nv,) N·m that the actuators hold. Raises AttributeError for a grasp without a hand."""
        if self._torques is None:
            raise AttributeError("a grasp without a hand has no torques")
        return self._or_nan(read_only(self._torques))

    @property
    def torque_check(self) -> TorqueCheck:
        """Joint by joint, as in `HandGraspSolution`. Raises AttributeError for a grasp without a hand."""
        torques = self.torques
        assert isinstance(self._grasp, HandGrasp)
        hand = self._grasp.state.hand
        limits = hand.torques
        return torque_check(
            hand.joint_names, torques, limits.limits, limits.known, sliding=hand.sliding, drives=limits.drives
        )

    @property
    def effort(self) -> Effort | None:
        """What tendons or synergies do, as in `HandGraspSolution`. Raises AttributeError for a grasp without a hand."""
        torques = self.torques
        assert isinstance(self._grasp, HandGrasp)
        return self._grasp.state.hand.stiffness.effort(torques, self._grasp.joint_offset)

    def _or_nan(self, values: Array) -> Array:
        return values if self.held else read_only(np.full(values.shape, np.nan))

    def __repr__(self) -> str:
        return f"GraspUpdate({self.status.name}, {', '.join(self.contact_state)})"
