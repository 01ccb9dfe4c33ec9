"""A solve step by step, for those who time its parts: the one call of the first stage, and the same from Python."""

import re
from types import SimpleNamespace

from handlcp.grasp.analysis.explanation import measure_shares
from handlcp.grasp.assembly.problem import assemble
from handlcp.grasp.solve import (
    compiled_answer as _first,  # its kernels are looked up there, where a clock may have been put around them
)
from handlcp.grasp.solve.solve_spec import CheckedCandidate, make_solution
from handlcp.lcp import NSNGRK, certify, proposals
from handlcp.lcp.certificate import certify_contact
from tests.support.grasp import arrays, contact_problem, judge_of, section_of


class ByHand:
    """The same from Python: every step leaves here what the next one takes."""

    def __init__(self, grasp, faces):
        self.grasp, self.faces, self.section = grasp, faces, section_of(grasp, faces)

    def units(self):
        """Natural units and blocks of the scene, computed when first asked for."""
        arrays(self.grasp).units  # noqa: B018

    def assemble(self):
        """Effects stamped."""
        self.problem = contact_problem(self.grasp, self.faces, ())

    def scale(self):
        """Rows scaled."""
        self.problem.arrays  # noqa: B018

    def solve(self, seed=None):
        """What NSNGRK proposes; as the first stage does it where a seed is given, as the chain does it elsewhere."""
        if seed is None:
            _, self.proposal = next(proposals(self.problem))
        else:
            self.proposal = NSNGRK(max_iterations=self.problem.n, seed=seed).propose_contact(self.problem)
        return self.proposal

    def decode(self):
        """Forces and motion."""
        self.candidate = self.problem.candidate(self.proposal.z)
        return self.candidate

    def certify(self):
        """The certifier's verdict, from the physics."""
        self.verdict = judge_of(self.grasp, self.problem.effects, self.section, self.candidate)
        return self.verdict

    def conclude(self):
        """States, uniqueness, the answer in SI, without what a hand adds to it."""
        g = self.grasp
        return self._made(g.spec.replace(mechanism=None))

    def finish(self):
        """The same with what a hand adds."""
        return self._made(self.grasp.spec)

    def _made(self, spec):
        checked = CheckedCandidate(self.candidate, self.verdict, 1)
        return make_solution(spec, self.grasp.scene, self.section, self.problem.effects, checked, ())


def first_found(grasp, faces, seed=0):
    """What the first stage finds: proposal, forces, twist, motion, residuals, states, passes, unique, outcome."""
    return told(_first.solve_scene(grasp.scene, section_of(grasp, faces), seed))


def told(found):
    """What a compiled answer says, by these names."""
    return SimpleNamespace(
        proposal=found.proposal, outcome=found.proposal.outcome, iterations=found.iterations,
        forces=found.candidate.forces, twist=found.twist, motion=found.motion, residuals=found.residuals,
        states=found.states, passes=found.passes, unique=found.is_unique, escape=found.escape,
    )  # fmt: skip


def newton_steps(line):
    """How many Newton steps a line of a trace tells of."""
    told = re.search(r"(\d+) Newton steps", line)
    return 0 if told is None else int(told[1])


# ---------------------------------------------------------------- assembly
def assembly(grasp, faces):
    """The problem of a grasp with the effects that its data call for."""
    return assemble(grasp.scene, section_of(grasp, faces), ())


def certificate(problem, z, proposed=None):
    """The certifier's word, from M and q: on z in SI, or on what was proposed for a problem with friction as a set."""
    return certify(problem, z) if proposed is None else certify_contact(problem, proposed)


# ---------------------------------------------------------------- shares of the time
def shares(grasp, faces, solution, clock):
    """`grasp.explain(faces, measure=True)` with times from a clock."""
    return measure_shares(grasp.spec, section_of(grasp, faces), grasp.explain(faces), solution, clock)
