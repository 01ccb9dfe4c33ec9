"""What the joints of a hand pull with where it has closed, beside the closing torque that was asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from handlcp import words
from handlcp.check import Array, Bools, Ints
from handlcp.grasp.answer.verdict import Reason
from handlcp.hand.elasticity.elasticity import Elasticity

KEEPS = 0.8  # of the closing torque: a finger none of whose joints pulls with as much is named
DRIVEN = 1.05  # of its torque: a joint that pulls with more is driven by other fingers


@dataclass(frozen=True, eq=False)
class Pulling:
    """asked (nv,) : the torques that a closing torque asked of the joints [N·m], with their signs, 0 of joints that do
    not pull. fingers (nv,) : number of each joint's finger, -1 of those.
    """

    asked: Array
    fingers: Ints
    elasticity: Elasticity

    @classmethod
    def of(cls, asked: Array, moves: Bools, elasticity: Elasticity) -> Pulling:
        """Joints that move one place that may touch, or are driven together, are of one finger. moves (n, nv) : which
        joint moves which place.
        """
        pulls = np.flatnonzero(asked)
        move, compliance = moves[:, pulls].astype(int), elasticity.compliance(np.eye(len(asked)))[np.ix_(pulls, pulls)]
        fingers = np.full(len(asked), -1)
        if len(pulls):
            fingers[pulls] = connected_components((move.T @ move > 0) | (compliance != 0.0), directed=False)[1]
        return cls(asked, fingers, elasticity)

    @property
    def every(self) -> list[int]:
        """Numbers of the fingers."""
        return list(range(int(self.fingers.max(initial=-1)) + 1))

    def shares(self, torque: Array, command: Array) -> Array:
        """(nv,) of the torque asked for that actuators pull with; 0 of other joints. torque (nv,) : of the joints
        [N·m]. command (nv,) : how far they are commanded beyond the grasp's posture [rad, m].
        """
        asked = np.where(self.asked != 0.0, self.asked, 1.0)
        return np.where(self.asked != 0.0, self.elasticity.pulled(torque, command) / asked, 0.0)

    def short(self, shares: Array) -> list[int]:
        """Of each finger none of whose joints keeps enough, the joint that keeps most."""
        most = [int(np.where(self.fingers == finger, shares, -np.inf).argmax()) for finger in self.every]
        return [j for j in most if shares[j] < KEEPS]


def pulling_reasons(
    joints: Sequence[str], pulling: Pulling, shares: Array, stuck: bool, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of fingers that pull with less than asked for, (nv,) shares, once the hand has closed: they meet nothing, or
    another finger would have to pull harder. stuck : steps of closing found no state in which they do. sliding : names
    of joints that slide.
    """
    if short := pulling.short(shares):
        asked = abs(pulling.asked)
        both = [(joints[k], (float(shares[k] * asked[k]), float(asked[k]))) for k in short]
        units = {joint: words.effort_unit(joint in sliding) for joint, _ in both}
        needs = [f"{joint} {' of '.join(words.efforts(each, units[joint]))}" for joint, each in both]
        text = f"where the hand has closed, fingers pull with less than the closing torque: {words.listed(needs)}"
        if beyond := [joints[k] for k in np.flatnonzero(shares > DRIVEN).tolist()]:
            whose = "its" if len(beyond) == 1 else "their"
            text += f"; turning on, they would drive {words.listed(beyond)} farther beyond {whose} closing torque"
        elif stuck:
            text += "; no state was found in which they press harder, and what stops them is not known"
        values = [
            {"joint": joints[k], "torque_Nm": float(shares[k] * asked[k]), "asked_Nm": float(asked[k])} for k in short
        ]
        yield Reason("closing_torque", "warning", text, {"joints": values})
