"""Doors into a grasp: its arrays, its assembled problems, and the certifier's word on forces and a motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.contact.friction import as_section, limit_set
from handlcp.grasp.analysis import required_value as _required
from handlcp.grasp.analysis.solve_to_accuracy import force_error
from handlcp.grasp.assembly.problem import GraspContactProblem, SolverCandidate, asked_effects_with_rows, assemble
from handlcp.grasp.derivatives.parameter.contact import with_friction as _with_friction
from handlcp.grasp.model import validate as _validate
from handlcp.grasp.solution.diagnosis import DiagnosisText
from handlcp.grasp.solve import compiled_answer as _first
from handlcp.grasp.solve.solve_spec import fixed_point_residual, is_force_dependent
from handlcp.grasp.verify.certifier import certify_candidate
from handlcp.lcp.kernels.projection import project_on_set as _nearest


# ---------------------------------------------------------------- what a grasp is made of
class _Arrays:
    """A scene with its offset contact by contact, and that of the turns about the normals apart."""

    def __init__(self, scene):
        self._scene = scene

    def __getattr__(self, name):
        return getattr(self._scene, name)

    @property
    def offset(self):
        return self._scene.offset[: 3 * self._scene.n].reshape(-1, 3)

    @property
    def spin(self):
        return self._scene.offset[3 * self._scene.n :]

    @property
    def wrench(self):
        return self._scene.geometry.wrench

    @property
    def grasp_matrix(self):
        return self._scene.geometry.grasp_matrix

    def __eq__(self, other):
        return self._scene is getattr(other, "_scene", other)

    __hash__ = None


def arrays(of):
    """A grasp, or the grasp that a solution answers, as plain SI arrays in the coordinates of its friction laws.

    Read here: positions, frames, mu, flexibility, offset, spin, force, moment, wrench, plane, freedom, governed, rough,
    grasp_matrix, n, environment, natural.w, units.force_unit, units.length_unit, units.motion_unit, units.centre.
    """
    if len(_VIEWS) > 1000:
        _VIEWS.clear()
    return _VIEWS.setdefault(id(of.scene), _Arrays(of.scene))


_VIEWS: dict[int, _Arrays] = {}


def at_centre(grasp, motion):
    """(6,) the object's motion about the contacts' centre: that of a solution, or one (6,) about the reference."""
    u = np.asarray(getattr(motion, "object_displacement", motion), float)
    return np.append(u[:3] + np.cross(u[3:], arrays(grasp).units.centre - grasp.reference), u[3:])


def changed(grasp, **fields):
    """The grasp with other numbers in its specification, not checked."""
    return type(grasp)(grasp.spec.replace(**fields))


def anew(grasp):
    """The same grasp made anew from its numbers, so that nothing is kept from an earlier solve."""
    return changed(grasp)


def load_about(wrench, normal, lift):
    """(6,) a load given in a plane with this normal that lies `lift` above the reference, about the reference."""
    return _validate.wrench(wrench, normal, lift)


# ---------------------------------------------------------------- sections and assembled problems
def section(faces, planar=False):
    """What the package makes of `faces`."""
    return as_section(faces, planar=planar)


def section_of(grasp, faces):
    """The same for this grasp: a planar one has its own."""
    return as_section(faces, planar=arrays(grasp).plane is not None)


def contact_problem(grasp, faces="cone", asked=None):
    """The problem with friction as a set, with the effects asked for in place of the grasp's own where given."""
    return GraspContactProblem(
        grasp.scene, section_of(grasp, faces), asked_effects_with_rows(tuple(grasp.effects if asked is None else asked))
    )


def plain_problem(grasp, faces):
    """The problem as `grasp.problem` gives it, before anything is computed that can wait."""
    return assemble(grasp.scene, section_of(grasp, faces), asked_effects_with_rows(grasp.effects))


def limit_surface(pyramid):
    """The polyhedron of soft fingers: normals (3, f), outward (f, 3) the same in rows, vertices (3, p), share."""
    own = limit_set(pyramid, 3)
    return SimpleNamespace(normals=own.normals, outward=own.normals.T.copy(), vertices=own.vertices, share=own.share)


def nearest_in_polygon(x, y, distance, faces):
    """The point of a polygon with faces at this distance that is nearest to (x, y)."""
    P = np.zeros(3)
    tangents = 1 if faces == 2 else 2
    _nearest(np.array([x, y, 0.0]), tangents, distance, 0.0, faces, np.zeros((0, 3)), P, np.empty((3, 4)))
    return P[0], P[1]


def packed(grasps, faces):
    """Grasps of one kind as rows for compiled code: each written by itself, and all at once."""
    scenes, cut = [g.scene for g in grasps], section_of(grasps[0], faces)
    factor = _first.factor_to_eliminate(scenes[0])
    kind = _first.get_compiled_kind(scenes[0], cut, factor)
    rows = np.empty((len(scenes), kind.width))
    for scene, row in zip(scenes, rows, strict=True):
        _first.write_row(scene, cut, _first.factor_to_eliminate(scene), row)
    return rows, _first.scene_rows(scenes, kind, cut)


# ---------------------------------------------------------------- the certifier
def candidate(forces, twist, extra=None, torsion=None):
    """Forces (n, 3) [N] and the motion (6,) about the contacts' centre as the certifier takes them.

    extra : unknowns of further effects by name. torsion : moments of soft contacts over their levers [N].
    """
    moments = np.zeros(0) if torsion is None else np.asarray(torsion, float)
    components = np.append(np.asarray(forces, float).ravel(), moments)
    return SolverCandidate(components, np.asarray(twist, float), dict(extra or {}), len(moments))


def judge_of(grasp, effects, section, answer):
    """The certifier's verdict: `residuals`, and how the contacts move in `motion`."""
    return certify_candidate(grasp.scene, effects, section, answer)


def residuals(grasp, faces, answer, *more):
    """By how much a candidate misses each law of this grasp, and of more effects."""
    effects = (*grasp.problem(faces).effects, *more)
    found = judge_of(grasp, effects, section_of(grasp, faces), answer).residuals
    if is_force_dependent(grasp.spec):
        miss = fixed_point_residual(grasp.spec, grasp.scene, answer.forces, found.motion_scale)
        return replace(found, effects=max(found.effects, np.inf if isinstance(miss, str) else miss))
    return found


def judged(grasp, faces, forces, twist, extra=None, torsion=None):
    """The same of forces (n, 3) and a motion (6,) about the contacts' centre."""
    return residuals(grasp, faces, candidate(forces, twist, extra, torsion))


def claimed_force_error(grasp, solution):
    """The error of a solution's forces beside those on the exact cone, as `solve(accuracy=...)` estimates it."""
    return force_error(contact_problem(grasp, "cone"), solution)


# ---------------------------------------------------------------- words, and the search for what is required
def describe_motion(twist, positions, reference, names, slide, turn):
    """A twist (6,) about the reference in words, of a grasp with contacts of these names at these places."""
    return DiagnosisText(names, positions, reference).motion(twist, slide, turn)


def diagnose(
    status, names, positions, *, reference, forces = None, states = (),
    offset = None, loose = (), forces_determined = True, required_preload = None,
    **more,
):  # fmt: skip
    """The sentence about a solution with these parts, of a grasp that is not built."""
    n = len(names)
    given = {f.name: None for f in fields(hl.GraspSolution)} | {
        "advise": lambda: required_preload,
        "status": status, "names": names, "contact_state": states, "cause": "", "reference": reference,
        "forces": np.ones((n, 3)) if forces is None else forces,
        "uniqueness": hl.Uniqueness(len(loose), np.reshape(loose, (-1, 6)), forces_determined),
        "scene": SimpleNamespace(
            n=n, positions=positions, environment=0, offset=np.ravel(np.zeros((n, 3)) if offset is None else offset)
        ),
    }  # fmt: skip
    return hl.GraspSolution(**(given | more)).diagnosis


def diagnosed(grasp, solution, **more):
    """The sentence about a solution, from what the solution says itself."""
    return replace(solution, **more).diagnosis


def holds_with(grasp, faces, squeeze):
    """Whether the grasp holds with every finger squeezed by so much more [m]."""
    return _required.is_held(grasp.spec.with_squeeze(squeeze), section_of(grasp, faces))


def with_preload(grasp, extra):
    """The grasp with every finger squeezed by so much more [m]."""
    return type(grasp)(grasp.spec.with_squeeze(extra))


def with_friction(grasp, mu):
    """The grasp with this coefficient at all contacts that have friction."""
    return type(grasp)(_with_friction(grasp.spec, mu))


Check = Callable[[Any], bool]


def required_preload(grasp, faces=8, tolerance=1e-3, limit=None, check=None):
    """As `grasp.required_preload`. limit : largest squeeze tried. check : in place of a solve, of a grasp."""
    return _required_value(_required.required_preload, grasp, faces, tolerance, limit, check)


def required_friction(grasp, faces=8, tolerance=1e-3, limit=None, check=None):
    """As `grasp.required_friction`; likewise."""
    return _required_value(_required.required_friction, grasp, faces, tolerance, limit, check)


def _required_value(find, grasp, faces, tolerance, limit, check):
    tests = () if check is None else [lambda spec, section: check(type(grasp)(spec))] * 2
    return find(grasp.spec, section_of(grasp, faces), tolerance, limit, *tests)
