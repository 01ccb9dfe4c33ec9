"""Hands that close on boxes, here and in MuJoCo: do links touch in the same order?

`python -m tests.mujoco closing` closes a three-finger hand from its open posture on ten boxes that stand on its palm,
each kept in place until the hand has closed, and prints when each link touches, as a share of the closing; exit 1
unless the order is the same for all of them. Links that touch within a step of each other have no order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

import handlcp as hl
from handlcp.simulator import simulate

COUNT, SEED = 10, 21
STEPS, SECONDS = 160, 8.0  # of the closing; in MuJoCo slowly enough that no pad is thrown at the object
TOUCHES = 1e-3  # [N]
TOGETHER = 1.5 / STEPS + 0.005  # of the closing: what a step, and what joints lag behind in MuJoCo


def grasp(number):
    """The box of this number, and the open hand that closes on it."""
    random = np.random.default_rng((SEED, number))
    sides = random.uniform((0.035, 0.035, 0.04), (0.055, 0.055, 0.07))
    x, y = random.uniform(-0.006, 0.006, 2)
    turn = pin.exp3(np.array([0.0, 0.0, random.uniform(-np.pi, np.pi)]))
    box = hl.Box(sides, pin.SE3(turn, np.array([x, y, 0.5 * sides[2] + 1e-4])), mass=0.1)
    hand = hl.example_hand("three_finger", joint_stiffness=5.0, torque_limits=10.0)
    state = hand.at(np.zeros(hand.nv))
    return state.grasp(box, hl.Coulomb(0.8), links="all", closing_torque=0.3, hold_object=True)


@dataclass(frozen=True)
class Order:
    """Shares of the closing at which links touch first, here and in MuJoCo; fixed links left out."""

    ours: dict[str, float]
    theirs: dict[str, float]

    @property
    def swapped(self):
        """Links that touch in another order there, and those that touch in one of both alone."""
        both = [link for link in self.ours if link in self.theirs]
        found = [
            (a, b) for a in both for b in both
            if self.ours[b] - self.ours[a] > TOGETHER and self.theirs[b] < self.theirs[a]
        ]  # fmt: skip
        return found + [(link, "") for link in self.ours.keys() ^ self.theirs.keys()]


def order(number):
    """Of one box."""
    made = grasp(number)
    hand = made.state.hand
    moved = [bool(hand.tips.support[i].any()) for i in range(len(made.names))]
    link = {name: of for name, of, moves in zip(made.names, hand.links_of_sites, moved, strict=True) if moves}
    ours, theirs = dict[str, float](), dict[str, float]()
    for event in made.follow(order=("squeeze",), steps=STEPS).events:
        if event.kind == "touches" and event.stage == "squeeze" and event.who in link:
            ours.setdefault(link[event.who], event.share)
    record = simulate(made, order=("squeeze",), seconds=SECONDS).record
    closing = np.array(record.stages) == "squeeze"
    for i, name in enumerate(made.names):
        on = np.flatnonzero(closing & (np.linalg.norm(record.forces[:, i], axis=1) > TOUCHES))
        if len(on) and name in link:
            theirs[link[name]] = min(theirs.get(link[name], np.inf), float(record.shares[on[0]]))
    return Order(ours, theirs)


def main():
    """Print them; 1 unless all have the same order."""
    same = 0
    for number in range(COUNT):
        found = order(number)
        same += not found.swapped
        links = sorted(found.ours.keys() | found.theirs.keys(), key=lambda link: found.ours.get(link, np.inf))
        shares = [f"{x} {found.ours.get(x, np.nan):.3f} {found.theirs.get(x, np.nan):.3f}" for x in links]
        print(f"box {number}: {', '.join(shares)}" + (f"  MISS: {found.swapped}" if found.swapped else ""), flush=True)
    print(f"the same order on {same} of {COUNT} boxes")
    return int(same < COUNT)
