"""The verdict: does it hold? One word, and the reasons for it.

| code | what it is about |
| --- | --- |
| `not_holdable`, `no_equilibrium` | no force within friction balances the load; no elastic equilibrium exists |
| `no_squeeze` | nothing was said that closes the hand, and the load is not held without |
| `lost` | the order of loading loses the object on its way |
| `slides_through` | the object slides through, or snaps, on its way: how far it jumps is not for statics to say |
| `steps_differ` | fewer and more steps of loading end differently |
| `solver_stopped`, `follow_stopped` | a solver, or the loading in steps, ended without an answer |
| `link_inside`, `joint_range` | a posture that the hand cannot take: a link inside the object, a joint past its range |
| `large_motion`, `followed_forces` | motions, or forces, that the equations of small motions miss |
| `torque_over_limit`, `torque`, `limit_unknown`, `limit_doubtful` | what the joints bear, and what is known of it |
| `tension_over_limit`, `tension`, `slack` | what tendons bear, and which of them hang slack |
| `closing_torque` | fingers that pull with less than was asked for, once the hand has closed |
| `overheats`, `closing_over_peak` | what motors of joints or tendons hold for a while; what closing takes beyond peak |
| `limit_shared` | limits of motors that are those of no joint alone: whether motors hold is not known |
| `hand_doubtful` | a serious doubt of the hand's audit that is not about torque limits |
| `unplaced` | a sample of a study that is no grasp, such as one with a contact past an edge |
| `rigid_tips` | fingertips without pads, where that may be why the object is lost |
| `torques_open` | between what and what torques are, where statics leaves forces open |
| `command_not_made` | a command that tendons, which only pull, or servos make in part alone |
| `out_of_reach` | a part of the squeeze that no command of the joints makes |
| `effect`, `contacts`, `motion` | bounds reached; what slides or lets go; how the object moves |
| `no_load` | neither a weight nor a wrench loads the object |
| `weight_left_out` | `replace(wrench=...)` gave the whole load, without the object's weight |
| `friction` | how much of their friction the contacts use that stick |
| `forces_open`, `loose`, `others` | what the equations leave open |
| `snaps` | the object leaves its place on the way, and comes to rest at another |
| `not_followed`, `only_followed` | the order of loading was not followed; one solve and the steps disagree |
| `advice` | a change that was tried, and holds; or that nothing tried does |
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from handlcp.errors import RequirementNotMet
from handlcp.keywords import helped_methods
from handlcp.record import Record
from handlcp.text_table import wrapped

HELD, OVER_LIMIT, UNDECIDED, NOT_HELD = "HELD", "OVER LIMIT", "UNDECIDED", "NOT HELD"

_RANK = (NOT_HELD, UNDECIDED, OVER_LIMIT)  # the first that a reason decides is the word
_DECIDES = {
    "not_holdable": NOT_HELD, "no_equilibrium": NOT_HELD, "no_squeeze": NOT_HELD, "lost": NOT_HELD,
    "slides_through": NOT_HELD, "steps_differ": UNDECIDED, "solver_stopped": UNDECIDED,
    "follow_stopped": UNDECIDED, "link_inside": UNDECIDED, "joint_range": UNDECIDED, "large_motion": UNDECIDED,
    "torque_over_limit": OVER_LIMIT, "tension_over_limit": OVER_LIMIT, "overheats": OVER_LIMIT,
    "closing_over_peak": OVER_LIMIT, "unplaced": UNDECIDED, "command_not_made": UNDECIDED,
    "limit_shared": UNDECIDED,
}  # fmt: skip
_HEADS = {"warning": "Warning", "advice": "Advice"}


@dataclass(frozen=True, slots=True)
class Reason:
    """One reason of a verdict.

    code : what it is about, see the top of this file. severity : "decides": with it the word cannot be HELD;
    "warning": a doubt about the word; "note": what is so; "advice": what would help. sentence : without a full stop.
    values : its numbers and names, SI units in the keys.
    """

    code: str
    severity: str
    sentence: str
    values: Mapping[str, Any] = field(default_factory=dict)


@helped_methods
@dataclass(frozen=True, slots=True)
class Verdict(Record):
    """Does it hold? Prints as the word and the reasons, in lines of at most 80 columns; its `repr` is the word and what
    decides it, on one line, so that pytest says why `assert grasp.check().ok` fails.

    word : "HELD"; "OVER LIMIT": the contacts hold, some motor cannot; "NOT HELD"; "UNDECIDED": no
    verdict can be given, since a solver stopped or the model does not hold there.
    reasons : those that decide the word first, then notes, warnings and advice.
    loading : the `Loading` that `grasp.check()` followed, whose last step the reasons are about; None where none was.
    """

    entries = ("word", "ok", "reasons")

    word: str
    reasons: tuple[Reason, ...]
    loading: Any = field(default=None, repr=False, compare=False)

    @property
    def ok(self) -> bool:
        """Whether the word is HELD."""
        return self.word == HELD

    @property
    def text(self) -> str:
        """What decides and what is so, in one sentence without the word and a full stop."""
        return "; ".join(r.sentence for r in self.reasons if r.severity not in _HEADS)

    @property
    def warnings(self) -> tuple[Reason, ...]:
        """The doubts about the word."""
        return tuple(r for r in self.reasons if r.severity == "warning")

    @property
    def paragraphs(self) -> tuple[tuple[str, str], ...]:
        """(head, sentence) of each printed paragraph: the word, then "Warning"s and "Advice"."""
        rest = [(_HEADS[r.severity], r.sentence) for r in self.reasons if r.severity in _HEADS]
        return ((self.word, self.text), *rest)

    def require(self) -> Self:
        """This verdict, where it is HELD. Raises RequirementNotMet with all that it says, what decides first."""
        __tracebackhide__ = True  # of pytest, which shows the test that asks, and what is not met
        if not self.ok:
            raise RequirementNotMet([f"{head}: {sentence}." for head, sentence in self.paragraphs])
        return self

    def about(self, code: str) -> tuple[Reason, ...]:
        """The reasons with this code."""
        return tuple(r for r in self.reasons if r.code == code)

    def __repr__(self) -> str:
        return f"{self.word}: {self.text}." if self.text else f"{self.word}."

    def __str__(self) -> str:
        said = (f"{head}: {sentence}." if sentence else f"{head}." for head, sentence in self.paragraphs)
        return "\n".join(wrapped(line) for line in said)


def verdict_of(reasons: Iterable[Reason], loading: Any = None) -> Verdict:
    """The verdict that these reasons make; of reasons with one sentence the first counts."""
    every = list({r.sentence: r for r in reversed(list(reasons))}.values())[::-1]
    deciding = [r for r in every if r.severity == "decides"]
    ranks = sorted(deciding, key=lambda r: _RANK.index(_DECIDES[r.code]))
    word = _DECIDES[ranks[0].code] if ranks else HELD
    by_kind = [[r for r in every if r.severity == kind] for kind in ("note", "warning", "advice")]
    return Verdict(word, (*ranks, *by_kind[0], *by_kind[1], *by_kind[2]), loading)
