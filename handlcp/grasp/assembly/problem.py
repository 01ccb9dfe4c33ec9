"""The problem that a grasp assembles: an LCP with a multiplier a face, or a contact problem with friction as a set."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.assembly.candidate import Candidate, decode, encode
from handlcp.grasp.assembly.catalogue import called_for
from handlcp.grasp.assembly.contact_form import GraspContact
from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import Cone, Interval, Pyramid, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.unknowns import System, Unknown, layout
from handlcp.lazy import lazy
from handlcp.lcp import LCP, Units
from handlcp.lcp.kernels.compile import kernel
from handlcp.lcp.kernels.schur import schur
from handlcp.lcp.problem import Scaled
from handlcp.tolerances import ELIMINATE_RCOND

__all__ = ["AnyProblem", "GraspProblem", "assemble", "assemble_contact", "assemble_lcp"]


class GraspProblem(LCP):
    """The assembled problem: an `LCP` that knows what its unknowns mean.

    groups : the unknowns of all effects, complementary groups first.
    eliminated : whether the free unknowns (tangential forces and object motion) were eliminated; M and q are then
        the Schur complement, a standard LCP (paper, equation (17)), otherwise the mixed problem itself.
    rcond : estimate of the reciprocal condition of the free block, which decided that.
    effects : what was stamped. scene, section : what was assembled.
    """

    def __init__(self, scene: Scene, section: Section, asked: tuple[Effect, ...]) -> None:
        self.scene, self.section, self._asked = scene, section, asked
        self.effects: tuple[Effect, ...] = (*called_for(scene, section, multipliers=True), *asked)
        self.system = System(layout(u for e in self.effects for u in e.unknowns(scene)))
        for e in self.effects:
            e.stamp(scene, self.system)
        system, n = self.system, len(self.system.q)
        c, (z, w) = system.layout.free_from, system.sizes(scene)
        M, q, X, x0, self.rcond = schur(system.M, system.q, c)
        self.eliminated = self.rcond > ELIMINATE_RCOND
        self._back = (X, x0) if self.eliminated else None
        free = np.arange(n) >= c
        if self.eliminated:
            free, z, w = free[:c], z[:c], w[:c]
        else:
            M, q = system.M, system.q
        self._hold(Scaled(read_only(M), read_only(q), free, Units(z, w)))

    @property
    def groups(self) -> tuple[Unknown, ...]:
        """The unknowns of all effects, complementary groups first."""
        return self.system.layout.groups

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown of this problem, such as "r_N[2]"."""
        return self.system.layout.labels(tuple(g for g in self.groups if not (self.eliminated and g.free)))

    def every(self, z: Array) -> Array:
        """(N,) all unknowns, the eliminated ones included, from z (n,), natural units."""
        if self._back is None:
            return z
        X, x0 = self._back
        return np.concatenate([z, x0 - X @ z])

    def candidate(self, z: Array) -> Candidate:
        """Forces and motion from z (n,) in natural units."""
        return decode(self.scene, self.system, self.every(z))

    def complete(self) -> None:
        """Compute now what is otherwise computed when first asked for."""
        self.M, self.contact  # noqa: B018
        if self.contact is not None:
            self.contact.complete()

    @lazy
    def contact(self) -> GraspContact | None:
        """The same scene and the same section with friction as a set: smaller, and what the default chain works on.
        None where contacts are soft: multipliers of a polyhedron do not follow from the slip alone.
        """
        return None if self.scene.soft else assemble_contact(self.scene, self.section, self._asked)

    def natural(self, candidate: Candidate) -> Array:
        """(n,) z with these forces, motion and unknowns of further effects, the way back from `candidate`."""
        if self.contact is None:
            return encode(self.scene, self.system, candidate)[: self.n]
        return self.lift(self.contact.natural(candidate))

    def lift(self, x: Array) -> Array:
        """(n,) z of this problem from x of `contact`, natural units: the multipliers follow from the slip.

        -ε_T = Σ λ_j n_j has a solution with at most two λ_j > 0, those of the faces whose normals enclose -ε_T.
        """
        contact, at = self.contact, self.system.at
        assert contact is not None  # who has an x has it from there
        full = np.zeros(len(self.system.q))
        for name, there in contact.system.at.items():
            full[at[name]] = x[there]
        if "λ" in at:
            tangents = contact.blocks[:, 1:]
            raise_multipliers(contact.M, contact.q, x, tangents, contact.faces, full[at["λ"]])
        return full[: self.n]


AnyProblem = GraspProblem | GraspContact


def assemble(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> AnyProblem:
    """The problem as `Grasp.problem` gives it: a multiplier a face, or friction as a set on the exact cone.

    asked : effects asked for that have rows of their own.
    """
    make = assemble_contact if isinstance(section, Cone) else assemble_lcp
    return make(scene, section, asked)


def assemble_lcp(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspProblem:
    """A multiplier a face; the free unknowns are eliminated where their block is well conditioned."""
    return GraspProblem(scene, section, asked)


def assemble_contact(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspContact:
    """Friction as a set, whatever the section: what the default chain works on."""

    def pyramid(faces: int) -> tuple[LCP, Callable[[Array], Array]]:
        """The same scene as a plain LCP with so many faces (planar: exact), and how its z becomes an x of `contact`."""
        own = section if section.faces == faces else Interval() if scene.kind.planar else Pyramid(faces)
        lcp = assemble_lcp(scene, own, asked)

        def back(z: Array) -> Array:
            full, x = lcp.every(z), np.empty(contact.n)
            for name, at in contact.system.at.items():
                x[at] = full[lcp.system.at[name]]
            return x

        return lcp, back

    contact = GraspContact(scene, section, asked, pyramid)
    return contact


@kernel
def raise_multipliers(M: Array, q: Array, x: Array, tangents: Ints, faces: int, multipliers: Array) -> None:
    """Write λ ≥ 0 (k faces,) with Σ λ_j n_j = -ε_T, the slip of each contact's tangents (k, ≥ 2) in M x + q, on the two
    faces whose normals enclose it.
    """
    step = 2.0 * np.pi / faces
    for k in range(len(tangents)):
        i, o = tangents[k, 0], tangents[k, 1]
        a = -q[i]
        for j in range(len(x)):
            a -= M[i, j] * x[j]
        if o < 0:
            multipliers[2 * k], multipliers[2 * k + 1] = max(a, 0.0), max(-a, 0.0)
            continue
        b = -q[o]
        for j in range(len(x)):
            b -= M[o, j] * x[j]
        angle = np.arctan2(b, a) % (2.0 * np.pi)
        first = int(angle / step)
        rest = angle - first * step
        size = np.hypot(a, b) / np.sin(step)
        multipliers[faces * k + first % faces] = size * max(np.sin(step - rest), 0.0)
        multipliers[faces * k + (first + 1) % faces] += size * max(np.sin(rest), 0.0)
