"""What postures and lengths change in the laws of a grasp: central differences of its laws, not of its answer.

    δv ≈ [v(p + h) - v(p - h)] / 2h,    forces, motion and contact states staying as they are

The grasp is made again with each parameter a little larger and smaller, as it was asked for: contacts on an object are
detected anew, a squeeze is commanded anew. What is differenced is smooth and costs no solve; with `STEPS` the error is
about 1e-9 of the largest change. Geometric stiffness changes with the contacts in no closed form that is known here, so
that beside it moved and turned contacts are differenced, too.

A fingertip that just touches has two sides. Deeper, it counts as squeezed: its joints take it sideways along the
surface while they take it deeper. A gap has no such part. How far a fingertip is inside is therefore kept in these
differences, and what its own change does is added, on the side where it grows (`Deeper`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.assembly.build import build
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.model.grasp_matrix import wrench_map
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.by.vary import STEPS, moved
from handlcp.grasp.sensitivity.change import Change, Deeper, no_change
from handlcp.grasp.sensitivity.kinks import Kink

_OF = "posture", "lengths"  # made again as they were asked for
_DEPTH = 1e-6  # [m]: what is differenced is linear in the depth
_NOTHING = 1e-6  # of a depth: a sideways motion that is rounding


def by_posture(answer: Answer) -> Change:
    """Of the joint positions (nv,) [1/rad, 1/m]."""
    mechanism = answer.spec.mechanism
    if mechanism is None:
        return no_change(answer, 0)
    return _made_again(answer, "posture", len(mechanism.names))


def by_lengths(answer: Answer) -> Change:
    """Of the lengths of links (m, 3) [1/m], see `Mechanism.lengths`."""
    mechanism = answer.spec.mechanism
    if mechanism is None:
        return no_change(answer, 0)
    return _made_again(answer, "lengths", 3 * len(mechanism.lengths))


def by_moved_positions(answer: Answer) -> Change:
    """Of the contact points (n, 3), world axes [1/m]."""
    spec = answer.spec
    return _differences(answer, 3 * spec.n, STEPS["positions"], lambda k, h: moved(spec, "positions", k, h))


def by_moved_normals(answer: Answer) -> Change:
    """Of turns (n, 3) of the contact axes about themselves [1/rad]."""
    spec = answer.spec
    return _differences(answer, 3 * spec.n, STEPS["normals"], lambda k, h: moved(spec, "normals", k, h))


def by_depth(answer: Answer) -> Deeper | None:
    """Of fingertips that count as inside the object, or just touch it and may be inside soon [1/m]; only those that
    are squeezed sideways by that. rates : (t, 0). None: there are none.
    """
    spec, mechanism = answer.spec, answer.spec.mechanism
    found = None if mechanism is None else mechanism.inside(spec)
    if mechanism is None or found is None:
        return None
    made, (inside, touches) = mechanism.varied, found
    some = np.flatnonzero(touches | (inside > 0.0))

    def deeper(j: int, h: float) -> GraspSpec:
        more = inside.copy()
        more[some[j]] += h
        one: GraspSpec = made(spec, "posture", 0, 0.0, more)
        return one

    change = _differences(answer, len(some), _DEPTH, deeper)
    sideways = abs(change.motion).max(axis=0, initial=0.0) > _NOTHING
    none = np.zeros((int(sideways.sum()), 0))
    return Deeper(some[sideways], none, change.some(sideways)) if sideways.any() else None


def touching_kinks(answer: Answer) -> tuple[Kink, ...]:
    """Fingertips that just touch, where that gives derivatives by posture and lengths two sides."""
    deeper, mechanism = by_depth(answer), answer.spec.mechanism
    found = None if mechanism is None else mechanism.inside(answer.spec)
    if deeper is None or found is None:
        return ()
    some = [int(i) for i in deeper.contacts if found[1][i]]
    return tuple([Kink(answer.spec.names[i], "just touches where it was detected", i, _OF) for i in some])


def _made_again(answer: Answer, what: str, count: int) -> Change:
    """By the entries of what a mechanism can vary."""
    spec, mechanism, h = answer.spec, answer.spec.mechanism, STEPS[what]
    assert mechanism is not None
    found, made, deeper = mechanism.inside(spec), mechanism.varied, by_depth(answer)
    if found is None or deeper is None:
        return _differences(answer, count, h, lambda k, h: made(spec, what, k, h, None if found is None else found[0]))
    gaps: dict[tuple[int, bool], Array] = {}

    def kept(k: int, step: float) -> GraspSpec:
        one: GraspSpec = made(spec, what, k, step, found[0])
        assert one.mechanism is not None  # a hand's
        gaps[k, step > 0.0] = one.mechanism.gaps()[deeper.contacts]
        return one

    change = _differences(answer, count, h, kept)
    none = np.full(len(deeper.contacts), np.nan)
    rates = [(gaps.get((k, False), none) - gaps.get((k, True), none)) / (2.0 * h) for k in range(count)]
    every = replace(change, deeper=deeper.by(np.column_stack([np.zeros((len(none), 0)), *rates])))
    return every.bent_at(found[1][deeper.contacts])


def _differences(answer: Answer, count: int, h: float, made: Callable[[int, float], GraspSpec]) -> Change:
    """Of the laws of grasps made(k, ±h)."""
    change = no_change(answer, count)
    for k in range(count):
        try:
            ahead, behind = _laws(answer, made(k, h)), _laws(answer, made(k, -h))
        except InputError:  # no such grasp, as where a link leaves the plane of a planar one
            change.motion[:, k] = np.nan
            continue
        for column, a, b in zip(
            (change.motion, change.balance, change.friction, change.torque), ahead, behind, strict=True
        ):
            column[:, k] = (a - b) / (2.0 * h)
    return change


def _laws(answer: Answer, spec: GraspSpec) -> tuple[Array, Array, Array, Array]:
    """(v, b, μ, τ) of the answer's forces and motion in another grasp: motions (c,) in the laws' coordinates, the
    wrench (6,) that is left over about the answer's reference, the sections' coefficients (n,), torques (nv,).
    """
    effects = []
    for e in spec.effects:
        made = e.under(spec, answer.forces, spec.effects) if e.depends_on_forces else e
        if isinstance(made, str):
            raise Unsupported(made)
        effects.append(made)
    spec = spec.replace(effects=tuple(effects))
    scene, r = build(spec), answer.lawful
    G = wrench_map(scene.positions, answer.spec.reference, scene.frames, scene.given.spin)
    v = G.T @ answer.twist + scene.flexibility @ r + scene.offset
    for e in spec.effects:
        if (more := e.opening(scene, answer.extra)) is not None:
            v = v + more
    b = G @ r
    b[:3] += scene.force
    b[3:] += scene.moment - np.cross(answer.spec.reference, scene.force)
    mechanism = spec.mechanism
    assert mechanism is not None  # only hands have postures and lengths
    others = tuple([e for e in spec.effects if not isinstance(e, TorqueSaturation)])
    torque = mechanism.joints(scene, others, answer.forces, answer.torsion, answer.extra).torque
    return v, b, scene.limits(answer.section), torque
