"""One step of loading: contacts detected anew, one warm solve, and the configuration that follows from it.

About a configuration x̂ near the step's end, the step is an ordinary grasp (`step_grasp`):

    v = Gᵀ u - J (q - q̂) - (s - ŝ) + d̂,    q = q_c - K⁻¹ (Jᵀ f + g),    s = -P f

q_c are the commanded joints, s is how far pads give way, and v_T is the slip of the step, which friction opposes:
history is carried by q, s and the object's pose alone. Balance is written in the geometry of x̂. Where the end of the
step is too far from x̂, the end becomes x̂ and the step is solved again; at convergence every law holds in the geometry
at the end of the step. That iteration contracts where the grasp is stable: a force that turns with its contact
faster than the springs can follow drives it away.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.loading.geometry import Geometry, Look, Where
from handlcp.grasp.loading.stage import Controls
from handlcp.grasp.loading.state import Failure, Guess, State
from handlcp.grasp.loading.step_answer import Answer, continued
from handlcp.grasp.loading.step_grasp import StepGrasp
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import cross_rows
from handlcp.grasp.solve.compiled_answer import NOWHERE

__all__ = ["Stepper"]

_MOST = 8  # looks at one step, before it counts as one that does not settle
_CONTRACTS = 0.7  # each look has to come nearer by this factor, or the step is shortened
_LARGEST = 0.1  # motion in one step, as a share of the contacts' radii


class Stepper:
    """Steps of one grasp. tolerance : how far the end of a step may be from where its contacts were looked at, as a
    share of the contacts' radii. weight (3,) : of the object [N].
    """

    def __init__(
        self, spec: GraspSpec, geometry: Geometry, section: Section, weight: Array, tolerance: float, seed: int
    ) -> None:
        self.geometry, self.section, self.tolerance, self.seed = geometry, section, tolerance, seed
        self.first = geometry.look(geometry.start, None)
        self.grasp = StepGrasp(spec, self.first, weight)

    def beginning(self, controls: Controls) -> State:
        """Before anything is done: nothing is loaded, and the joints stand in the grasp's posture."""
        first, spec = self.first, self.grasp.spec
        n, still = spec.n, np.zeros(len(first.at.q))
        none = read_only(np.zeros((n, 3)))
        joints = None if first.mechanism is None else JointReading(still, still, still)
        return State(
            first.at, first, none, none, read_only(np.zeros(n)), none, first.gap, ("separated",) * n, joints, controls,
            spec, NOWHERE, 0,
        )  # fmt: skip

    def step(self, state: State, controls: Controls, guess: Guess, patient: bool = False) -> State | Failure:
        """The state under other controls. guess : what is expected of it. patient : whether to search for an answer
        where the first stage of the solver finds none.
        """
        look, last = self.geometry.look(guess.where, state.look), np.inf
        for count in range(1, _MOST + 1):
            slipped = self.geometry.slipped(state.look, look) - state.carry
            base = self.grasp.base(look, slipped, controls, state.controls)
            spec = self.grasp.made(look, slipped, base, controls)
            answer = continued(spec, self.section, self.seed, guess.start, state.kinds, patient)
            if isinstance(answer, Failure):
                return answer
            end, carry, miss = self._end(look, answer, slipped, base, controls)
            if miss <= self.tolerance or not self.geometry.follows:
                if self._leaps(state, end):
                    break
                slip = np.column_stack([answer.motion[:, :2], answer.spin])
                return State(
                    end, look, carry, answer.forces, answer.torsion, slip, answer.motion[:, 2], answer.kinds,
                    answer.joints, controls, spec, answer.start, count,
                )  # fmt: skip
            if count > 1 and miss > _CONTRACTS * last:
                break
            last, look = miss, self.geometry.look(end, look)
        return Failure("runs away", self._moved(state, end))

    def _end(
        self, look: Look, answer: Answer, slipped: Array, base: Array, controls: Controls
    ) -> tuple[Where, Array, float]:
        """The configuration after the solve, the slip between the look and it, and how far it is from the look."""
        R, n, soft = look.frames, len(look.gap), list(self.grasp.soft)
        u, omega = answer.twist[:3], answer.twist[3:]
        arms = look.positions - answer.centre
        object_moves = np.einsum("nji,nj->ni", R, u + cross_rows(np.broadcast_to(omega, (n, 3)), arms))
        q, tip_moves, tip_turns = look.at.q, np.zeros((n, 3)), np.zeros(len(soft))
        if answer.joints is not None and look.mechanism is not None:
            q = self.grasp.posture + controls.command - answer.joints.deflection - answer.joints.yielded
            change = q - look.at.q
            tip_moves = (look.mechanism.jacobian @ change).reshape(n, 3)
            if soft:
                tip_turns = look.mechanism.turning(self.grasp.soft) @ change
        relative = answer.motion - base
        pushed = object_moves - tip_moves - relative
        give = look.at.give + np.einsum("nij,nj->ni", R, pushed)
        carry, turn = np.zeros((n, 3)), look.at.turn
        carry[:, :2] = relative[:, :2]
        if soft:
            carry[soft, 2] = answer.spin[soft] - slipped[soft, 2]
            turn = look.at.turn.copy()
            turn[soft] += R[soft, :, 2] @ omega - tip_turns - carry[soft, 2]
        where = Where(read_only(q), give, turn, self.geometry.moved(look.at.pose, answer.twist, answer.centre))
        far = np.sqrt(np.maximum((object_moves**2).sum(axis=1), ((tip_moves + pushed) ** 2).sum(axis=1)))
        return where, carry, float(max(np.sqrt(omega @ omega), (far / look.radius).max()))

    def _leaps(self, state: State, end: Where) -> bool:
        """Whether the object moves further in this step than a path may be followed at once."""
        moved = self._moved(state, end)
        shares = np.sqrt(moved[3:] @ moved[3:]), np.sqrt(moved[:3] @ moved[:3]) / state.look.radius.min()
        return self.geometry.follows and bool(max(shares) > _LARGEST)

    def _moved(self, state: State, end: Where) -> Array:
        """(6,) motion of the object from a state to an end."""
        return self.geometry.displacement(end.pose) - self.geometry.displacement(state.where.pose)
