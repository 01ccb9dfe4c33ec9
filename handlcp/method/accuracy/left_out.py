"""The scene without one of its effects: what a simpler model would get wrong here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp import Effect, Grasp, GraspSolution
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.model import validate
from handlcp.grasp.parameter.friction import with_friction
from handlcp.hand import HandGrasp
from handlcp.lcp import Auto
from handlcp.method.accuracy.measure import Errors
from handlcp.method.accuracy.result import CERTIFIED, LeftOut

UNDETERMINED = "forces not determined"
_SEARCH = 0.5  # seconds of search in scenes that may have no answer


def variants(grasp: Grasp) -> Iterator[tuple[str, str, Grasp]]:
    """(effect, what is put in its place, the grasp without it) for each effect that this scene has."""
    scene = grasp.scene
    yield from _stiffer(grasp)
    bare = _touching(grasp)
    if bare.offset.tolist() != grasp.offset.tolist():
        yield "preload and gaps", "fingers that just touch", bare
    if (scene.mu > 0).any():
        yield "friction", "smooth fingertips", type(grasp)(with_friction(grasp.spec, 0.0))
    effects = grasp.spec.effects
    for e in effects:
        if e.by_name or isinstance(e, FingerWeight):
            instead = "none" if e.by_name else "fingers without weight"
            yield e.title, instead, _with_effects(grasp, tuple(x for x in effects if x is not e))


def _touching(grasp: Grasp) -> Grasp:
    """The grasp without squeezes and gaps of its fingers; a command of the joints is a squeeze, too."""
    spec, k = grasp.spec, grasp.spec.of_fingers
    offset = np.concatenate([np.zeros((k, 3)), spec.offset[k:]])
    effects = tuple([e for e in spec.effects if not isinstance(e, JointOffset)])
    return type(grasp)(spec.replace(offset=read_only(offset), effects=effects))


def _stiffer(grasp: Grasp) -> Iterator[tuple[str, str, Grasp]]:
    """The grasp without parts of the fingers' flexibility E. Compliances asked for by name are effects of their own.

    E stays positive semidefinite when blocks of it are set to zero in pairs of rows and columns.
    """
    scene = grasp.scene
    E, n = grasp.flexibility, scene.n
    normal = np.arange(3 * n) % 3 == 2
    same_kind = normal[:, None] == normal
    same_finger = np.kron(np.eye(n, dtype=bool), np.ones((3, 3), bool))
    if E[~same_kind].any():
        uncoupled = _with(grasp, np.where(same_kind, E, 0))
        yield "normal–tangential coupling", "a push moves no fingertip sideways", uncoupled
    if E[~same_finger].any():
        yield "coupling between fingers", "fingers that share no joint", _with(grasp, np.where(same_finger, E, 0))
    if len(scene.rough) and E[~normal][:, ~normal].any():
        stiff = np.where(normal[:, None] & normal, E, 0)
        yield "tangential flexibility", "fingertips that give way along the normal only", _with(grasp, stiff)
    if isinstance(grasp, HandGrasp):
        joints = grasp.state.hand.stiffness.compliance(grasp.jacobian)  # J K⁻¹ Jᵀ
        fingers = 3 * (n - scene.environment)
        around = np.where(np.arange(3 * n)[:, None] < fingers, 0, E)  # of the environment's contacts
        pads = np.where(same_finger, E - joints - around, 0)
        pads = np.where(abs(pads) > 1e-12 * abs(E).max(initial=0.0), pads, 0)  # without rounding errors
        if pads.any():
            yield "fingertip pads", "joints that give way, hard fingertips", _with(grasp, joints + around)
        if joints.any():
            rest = "soft fingertips" if pads.any() else "rigid fingers"
            yield "joint compliance", f"stiff joints, {rest}", _with(_unsagged(grasp), pads + around)
    elif E.any():
        yield "finger flexibility", "rigid fingers", _with(grasp, np.zeros_like(E))


def compare(reference: GraspSolution, errors: Errors, effect: str, instead: str, without: Grasp) -> LeftOut:
    """Solve the grasp without the effect on the exact cone, and compare.

    The solve starts from the reference, so that it finds the nearest equilibrium should there be several.
    """
    solution = without.solve("cone", Auto(search_seconds=_SEARCH), throw=False, start=reference)
    if not solution.held:
        return LeftOut(effect, instead, solution.status.name.lower().replace("_", " "))
    determined = solution.uniqueness is None or solution.uniqueness.forces_determined
    known = reference.uniqueness is None or reference.uniqueness.forces_determined
    status = CERTIFIED if determined or not known else UNDETERMINED
    return LeftOut(effect, instead, status, **errors(solution.forces, solution.slip, without))


def _with(grasp: Grasp, flexibility: Array) -> Grasp:
    E = read_only(np.ascontiguousarray(flexibility, dtype=float))
    return type(grasp)(grasp.spec.replace(flexibility=E))


def _with_effects(grasp: Grasp, effects: tuple[Effect, ...]) -> Grasp:
    """The grasp with these effects, checked anew: some of them depend on the others."""
    return type(grasp)(grasp.spec.replace(effects=validate.effects(effects, grasp.spec)))


def _unsagged(grasp: HandGrasp) -> Grasp:
    """The grasp with joints that do not give way to the fingers' weight."""
    held = tuple(replace(e, sags=False) if isinstance(e, FingerWeight) else e for e in grasp.spec.effects)
    return _with_effects(grasp, held)
