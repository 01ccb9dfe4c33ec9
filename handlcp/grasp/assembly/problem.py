"""The problem that a grasp assembles: friction as a set, or as an LCP with a multiplier a face."""

from __future__ import annotations

from handlcp.check import Array
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.assembly.contact_form import GraspContactProblem
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Cone, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import Unknown, labels
from handlcp.lazy import lazy
from handlcp.lcp.multipliers import WithMultipliers

MULTIPLIERS = {"r_T": "λ", "r_S": "λ_S"}  # by the tangential forces that they belong to


class GraspProblem(WithMultipliers):
    """The assembled problem: an `LCP` that knows what its unknowns mean.

    eliminated : whether the free unknowns (tangential forces and object motion) were eliminated; M and q are then
        the Schur complement, a standard LCP (paper, equation (17)), otherwise the mixed problem itself.
    rcond : estimate of the reciprocal condition of the free block, which decided that.
    contact : the same scene and section with friction as a set: smaller, and what the default chain works on.
    effects : what was stamped. scene, section : what was assembled.
    """

    contact: GraspContactProblem

    def __init__(self, contact: GraspContactProblem) -> None:
        super().__init__(contact, behind=sum(contact.system.layout.forces[:2]))
        self.scene, self.section, self.effects = contact.scene, contact.section, contact.effects

    @lazy
    def groups(self) -> tuple[Unknown, ...]:
        """The unknowns of all effects, complementary groups first."""
        own, points = self.contact.groups, len(self.scene.rough)
        counts = {"r_T": sum(self.faces[:points]), "r_S": sum(self.faces[points:])}
        made = [Unknown(MULTIPLIERS[g.name], counts[g.name], False, "motion") for g in own if g.name in counts]
        behind = 1 if own[0].name == "r_N" else 0
        return (*own[:behind], *made, *own[behind:])

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown of this problem, such as "r_N[2]"."""
        return labels(tuple(g for g in self.groups if not (self.eliminated and g.free)))

    def candidate(self, z: Array) -> Candidate:
        """Forces and motion from z (n,) in natural units."""
        return self.contact.candidate(self.back(z))

    def natural(self, candidate: Candidate) -> Array:
        """(n,) z with these forces, motion and unknowns of further effects, the way back from `candidate`."""
        return self.lift(self.contact.natural(candidate))

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.M  # noqa: B018
        self.contact.complete()


AnyProblem = GraspProblem | GraspContactProblem


def assemble(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> AnyProblem:
    """The problem as `Grasp.problem` gives it: a multiplier a face, or friction as a set on the exact cone.

    asked : effects asked for that have rows of their own.
    """
    contact = GraspContactProblem(scene, section, asked)
    return contact if isinstance(section, Cone) else GraspProblem(contact)
