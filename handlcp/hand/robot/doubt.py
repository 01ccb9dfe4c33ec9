"""One doubt about a hand, and how much it weighs."""

from __future__ import annotations

from dataclasses import dataclass

from handlcp import words

SEVERITIES = ("serious", "minor", "information")  # most important first


@dataclass(frozen=True, slots=True)
class Doubt:
    """One doubt: the joint or link (or several, or "hand"), what is doubtful, and what to pass instead.

    severity : "serious": it can change a verdict, beside which it is said again; "minor": it changes numbers;
    "information": nothing is wrong, and something was read in a way worth knowing. about : a word for what it is
    about, such as "torque limit", "range", "coupling", "geometry".
    """

    joint: str
    what: str
    advice: str
    severity: str = "minor"
    about: str = ""

    @property
    def sentence(self) -> str:
        """For a verdict, where many joints are shortened to four."""
        who = words.listed(self.joint.split(", "))
        if self.about == "torque limit":
            return f"the torque limits of {who} are doubtful: {self.what}; pass torque_limits"
        return f"{who}: {self.what}; pass {self.advice}"

    def __str__(self) -> str:
        return f"{self.joint}: {self.what} → {self.advice}"
