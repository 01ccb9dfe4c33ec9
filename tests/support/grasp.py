"""Doors into a grasp: its arrays, its assembled problems, and the certifier's word on forces and a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp import arguments as _arguments
from handlcp.grasp.achieved import Bracket
from handlcp.grasp.assemble import assemble_contact
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import judge
from handlcp.grasp.changed import changed
from handlcp.grasp.diagnosis import Within, describe_motion, diagnose
from handlcp.grasp.force_error import force_error
from handlcp.grasp.kernels import nearest_in_polygon
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import as_section
from handlcp.grasp.required import holds, required_friction, required_preload, smallest, with_friction, with_preload
from handlcp.grasp.soft_form import assembled
from handlcp.grasp.soft_modes import soft_modes

__all__ = [
    "Bracket",
    "Within",
    "anew",
    "arrays",
    "at_centre",
    "candidate",
    "changed",
    "claimed_force_error",
    "contact_problem",
    "describe_motion",
    "diagnose",
    "diagnosed",
    "holds_with",
    "judge_of",
    "judged",
    "limit_surface",
    "load_about",
    "nearest_in_polygon",
    "plain_problem",
    "required_friction",
    "required_preload",
    "residuals",
    "section",
    "section_of",
    "smallest",
    "soft_modes",
    "with_friction",
    "with_preload",
]


# ---------------------------------------------------------------- what a grasp is made of
def arrays(of: hl.Grasp | hl.GraspSolution) -> Any:
    """A grasp, or the grasp that a solution answers, as plain SI arrays in the coordinates of its friction laws.

    Read here: positions, frames, mu, flexibility, offset, spin, force, moment, wrench, plane, freedom, governed, rough,
    grasp_matrix, n, environment, natural.w, units.force, units.length, units.motion, units.centre.
    """
    return of.scene


def at_centre(grasp: hl.Grasp, motion: Any) -> np.ndarray:
    """(6,) the object's motion about the contacts' centre: that of a solution, or one (6,) about the reference."""
    u = np.asarray(getattr(motion, "object_displacement", motion), float)
    return np.append(u[:3] + np.cross(u[3:], arrays(grasp).units.centre - grasp.reference), u[3:])


def anew(grasp: hl.Grasp) -> Any:
    """The same grasp made anew from its numbers, so that nothing is kept from an earlier solve."""
    return grasp._placed()


def load_about(wrench: Any, normal: Any, lift: float) -> np.ndarray:
    """(6,) a load given in a plane with this normal that lies `lift` above the reference, about the reference."""
    return _arguments.wrench(wrench, normal, lift)


# ---------------------------------------------------------------- sections and assembled problems
def section(faces: Any, planar: bool = False) -> Any:
    """What the package makes of `faces`."""
    return as_section(faces, planar=planar)


def section_of(grasp: hl.Grasp, faces: Any) -> Any:
    """The same for this grasp: a planar one has its own."""
    return as_section(faces, planar=arrays(grasp).plane is not None)


def contact_problem(grasp: hl.Grasp, faces: Any = "cone", asked: Any = None) -> Any:
    """The problem with friction as a set, with the effects asked for in place of the grasp's own where given."""
    return assemble_contact(arrays(grasp), section_of(grasp, faces), grasp.effects if asked is None else tuple(asked))


def plain_problem(grasp: hl.Grasp, faces: Any) -> Any:
    """The problem as `grasp.problem` gives it, before anything is computed that can wait."""
    return assembled(arrays(grasp), section_of(grasp, faces), grasp.effects)


# ---------------------------------------------------------------- the certifier
def candidate(forces: Any, twist: Any, extra: Any = None, torsion: Any = None) -> Any:
    """Forces (n, 3) [N] and the motion (6,) about the contacts' centre as the certifier takes them.

    extra : unknowns of further effects by name. torsion : moments of soft contacts over their levers [N].
    """
    more = {} if torsion is None else {"torsion": np.asarray(torsion, float)}
    return Candidate(np.asarray(forces, float), np.asarray(twist, float), dict(extra or {}), **more)


def judge_of(grasp: hl.Grasp, effects: Any, section: Any, answer: Any) -> Any:
    """The certifier's verdict: `residuals`, and how the contacts move in `motion` (n, 3)."""
    return judge(arrays(grasp), effects, section, answer)


def residuals(grasp: hl.Grasp, faces: Any, answer: Any, *more: Any) -> hl.Residuals:
    """By how much a candidate misses each law of this grasp, and of more effects."""
    effects = (*grasp.problem(faces).effects, *more)
    return judge_of(grasp, effects, section_of(grasp, faces), answer).residuals


def judged(
    grasp: hl.Grasp, faces: Any, forces: Any, twist: Any, extra: Any = None, torsion: Any = None
) -> hl.Residuals:
    """The same of forces (n, 3) and a motion (6,) about the contacts' centre."""
    return residuals(grasp, faces, candidate(forces, twist, extra, torsion))


def claimed_force_error(grasp: hl.Grasp, solution: hl.GraspSolution) -> float:
    """The error of a solution's forces beside those on the exact cone, as `solve(accuracy=...)` estimates it."""
    return force_error(contact_problem(grasp, "cone"), solution)


# ---------------------------------------------------------------- words, and the search for what is required
def diagnosed(grasp: hl.Grasp, solution: hl.GraspSolution, **more: Any) -> str:
    """The sentence about a solution, from what the solution says itself."""
    free = solution.uniqueness
    return diagnose(
        solution.status,
        solution.names,
        arrays(grasp).positions,
        reference=grasp.reference,
        forces=solution.forces,
        states=solution.contact_state,
        offset=arrays(grasp).offset,
        escape=solution.certificate,
        loose=None if free is None else free.directions,
        forces_determined=free is None or free.forces_determined,
        **more,
    )


def holds_with(grasp: hl.Grasp, faces: Any, squeeze: float) -> bool:
    """Whether the grasp holds with every finger squeezed by so much more [m]."""
    return holds(with_preload(grasp, squeeze), section_of(grasp, faces))
