"""What happens while a grasp is loaded: a finger slips or lets go, a joint reaches its limit, the object is lost."""

from __future__ import annotations

from dataclasses import dataclass

from handlcp import words

__all__ = ["Event"]

_SENTENCES = {
    "slips": "{who} begins to slip", "sticks": "{who} sticks again", "opens": "{who} loses contact",
    "touches": "{who} touches the object", "over limit": "{who} needs more than its torque limit",
    "within limit": "{who} is within its torque limit again", "yields": "{who} yields at its torque limit",
    "holds": "{who} holds again, below its torque limit", "range end": "{who} passes the end of its range",
    "range": "{who} is within its range again", "lost": "the object is lost: {who}",
    "snaps": "{who} snaps to another place",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Event:
    """kind : "slips", "sticks", "opens", "touches" (a contact), "over limit", "within limit", "yields", "holds",
    "range end", "range" (a joint), "snaps" (the object, which comes to rest again elsewhere), "lost". who : the finger,
    the joint or "the object"; for "lost" the reason. stage : its name.
    share : of the stage, 0 to 1, when it was there; it came after the step before. number : of the stage, from 0.
    """

    kind: str
    who: str
    stage: str
    share: float
    number: int = 0

    def __str__(self) -> str:
        return f"{self.stage}, {words.percent(self.share)}: {_SENTENCES[self.kind].format(who=self.who)}"
