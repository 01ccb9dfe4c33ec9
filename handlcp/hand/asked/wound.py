"""How far motors turn on once the hand touches, until they pull with the torque that was asked for.

A joint whose motor has turned δq further than the joint pulls with K (δq - Δq), where Δq is how far the joint itself has
turned on meanwhile: K⁻¹ τ alone is right only where nothing gives way. So the closing is followed: the motors of each
finger turn on together, in proportion to K⁻¹ τ, until the first of them pulls with its torque; then that finger holds.
What its other joints pull with is for the contacts to say: a fingertip's force needs torques in one proportion.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.effects.joint_offset import recommanded
from handlcp.grasp.friction import Section, as_section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.advance import Leg, Open
from handlcp.grasp.path.follow import TOLERANCE, begun, geometry_of
from handlcp.grasp.path.state import Goal, Outcome, Run, State
from handlcp.grasp.path.watch import watch_of
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.mechanism import HandMechanism
from handlcp.progress import told

_STEP = 1.0 / 20.0  # of K⁻¹ τ
_MOST = 100.0  # times K⁻¹ τ: joints that turn as far and do not pull meet nothing
_THERE = 1e-3  # of the torque: as near to it is there
_OTHERS = 1.1  # times its torque: no finger turns on that drives a joint of another beyond this


def fingers_of(moves: Bools, stiffness: Elasticity, torque: Array) -> Ints:
    """(nv,) number of the finger of each joint that pulls; -1 of others. Joints that move one place that may touch, or
    that are driven together, are of one finger. moves (n, nv) : which joint moves which place.
    """
    pulls = np.flatnonzero(torque)
    move, compliance = moves[:, pulls].astype(int), stiffness.compliance(np.eye(len(torque)))[np.ix_(pulls, pulls)]
    together = (move.T @ move > 0) | (abs(compliance) > 0.0)
    found = np.full(len(torque), -1)
    found[pulls] = connected_components(together, directed=False)[1]
    return found


@told("closing the hand")
def wound(spec: GraspSpec, torque: Array) -> GraspSpec:
    """The grasp, commanded by K⁻¹ τ beyond where the hand touches, with motors that have turned on until they pull with
    torque (nv,) [N·m]. A finger that pulls no harder for turning on stays at K⁻¹ τ; so do all where no loading can be
    followed.
    """
    mechanism = spec.mechanism
    assert isinstance(mechanism, HandMechanism)  # which pulls
    hand = mechanism.posture.hand
    fingers = fingers_of(hand.moves[list(mechanism.tips)], hand.stiffness, torque)
    try:
        closing = _Closing(spec, as_section("cone", planar=spec.plane is not None), torque, fingers, hand.stiffness)
    except Unsupported:
        return spec
    return spec.replace(effects=recommanded(spec.effects, read_only(closing.command())))


class _Closing:
    """A closing that is followed. fingers (nv,) : as `fingers_of` has them."""

    def __init__(self, spec: GraspSpec, section: Section, torque: Array, fingers: Ints, stiffness: Elasticity) -> None:
        body = geometry_of(spec, None)
        first, goals, self.stepper = begun(spec, section, body, TOLERANCE, "squeeze", None)
        self.watch, self.torque, self.fingers = watch_of(spec, body), torque, fingers
        self.stiffness = stiffness
        self.end = goals[0].end
        self.run = Run([self.stepper.beginning(first)], [0], [0.0])

    def command(self) -> Array:
        """(nv,) beyond the posture, at the end."""
        rate, none = self.end.command, np.zeros(len(self.torque))
        if self.run.states[0].controls.command.any():
            goal = Goal("squeeze", self.end._replace(command=none))
            if not Leg(self.stepper, self.watch, self.run, 0, goal, _STEP).through():
                return rate
        winding, found = set(self.fingers.tolist()) - {-1}, rate.copy()
        while winding:
            on = np.isin(self.fingers, list(winding))
            before = self.run.states[-1]
            now = before.controls
            goal = Goal("squeeze", self.end._replace(command=now.command + np.where(on, rate, 0.0)))
            self.run.outcome = Outcome.END
            beyond = Open(_STEP, _MOST, lambda state, on=on: self._beyond(state, on))  # type: ignore[misc]
            Leg(self.stepper, self.watch, self.run, 0, goal, _STEP, beyond).through()
            last, pulls = self.run.states[-1], self._pulls(self.run.states[-1])
            there = {int(f) for f in self.fingers[on & (pulls > 1.0 - _THERE)]}
            if self.run.outcome is Outcome.LIMIT and there:
                done = there
            else:  # nothing more to be had, or another finger in the way
                done = set(winding)
            for finger in done:
                its = self.fingers == finger
                harder = pulls[its].max() > self._pulls(before)[its].max()
                if harder or self.run.outcome is Outcome.LIMIT:
                    found[its] = last.controls.command[its]
            if self.run.outcome is Outcome.LOST:
                found[on] = last.controls.command[on] + rate[on]  # the closing itself loses the object
            winding -= done
        return found

    def _pulls(self, state: State) -> Array:
        """(nv,) of its torque that each joint pulls with; 0 of joints that are not asked to."""
        asked = np.where(self.torque != 0.0, self.torque, 1.0)
        pulled = self.stiffness.pulled(state.read.torque, state.controls.command)
        return np.where(self.torque != 0.0, pulled / asked, 0.0)

    def _beyond(self, state: State, on: Bools) -> float:
        """How far a joint is beyond its torque, as a share."""
        return float((self._pulls(state) - np.where(on, 1.0, _OTHERS)).max())
