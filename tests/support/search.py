"""Doors into proofs and searches: which contact modes have a point, which loads nothing within limits can balance."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

import handlcp as hl
from handlcp.grasp.analysis.equilibria import seeded_candidates
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.solve.equilibrium_search import (
    ContactModeSearch,
    EquilibriumSearch,
    first_certified,
    has_only_limits,
    search_modes,
)
from handlcp.grasp.verify.load_capacity import (
    is_escape as _is_escape,
    is_jammed as _jammed,
    least_normal_sum as _least_total,
    prove_overload as _overload,
)
from handlcp.lcp.certificate import search_active_sets
from tests.support.grasp import contact_problem, plain_problem, residuals, section_of


# ---------------------------------------------------------------- is there an equilibrium?
def searched(grasp, faces, *more, work=1e10):
    """What the search over contact modes finds; an equilibrium only if the certifier passes it.

    more : effects beside the grasp's own. work : multiply-adds at most.
    """
    problem = contact_problem(grasp, faces, (*grasp.effects, *more))
    if not has_only_limits(problem):
        raise ValueError(EquilibriumSearch(problem).run(work).words)
    on_active_sets = problem.faces and problem.scene.soft
    found = EquilibriumSearch(problem).run(work) if on_active_sets else search_modes(ContactModeSearch(problem), work)
    if found.candidate is not None:
        assert residuals(grasp, faces, found.candidate, *more).passes
    outcome = found.words.rpartition(" ")[2]
    within = (np.nan, np.nan) if found.bounds is None else found.bounds
    return SimpleNamespace(outcome=outcome, candidate=found.candidate, force_bound=within[0], motion_bound=within[1])


def applicable(effects):
    """Whether contact modes describe a scene with these effects."""
    return has_only_limits(SimpleNamespace(effects=tuple(effects)))


def active_sets(grasp, faces, work):
    """What the search over active sets of the plain LCP comes to: "solution", "none" or "unknown"."""
    problem = plain_problem(grasp, faces)
    return search_active_sets(
        problem, work=work, accept=lambda z: residuals(grasp, faces, problem.candidate(z)).passes
    ).outcome


def choices_of_modes(grasp, faces, *asked):
    """How many choices of contact modes there are, with these effects alone beside those that the data call for."""
    return ContactModeSearch(contact_problem(grasp, faces, asked)).search.choice_count


def members_of_modes(grasp, faces, *asked):
    """A candidate for each choice of modes that has one."""
    return list(ContactModeSearch(contact_problem(grasp, faces, asked)).each_choice(1e10))


def from_seeds(grasp, faces, count, seed=1):
    """The candidates that so many seeds lead to and that the certifier passes, as they are or after Newton's method."""
    problem = contact_problem(grasp, faces)
    for candidate in seeded_candidates(problem, count, seed):
        if (found := first_certified(problem, [candidate])) is not None:
            yield found


# ---------------------------------------------------------------- what no forces can balance
def overload(grasp, faces):
    """The proof that the limits of the grasp's effects leave no forces that balance the load, if there is one."""
    return _overload(grasp.scene, section_of(grasp, faces), grasp.effects)


def is_overload(grasp, faces, proof):
    """Whether that is one, by its signs."""
    return _is_escape(grasp.scene, section_of(grasp, faces), proof, grasp.effects)


def is_escape(grasp, faces, twist):
    """Whether a motion in natural units proves by its signs that nothing balances the grasp's load."""
    return _is_escape(grasp.scene, section_of(grasp, faces), twist)


def least_total(grasp, faces):
    """Least sum of the fingers' normal forces [N] with which friction balances the load; None: none does."""
    return _least_total(grasp.scene, section_of(grasp, faces))


def jammed(grasp):
    """Whether rigid fingers overlap the object and cannot give way."""
    return _jammed(grasp.scene)


# ---------------------------------------------------------------- limits without a hand
class _Joints(Mechanism):
    """Joints that carry contacts without turning them."""

    def jacobian_rows(self, soft):
        return np.concatenate([self.jacobian, np.zeros((len(soft), len(self.names)))])


class _Saturation(hl.TorqueSaturation):
    """The effect with joints of its own, for grasps without a hand."""

    title = ""  # no effect of the catalogue

    def __init__(self, joints):
        self.joints = joints

    def limits(self, scene):
        return super().limits(replace(scene, mechanism=self.joints))


def saturation(contacts, jacobian, limits):
    """The effect for contacts of fingers whose joints have this Jacobian (3n, nv) and these torque limits (nv,)."""
    nv = len(limits)
    return _Saturation(_Joints(("",) * nv, jacobian, np.eye(nv), limits))
