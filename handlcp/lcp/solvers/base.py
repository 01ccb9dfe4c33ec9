"""What every solver is."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from handlcp.check import Array
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import Scaled
from handlcp.lcp.result import Proposal


@runtime_checkable
class Solver(Protocol):
    """A method with its settings. It proposes; the certifier decides."""

    def propose(self, problem: Scaled, start: Array | None = None) -> Proposal:
        """A candidate for the problem in natural units, from `start` (n,) natural units, zero when None."""
        ...


@runtime_checkable
class ContactSolver(Protocol):
    """A method that knows friction as a set, the exact cone included. Most are a `Solver` as well."""

    def propose_contact(self, problem: ContactProblem, start: Array | None = None) -> Proposal:
        """A candidate x (n,) in natural units, from `start` (n,) or, when None, from where the method sees fit."""
        ...
