"""How far motors turn on once the hand touches, until they pull with the torque that was asked for.

A motor that has turned on by δq pulls with K (δq - Δq) where its joint has turned on by Δq meanwhile: K⁻¹ τ alone is
right only where nothing gives way. So the closing is followed: the motors of each finger turn on together, in
proportion to K⁻¹ τ, until the first of them pulls with its torque; then that finger holds. What its other joints pull
with is for the contacts to say: a fingertip's force needs torques in one proportion.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.effects.joint_offset import command_of
from handlcp.grasp.friction import Section, as_section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.advance import Leg, Open
from handlcp.grasp.path.follow import TOLERANCE, begun, geometry_of
from handlcp.grasp.path.state import Goal, Outcome, Run, State
from handlcp.grasp.path.watch import watch_of
from handlcp.hand.mechanism import HandMechanism
from handlcp.hand.pulling import Pulling
from handlcp.progress import told

_STEP = 1.0 / 20.0  # of K⁻¹ τ
_MOST = 100.0  # times K⁻¹ τ: joints that turn as far and do not pull meet nothing
_THERE = 1e-3  # of the torque: as near to it is there
_OTHERS = 1.1  # times its torque: no finger turns on that drives a joint of another beyond this


@told("closing the hand")
def wound(spec: GraspSpec, torque: Array) -> tuple[GraspSpec, bool]:
    """The grasp, commanded by K⁻¹ τ beyond where the hand touches, with motors that have turned on until they pull with
    torque (nv,) [N·m]; and whether steps of it ended without an answer before. A finger that pulls no harder for
    turning on stays at K⁻¹ τ; so do all where no loading can be followed.
    """
    mechanism = spec.mechanism
    if not torque.any():
        return spec, False
    assert isinstance(mechanism, HandMechanism)  # which pulls
    hand = mechanism.posture.hand
    pulling = Pulling.of(torque, hand.moves[list(mechanism.tips)], hand.stiffness)
    try:
        closing = _Closing(spec, as_section("cone", planar=spec.plane is not None), pulling)
    except Unsupported:
        return spec, False
    driven, rubs = closing.ends()
    against = hand.stiffness.deflection(rubs)
    command = command_of(spec.effects)
    assert command is not None  # `spec` begins with it
    new = replace(command, command=read_only(driven - against), against=read_only(against))
    return spec.replace(effects=tuple([new if e is command else e for e in spec.effects])), closing.stuck


class _Closing:
    """A closing that is followed."""

    def __init__(self, spec: GraspSpec, section: Section, pulling: Pulling) -> None:
        body = geometry_of(spec, None)
        first, goals, self.stepper = begun(spec, section, body, TOLERANCE, "squeeze", None)
        self.watch, self.pulling = watch_of(spec, body), pulling
        self.end = goals[0].end
        self.run = Run([self.stepper.beginning(first)], [0], [0.0])
        self.stuck = False

    def ends(self) -> tuple[Array, Array]:
        """How far motors turn beyond the posture (nv,) [rad, m], and friction at the joints then (nv,) [N·m]."""
        rate, run, fingers = self.end.command, self.run, self.pulling.fingers
        if run.states[0].controls.command.any():  # the hand closes until it touches
            goal = Goal("squeeze", self.end._replace(command=np.zeros_like(rate)))
            if not Leg(self.stepper, self.watch, run, 0, goal, _STEP).through():
                return rate, run.states[-1].rubs
        found, turning = rate.copy(), set(self.pulling.every)
        while turning:
            on, before = np.isin(fingers, list(turning)), run.states[-1]
            self._turn_on(on)
            last, shares = run.states[-1], self._shares(run.states[-1])
            self.stuck |= run.outcome is Outcome.GAVE_UP
            there = set(fingers[on & (shares > 1.0 - _THERE)].tolist())
            done = there or turning  # a finger whose turning on drives another one too far; or nothing more to be had
            for finger in done:
                its = fingers == finger
                if run.outcome is Outcome.LIMIT or shares[its].max() > self._shares(before)[its].max():
                    found[its] = last.controls.command[its]
            if run.outcome is Outcome.LOST:  # the closing itself loses the object
                found[on] = last.controls.command[on] + rate[on]
            turning = turning - done
        return found, run.states[-1].rubs

    def _turn_on(self, on: Bools) -> None:
        """These joints (nv,), until one of them pulls with its torque, or others are driven too far."""
        now = self.run.states[-1].controls.command
        goal = Goal("squeeze", self.end._replace(command=now + np.where(on, self.end.command, 0.0)))
        most = np.where(on, 1.0, _OTHERS)
        beyond = Open(_STEP, _MOST, lambda state: float((self._shares(state) - most).max()))
        self.run.outcome = Outcome.END
        Leg(self.stepper, self.watch, self.run, 0, goal, _STEP, beyond).through()

    def _shares(self, state: State) -> Array:
        """(nv,) of its torque that each joint pulls with."""
        return self.pulling.shares(state.stretched, state.controls.command)
