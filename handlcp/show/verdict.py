"""The verdict in words: held or not, which joint limits the grasp, what slides, how far the object moves.

HELD needs a certified equilibrium and motors that can hold it; with a joint over its torque limit the verdict is OVER
LIMIT. Joints without a known limit are not judged, and a note says so. UNDECIDED says nothing about the grasp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.grasp import Grasp, GraspSolution
from handlcp.lcp import Status

__all__ = ["SMALL_MOVE", "SMALL_TURN", "Verdict", "verdict"]

SMALL_TURN = 0.1  # [rad] the model is linear in the motions: cos(0.1) is off by half a percent
SMALL_MOVE = 0.2  # of the grasp's size
_TWIST = 1e-4  # [rad] a soft finger that turns less on the object is not said to twist


@dataclass(frozen=True, slots=True)
class Verdict:
    """word : "HELD", "OVER LIMIT", "NOT HELD" or "UNDECIDED". text : the rest of the sentence. notes : caveats."""

    word: str
    text: str
    notes: tuple[str, ...] = ()

    @property
    def exit_code(self) -> int:
        """For the shell: 0 held, 1 anything else."""
        return 0 if self.word == "HELD" else 1

    @property
    def colour(self) -> str:
        """For the terminal."""
        return {"HELD": "green", "UNDECIDED": "yellow"}.get(self.word, "red")

    def __str__(self) -> str:
        return "\n".join([f"{self.word}: {self.text}.", *(f"Note: {n}." for n in self.notes)])


def verdict(grasp: Grasp, solution: GraspSolution) -> Verdict:
    """The verdict on a solution: its certified status, its joint torques and its motions."""
    if solution.status is Status.UNDECIDED:
        why = "the solver stopped before it found an answer, which says nothing about the grasp"
        return Verdict("UNDECIDED", f"{why}; try another seed or number of faces, or more preload")
    if not solution.held:
        return Verdict("NOT HELD", solution.diagnosis)
    word, parts, notes = _joints(getattr(solution, "torque_check", None))
    for e in grasp.spec.effects:  # which bounds are reached, and how far they give way
        parts += e.words(grasp.scene, solution.names, solution.extra)
    parts += [*_sliding(grasp, solution), _motion(grasp, solution)]
    notes += [*_not_unique(solution), *_too_far(grasp, solution)]
    return Verdict(word, "; ".join(parts), tuple(notes))


def _joints(check: Any) -> tuple[str, list[str], list[str]]:
    """(word, parts of the sentence, notes) from a `TorqueCheck`, None without a hand."""
    if check is None:
        return "HELD", [], []
    word, parts, notes = "HELD", [], []
    if check.over:
        word = "OVER LIMIT"
        needs = (f"{r.joint} needs {words.torque(abs(r.torque))} of {words.torque(r.limit)}" for r in check.over)
        parts.append(f"the contacts could hold the object, the motors cannot: {', '.join(needs)}")
    elif check.binding is not None:
        r = check[check.binding]
        share = f"{words.percent(r.utilisation)} of {words.torque(r.limit)}"
        finite = np.isfinite(r.limit)
        parts.append(f"the binding joint is {r.joint} at {share}" if finite else "no joint has a limit")
    if check.yielding:
        parts.append(f"{words.listed(check.yielding)} {'yield' if len(check.yielding) > 1 else 'yields'} at the limit")
    if check.unknown:
        notes.append(f"torque limits not known, torques not judged: {words.listed(check.unknown)}")
    return word, parts, notes


def _not_unique(s: GraspSolution) -> list[str]:
    """What the equations leave open."""
    notes: list[str] = []
    if s.uniqueness is None:
        return notes
    if not s.uniqueness.forces_determined:
        notes.append("other forces satisfy the same conditions; the smallest are given")
    if k := s.uniqueness.loose_motions:
        notes.append(f"the object is loose in {k} direction{'s' if k > 1 else ''}; the smallest motion is given")
    if s.uniqueness.others:
        notes.append("friction can hold the object in other ways, too; grasp.equilibria() lists them")
    return notes


def _too_far(grasp: Grasp, s: GraspSolution) -> list[str]:
    """Motions that a linear model does not describe: of the object, and slips, squeezes, joints that yield."""
    size = grasp.scene.units.length
    shift, turn = (float(np.linalg.norm(part)) for part in (s.object_displacement[:3], s.object_displacement[3:]))
    move = max(shift, turn * size)  # of the object's contact points, at most
    slip, squeeze = float(np.hypot(*s.slip.T).max()), -float(grasp.offset[:, 2].min())
    yielded = float(abs(getattr(s, "joint_yield", np.zeros(1))).max())
    far = []
    if turn > SMALL_TURN or move > SMALL_MOVE * size:
        far.append(f"the object moves {words.length(move)} and turns {words.angle(turn)}")
    large = [
        (f"a slip of {words.length(slip)}", slip > SMALL_MOVE * size),
        (f"a squeeze of {words.length(squeeze)}", squeeze > SMALL_MOVE * size),
        (f"a joint that yields by {words.angle(yielded)}", yielded > SMALL_TURN),
    ]
    if named := [words for words, too_far in large if too_far]:
        far.append(" and ".join(named))
    return [f"{what}: more than a model of small motions covers" for what in far]


def _sliding(grasp: Grasp, s: GraspSolution) -> list[str]:
    """Which contacts slide, twist on the object or let go; "all stick" where none does."""
    who, slips = "contacts" if grasp.scene.environment else "fingers", np.hypot(*s.slip.T).tolist()
    spins = np.zeros(len(slips)) if s.spin is None else abs(s.spin)
    sliding = [(n, d) for n, state, d in zip(s.names, s.contact_state, slips, strict=True) if state == "sliding"]
    turns = [(n, float(a)) for n, a in zip(s.names, spins, strict=True) if a > _TWIST]
    apart = [n for n, state in zip(s.names, s.contact_state, strict=True) if state == "separated"]
    parts = []
    if sliding and len(sliding) == len(s.names) > 1:
        parts.append(f"all {who} slide, up to {words.length(max(d for _, d in sliding))}")
    elif sliding:
        parts.append(", ".join(f"{n} slides {words.length(d)}" for n, d in sliding if d > words.NOTHING or not turns))
        parts.append(", ".join(f"{n} twists by {words.angle(a)} on the object" for n, a in turns))
    if apart:
        parts.append(f"{words.listed(apart)} {'let' if len(apart) > 1 else 'lets'} go")
    return [p for p in parts if p] or [f"all {who} stick"]


def _motion(grasp: Grasp, s: GraspSolution) -> str:
    """How far the object moves, how much of that along the load, and how far it turns."""
    u, load = s.object_displacement, grasp.scene.force
    move, turn = float(np.linalg.norm(u[:3])), float(np.linalg.norm(u[3:]))
    size = float(np.linalg.norm(load))
    if max(move, turn * grasp.scene.units.length) < words.NOTHING:
        return "the object stays where it is"
    text = f"the object moves {words.length(move)}"
    if size > 0:
        along = float(u[:3] @ load) / size
        way = "along" if along >= 0 else "against"
        same = words.length(abs(along)) == words.length(move)
        text += f" {way} the load" if same else f", {words.length(abs(along))} of it {way} the load,"
    return f"{text} and turns {words.angle(turn)}" if turn > 1e-4 else text.removesuffix(",")
