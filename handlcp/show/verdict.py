"""The verdict in plain words: held or not, what gives out first, what slides, how far the object moves.

HELD needs a certified equilibrium *and* motors that can hold it: a joint over its torque limit makes it OVER LIMIT.
Joints without a known limit are not judged, and the verdict says so. UNDECIDED claims nothing about the grasp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.grasp import FingerForceBound, Grasp, GraspSolution, KnownForce, PrescribedForce, TotalForceBound
from handlcp.lcp import Status
from handlcp.show import units

__all__ = ["Verdict", "largest_motion", "verdict"]

SMALL_TURN = 0.1  # [rad] the model is linear in the motions: cos(0.1) is off by half a percent
SMALL_MOVE = 0.2  # of the grasp's size


@dataclass(frozen=True, slots=True)
class Verdict:
    """word : "HELD", "OVER LIMIT", "NOT HELD" or "UNDECIDED". text : the rest of the sentence. notes : caveats.

    exit_code : 0 held, 1 anything else.
    """

    word: str
    text: str
    notes: tuple[str, ...] = ()

    @property
    def exit_code(self) -> int:
        """For the shell."""
        return 0 if self.word == "HELD" else 1

    @property
    def colour(self) -> str:
        """For rich."""
        return {"HELD": "green", "UNDECIDED": "yellow"}.get(self.word, "red")

    def __str__(self) -> str:
        """One sentence, then the notes."""
        return "\n".join([f"{self.word}: {self.text}.", *(f"Note: {n}." for n in self.notes)])


def verdict(grasp: Grasp, solution: GraspSolution) -> Verdict:
    """From the certified status, the torques and the motions of a solution; what is not held, in the words of its
    `diagnosis`.
    """
    if solution.status is Status.SOLVED:
        return _held(grasp, solution)
    if solution.status is Status.UNDECIDED:
        return Verdict(
            "UNDECIDED",
            "the solver stopped before it found an answer, which says nothing about the grasp; "
            "try another seed or number of faces, or more preload",
        )
    return Verdict("NOT HELD", solution.diagnosis)


def largest_motion(grasp: Grasp, solution: GraspSolution) -> float:
    """How far the object's contact points travel at most [m]: the larger of its shift and its turn times the size."""
    u = solution.object_displacement
    return float(max(np.linalg.norm(u[:3]), np.linalg.norm(u[3:]) * grasp.scene.units.length))


def _held(grasp: Grasp, s: GraspSolution) -> Verdict:
    parts, notes = [], []
    check: Any = getattr(s, "torque_check", None)
    word = "HELD"
    if check is not None:
        if over := check.over:
            word = "OVER LIMIT"
            listed = ", ".join(
                f"{r.joint} needs {units.torque(abs(r.torque))} of {units.torque(r.limit)}" for r in over
            )
            parts.append(f"the contacts could hold the object, the motors cannot: {listed}")
        elif check.binding is not None:
            r = check[check.binding]
            share, limit = units.percent(r.utilisation), units.torque(r.limit)
            parts.append(
                f"the binding joint is {r.joint} at {share} of {limit}"
                if np.isfinite(r.limit)
                else "no joint has a limit"
            )
        if check.yielding:
            parts.append(f"{_listed(check.yielding)} {'yield' if len(check.yielding) > 1 else 'yields'} at the limit")
        if check.unknown:
            notes.append(f"torque limits not known, torques not judged: {_listed(check.unknown)}")
    parts += _at_bounds(grasp, s)
    parts += [_sliding(s, "contacts" if grasp.scene.environment else "fingers"), _motion(grasp, s)]
    if s.uniqueness is not None:
        if not s.uniqueness.forces_determined:
            notes.append("other forces satisfy the same conditions; the smallest are given")
        if k := s.uniqueness.loose_motions:
            notes.append(f"the object is loose in {k} direction{'s' if k > 1 else ''}; the smallest motion is given")
        if s.uniqueness.others:
            notes.append("friction can hold the object in other ways, too; grasp.equilibria() lists them")
    turn, move = float(np.linalg.norm(s.object_displacement[3:])), largest_motion(grasp, s)
    if turn > SMALL_TURN or move > SMALL_MOVE * grasp.scene.units.length:
        how_far = f"the object moves {units.length(move)} and turns {units.angle(turn)}"
        notes.append(f"{how_far}: more than a model of small motions covers")
    notes += _far(grasp, s)
    return Verdict(word, "; ".join(p for p in parts if p), tuple(notes))


def _far(grasp: Grasp, s: GraspSolution) -> list[str]:
    """What else is too large for a model of small motions: slips, squeezes, joints that yield."""
    most = SMALL_MOVE * grasp.scene.units.length
    slip, squeeze = float(np.hypot(*s.slip.T).max()), -float(grasp.offset[:, 2].min())
    yielded = float(abs(getattr(s, "joint_yield", np.zeros(1))).max())
    large = [
        (f"a slip of {units.length(slip)}", slip > most),
        (f"a squeeze of {units.length(squeeze)}", squeeze > most),
        (f"a joint that yields by {units.angle(yielded)}", yielded > SMALL_TURN),
    ]
    named = [words for words, too_far in large if too_far]
    return [f"{' and '.join(named)}: more than a model of small motions covers"] if named else []


def _at_bounds(grasp: Grasp, s: GraspSolution) -> list[str]:
    """Which bounds on forces are reached, and how far what they hold back gives way."""
    out = []
    for e in grasp.effects:
        if isinstance(e, (TotalForceBound, FingerForceBound)):
            for limit in e.present(grasp.scene):
                way, rows = s.extra[limit.name], limit.rows
                at = [s.names[int(np.flatnonzero(rows[k])[0]) // 3] for k in np.flatnonzero(way > units.NOTHING)]
                whose = f" at {_listed(at)}" if isinstance(e, FingerForceBound) else ""
                if at:
                    out.append(f"the {e.title} is reached{whose} and gives way by {units.length(float(way.max()))}")
        elif isinstance(e, KnownForce):
            moved = [s.extra[limit.name] for limit in e.present(grasp.scene)]
            if moved and (far := float(abs(moved[0] - moved[1]).max())) > units.NOTHING:
                out.append(f"{s.names[e.contact]} moves by {units.length(far)} to push as it is known to")
        elif isinstance(e, PrescribedForce) and e.force[2] < 0.0:
            out.append(f"{s.names[e.contact]} pulls, as prescribed")
    return out


_TWIST = 1e-4  # rad on the object below which a soft finger is not said to twist


def _sliding(s: GraspSolution, who: str) -> str:
    slips = np.hypot(*s.slip.T)
    sliding = [(n, float(d)) for n, state, d in zip(s.names, s.contact_state, slips, strict=True) if state == "sliding"]
    spins = np.zeros(len(slips)) if s.spin is None else abs(s.spin)
    turns = [(n, float(a)) for n, a in zip(s.names, spins, strict=True) if a > _TWIST]
    apart = [n for n, state in zip(s.names, s.contact_state, strict=True) if state == "separated"]
    parts = []
    if sliding and len(sliding) == len(s.names) > 1:
        parts.append(f"all {who} slide, up to {units.length(max(d for _, d in sliding))}")
    elif sliding:
        parts.append(", ".join(f"{n} slides {units.length(d)}" for n, d in sliding if d > units.NOTHING or not turns))
        parts.append(", ".join(f"{n} twists by {units.angle(a)} on the object" for n, a in turns))
    if apart:
        parts.append(f"{_listed(apart)} {'let' if len(apart) > 1 else 'lets'} go")
    return "; ".join(p for p in parts if p) or f"all {who} stick"


def _motion(grasp: Grasp, s: GraspSolution) -> str:
    u, load = s.object_displacement, grasp.scene.force
    move, turn = float(np.linalg.norm(u[:3])), float(np.linalg.norm(u[3:]))
    size = float(np.linalg.norm(load))
    if max(move, turn * grasp.scene.units.length) < units.NOTHING:
        return "the object stays where it is"
    text = f"the object moves {units.length(move)}"
    if size > 0:
        along = float(u[:3] @ load) / size
        way = "along" if along >= 0 else "against"
        same = units.length(abs(along)) == units.length(move)
        text += f" {way} the load" if same else f", {units.length(abs(along))} of it {way} the load,"
    return f"{text} and turns {units.angle(turn)}" if turn > 1e-4 else text.removesuffix(",")


def _listed(names: Any) -> str:
    """At most four names."""
    names = list(names)
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
