"""`accuracy_cost`: what accuracy costs in one scene: methods, faces, tolerances and effects left out."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from handlcp.check import Array, check_call, check_integer, check_number, check_sequence, read_only
from handlcp.contact.friction.section import MOST_FACES
from handlcp.errors import InputError, UnknownName, Unsupported
from handlcp.grasp import Effect, GeometricStiffness, Grasp
from handlcp.grasp.derivatives.parameter.contact import with_friction
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model import validate
from handlcp.hand import HandGrasp
from handlcp.lcp import Auto
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.studies.accuracy.measure import Bench, forces_determined
from handlcp.studies.accuracy.methods import METHODS, Method, Setting, settings
from handlcp.studies.accuracy.result import CERTIFIED, NOT_RUN, OTHER, AccuracyCost, Conditions, LeftOut, Reference, Row
from handlcp.version import VERSION

# ----------------------------------------------------------------
# The scene without one of its effects: what a simpler model would get wrong here.

UNDETERMINED = "forces not determined"
_SEARCH = 0.5  # seconds of search in scenes that may have no answer


def variants(grasp: Grasp) -> Iterator[tuple[str, str, Grasp]]:
    """(effect, what is put in its place, the grasp without it) for each effect that this scene has."""
    spec, k, effects = grasp.spec, grasp.spec.of_hand, grasp.spec.effects
    yield from _stiffer(grasp)
    offset = read_only(np.concatenate([np.zeros((k, 3)), spec.offset[k:]]))
    others = tuple([e for e in effects if not isinstance(e, JointOffset)])  # a command of the joints is a squeeze, too
    bare = type(grasp)(spec.replace(offset=offset, effects=others))
    if bare.offset.tolist() != grasp.offset.tolist():
        yield "preload and gaps", "fingers that just touch", bare
    if (grasp.scene.mu > 0).any():
        yield "friction", "smooth fingertips", type(grasp)(with_friction(spec, 0.0))
    for e in effects:
        if e.by_name or isinstance(e, FingerWeight):
            instead = "none" if e.by_name else "fingers without weight"
            yield e.title, instead, _with_effects(grasp, tuple(x for x in effects if x is not e))


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
        joints = grasp.state.hand.stiffness.contact_compliance(grasp.jacobian)  # J K⁻¹ Jᵀ
        fingers = 3 * (n - scene.environment)
        around = np.where(np.arange(3 * n)[:, None] < fingers, 0, E)  # of the environment's contacts
        pads = np.where(same_finger, E - joints - around, 0)
        pads = np.where(abs(pads) > 1e-12 * abs(E).max(initial=0.0), pads, 0)  # without rounding errors
        if pads.any():
            yield "fingertip pads", "joints that give way, hard fingertips", _with(grasp, joints + around)
        if joints.any():
            rest = "soft fingertips" if pads.any() else "rigid fingers"
            effects = [replace(e, sags=False) if isinstance(e, FingerWeight) else e for e in grasp.spec.effects]
            stiff_hand = _with_effects(grasp, tuple(effects))
            yield "joint compliance", f"stiff joints, {rest}", _with(stiff_hand, pads + around)
    elif E.any():
        yield "finger flexibility", "rigid fingers", _with(grasp, np.zeros_like(E))


def compare(bench: Bench, effect: str, instead: str, without: Grasp) -> LeftOut:
    """Solve the grasp without the effect on the exact cone, and compare.

    The solve starts from the reference, so that it finds the nearest equilibrium should there be several.
    """
    reference = bench.reference
    solution = without.solve("cone", Auto(search_seconds=_SEARCH), throw=False, start=reference)
    if not solution.held:
        return LeftOut(effect, instead, solution.status.name.lower().replace("_", " "))
    known = forces_determined(solution) or not forces_determined(reference)
    status = CERTIFIED if known else UNDETERMINED
    return LeftOut(effect, instead, status, **bench.errors(solution.forces, solution.slip, without))


def _with(grasp: Grasp, flexibility: Array) -> Grasp:
    E = read_only(np.ascontiguousarray(flexibility, dtype=float))
    return type(grasp)(grasp.spec.replace(flexibility=E))


def _with_effects(grasp: Grasp, effects: tuple[Effect, ...]) -> Grasp:
    """The grasp with these effects, checked anew: some of them depend on the others."""
    return type(grasp)(grasp.spec.replace(effects=validate.effects(effects, grasp.spec)))


# ----------------------------------------------------------------

Progress = Callable[[int, int, str], None]  # settings done, all of them, what is next

_SHARE = 0.5  # of the time that its method has left: one setting takes no more
_FEWEST = 100  # steps: a run cut shorter, and shorter than twice the last one, is not worth its time


@check_call()
@compile_now()
def accuracy_cost(
    grasp: Grasp,
    *,
    methods: Iterable[str] | None = None,
    faces: Iterable[int] | None = None,
    tolerances: Iterable[float] | None = None,
    left_out: bool = True,
    repeats: int = 5,
    seconds: float = 60.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> AccuracyCost:
    """Time and error of this scene's methods and settings, and the error of leaving an effect out.

    methods : names among `METHODS`; None: all. faces : of pyramids; None: 3 … 128. tolerances : None: 1e-1 … 1e-12.
        Methods run with all faces at a tight tolerance, and with all tolerances at 8 and 16 faces; where both lists
        are given, with every pair. left_out : whether to solve the scene without each of its effects, too.
    repeats : timed runs of a setting; very short ones are repeated more often, long ones as often as time allows.
    seconds : for all timed runs. Compilation and effects left out come on top, the latter with half a second each at
        most where a search finds nothing. Settings that do not fit are rows, too: "not run: budget".
    seed : of all methods that draw. progress : called before each setting with (settings done, all, what is next).

    Errors are measured against `grasp.solve("cone")`, certified. Where that is one equilibrium of several, rows that
    reach another are marked, not scored. Raises NoSolutionFound where the scene has no answer; InputError.
    """
    chosen, sides, tols = _check_arguments(grasp, methods, faces, tolerances)
    check_integer("repeats", repeats, 1, 10_000)
    seconds = check_number("seconds", seconds, above=0.0)
    check_integer("seed", seed, 0)
    if not isinstance(left_out, bool):
        raise InputError("left_out", "True or False", repr(left_out))
    if progress is not None and not callable(progress):
        raise InputError("progress", "a function of (done, total, text), or None", repr(progress))
    date = datetime.now().astimezone().isoformat(timespec="seconds")
    exact = grasp.solve("cone")
    bench = Bench(grasp, exact, repeats, seed)
    plan = settings(chosen, sides, tols, grasp.scene.plane is None and len(grasp.scene.rough) > 0)
    simpler = list(variants(grasp)) if left_out else []
    effects: list[LeftOut] = []
    rows: list[Row] = []

    def say(text: str) -> None:
        if progress is not None:
            progress(len(effects) + len(rows), len(simpler) + sum(map(len, plan.values())), text)

    say("compiling")
    for own in plan.values():
        bench.run(own[0], 0.0, 1)
    for effect, instead, without in simpler:
        say(f"without {effect}")
        effects.append(compare(bench, effect, instead, without))
    begun = time.perf_counter()
    for k, (method, own) in enumerate(plan.items()):
        left = max(begun + seconds - time.perf_counter(), 0.0)
        for row in _run(bench, method, own, left / (len(plan) - k), say):
            rows.append(row)  # one by one: `say` counts them
    took = time.perf_counter() - begun
    machine, processors = f"{platform.system()} {platform.machine()}", os.cpu_count() or 1
    where = Conditions(VERSION, platform.python_version(), machine, processors, date, repeats, seed, seconds, took)
    forces, slip = (tuple(map(tuple, a.tolist())) for a in (exact.forces, exact.slip))
    torques = None if bench.torques is None else tuple(bench.torques.tolist())
    known, residuals, notes = forces_determined(exact), exact.residuals, list[str]()
    if not known:
        notes.append("the scene does not determine its forces: errors are distances from the smallest that will do")
    if any(r.status == OTHER for r in rows):
        notes.append("the scene has more than one equilibrium, and some settings reach another than the reference")
    reference = Reference(exact.names, forces, slip, torques, residuals.motion_scale, residuals.worst, known)
    return AccuracyCost(reference, tuple(rows), tuple(effects), where, tuple(notes))


def _run(
    bench: Bench, method: Method, own: Sequence[Setting], seconds: float, say: Callable[[str], None]
) -> Iterator[Row]:
    """One method's rows, within so many seconds.

    The steps of a run are limited so that it takes at most `_SHARE` of the time left (a whole `grasp.solve()` cannot be
    limited). A run that would get too few steps is not started. The settings to come share the time left evenly.
    """
    end, fewest = time.perf_counter() + seconds, 0
    step, known = 0.0, 1.0  # seconds a step, measured with so many unknowns
    for k, s in enumerate(own):
        say(f"{method.name}, {s.faces} faces" if s.faces else method.name)
        allowed = _SHARE * (end - time.perf_counter())
        n = bench.unknowns(s) if allowed > 0.0 else 0
        most = method.most
        if step > 0.0 and allowed > 0.0:
            most = int(min(most, allowed / (step * (n / known) ** method.growth)))
        if allowed <= 0.0 or most < fewest:
            yield Row(method.name, s.section, s.faces, s.tolerance, NOT_RUN)
            continue
        row = bench.run(s, (end - time.perf_counter()) / (len(own) - k), most)
        if row.seconds is not None and row.iterations:
            step, known = row.seconds / row.iterations, float(n)
            fewest = min(_FEWEST, method.most, 2 * row.iterations)
        yield row


def _check_arguments(
    grasp: Any, methods: Any, faces: Any, tolerances: Any
) -> tuple[tuple[Method, ...], Sequence[int] | None, Sequence[float] | None]:
    """(methods, faces, tolerances), the latter two None where they were not asked for."""
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp, or a HandGrasp", type(grasp).__name__)
    names = tuple(METHODS) if methods is None else _several("methods", methods, "method names")
    if unknown := [str(n) for n in names if not isinstance(n, str) or n not in METHODS]:
        raise UnknownName("methods", "a method", unknown, METHODS)
    if faces is not None:
        given = _several("faces", faces, "numbers of faces")
        faces = sorted({check_integer("faces", m, 3, MOST_FACES) for m in given})
    if tolerances is not None:
        given = _several("tolerances", tolerances, "tolerances")
        tolerances = sorted({check_number("tolerances", t, above=0.0) for t in given}, reverse=True)
    if grasp.scene.soft:
        raise Unsupported("accuracy_cost compares methods that know no soft fingers")
    if any(isinstance(e, GeometricStiffness) for e in grasp.effects):
        raise InputError("grasp", "one with one flexibility for all forces", "GeometricStiffness among its effects")
    return tuple(m for m in METHODS.values() if m.name in names), faces, tolerances


def _several(argument: str, value: Any, what: str) -> tuple[Any, ...]:
    expected = f"a list of {what}, not empty"
    if not (found := check_sequence(argument, value, expected)):
        raise InputError(argument, expected, repr(value))
    return found
