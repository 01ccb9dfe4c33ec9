"""Doors into proofs and searches: which contact modes have a point, which loads nothing within limits can balance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp.equilibria import Believer, applicable, find_equilibrium
from handlcp.grasp.holdable import is_escape as _is_escape
from handlcp.grasp.holdable import jammed as _jammed
from handlcp.grasp.holdable import least_total as _least_total
from handlcp.grasp.joints import Joints
from handlcp.grasp.last_resort import last_resort as _last_resort
from handlcp.grasp.mode_table import PER_SECOND, mode_table
from handlcp.grasp.others import seeded
from handlcp.grasp.overload import is_overload as _is_overload
from handlcp.grasp.overload import overload as _overload
from handlcp.lcp.search import search
from tests.support.grasp import arrays, contact_problem, plain_problem, residuals, section_of

__all__ = [
    "active_sets",
    "applicable",
    "choices_of_modes",
    "from_seeds",
    "is_escape",
    "is_overload",
    "jammed",
    "last_resort",
    "least_total",
    "members_of_modes",
    "overload",
    "saturation",
    "searched",
    "seconds_for",
]


# ---------------------------------------------------------------- is there an equilibrium?
def searched(grasp: hl.Grasp, faces: Any, *more: Any, **limits: Any) -> Any:
    """What the search over contact modes finds; an equilibrium only if the certifier passes it.

    more : effects beside the grasp's own. limits : seconds, bound [natural units].
    """
    effects = (*contact_problem(grasp, faces).effects, *more)
    found = find_equilibrium(arrays(grasp), effects, section_of(grasp, faces), **limits)
    if found.candidate is not None:
        assert residuals(grasp, faces, found.candidate, *more).passes
    return found


def active_sets(grasp: hl.Grasp, faces: Any, seconds: float) -> str:
    """What the search over active sets of the plain LCP comes to: "solution", "none" or "unknown"."""
    problem = plain_problem(grasp, faces)
    return search(
        problem, seconds=seconds, accept=lambda z: residuals(grasp, faces, problem.candidate(z)).passes
    ).outcome


def choices_of_modes(grasp: hl.Grasp, faces: Any, *asked: Any) -> float:
    """How many choices of contact modes there are, with these effects alone beside those that the data call for."""
    return mode_table(contact_problem(grasp, faces, asked)).choices


def members_of_modes(grasp: hl.Grasp, faces: Any, *asked: Any) -> list[Any]:
    """A candidate for each choice that has one, all choices visited one by one; None for one that has no member."""
    return list(mode_table(contact_problem(grasp, faces, asked)).visit()[0])


def from_seeds(grasp: hl.Grasp, faces: Any, count: int, seed: int = 1) -> Iterator[Any]:
    """The candidates that so many seeds lead to and that the certifier passes, as they are or after Newton's method."""
    problem = contact_problem(grasp, faces)
    believed = Believer(arrays(grasp), problem.effects, section_of(grasp, faces))
    for candidate in seeded(problem, count, seed):
        if (found := believed([candidate])) is not None:
            yield found


def last_resort(grasp: hl.Grasp, faces: Any, seconds: float) -> tuple[Any, Any, str]:
    """(candidate, bounds, words) of the exact search that a solve ends with."""
    return _last_resort(contact_problem(grasp, faces), section_of(grasp, faces), seconds)


def seconds_for(choices: float) -> float:
    """Time in which so many choices of modes are visited, as the package counts."""
    return choices / PER_SECOND


# ---------------------------------------------------------------- what no forces can balance
def overload(grasp: hl.Grasp, faces: Any) -> np.ndarray | None:
    """The proof that the limits of the grasp's effects leave no forces that balance the load, if there is one."""
    return _overload(arrays(grasp), section_of(grasp, faces), grasp.effects)


def is_overload(grasp: hl.Grasp, faces: Any, proof: np.ndarray) -> bool:
    """Whether that is one, by its signs."""
    return _is_overload(arrays(grasp), section_of(grasp, faces), grasp.effects, proof)


def is_escape(grasp: hl.Grasp, faces: Any, twist: np.ndarray) -> bool:
    """Whether a motion in natural units proves by its signs that nothing balances the grasp's load."""
    return _is_escape(arrays(grasp), section_of(grasp, faces), arrays(grasp).natural.w, twist)


def least_total(grasp: hl.Grasp, faces: Any) -> float | None:
    """Least sum of the fingers' normal forces [N] with which friction balances the load; None: none does."""
    return _least_total(arrays(grasp), section_of(grasp, faces), arrays(grasp).natural.w)


def jammed(grasp: hl.Grasp) -> bool:
    """Whether rigid fingers overlap the object and cannot give way."""
    return _jammed(arrays(grasp))


# ---------------------------------------------------------------- limits without a hand
def saturation(contacts: int, jacobian: np.ndarray, limits: np.ndarray) -> hl.TorqueSaturation:
    """The effect for contacts of fingers whose joints have this Jacobian (3n, nv) and these torque limits (nv,)."""
    nv = len(limits)
    joints = Joints(("",) * nv, jacobian, np.zeros(nv), limits, np.eye(nv), lambda: np.zeros((len(jacobian), nv, nv)))
    return hl.TorqueSaturation().for_grasp("", contacts, joints, ())
