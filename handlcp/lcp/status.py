"""What may come out of a solve. A status is the certifier's word, never the solver's."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """The value of each member is its meaning and what to do about it."""

    SOLVED = "solved: every condition was recomputed and holds within the stated residual"
    INFEASIBLE = "infeasible: no z ≥ 0 gives w = M z + q ≥ 0; the certificate y ≥ 0 proves it (Mᵀy ≤ 0, qᵀy < 0)"
    NO_EQUILIBRIUM = (
        "no elastic equilibrium: some contact forces balance the wrench, but these compliances and gaps cannot create "
        "them; squeeze harder (preload) or change the flexibility"
    )
    NOT_HOLDABLE = (
        "not holdable: no contact forces within friction balance the wrench; the certificate is a motion in which the "
        "object escapes; add or move fingers, or raise friction"
    )
    UNDECIDED = (
        "undecided: the solver's budget was spent without an answer; this says nothing about the scene; "
        "try more iterations, another seed or another solver"
    )

    @property
    def meaning(self) -> str:
        """The sentence for people."""
        return self.value
