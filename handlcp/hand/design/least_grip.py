"""The grip of each finger with which no fingertip slips and the motors need least: a linear program.

    least t    with    |τ| ≤ t s,    r within friction    after the squeeze and under every load

r and τ are linear in the grip forces (`sticking.py`), and s says what counts as much as what: the torque limits, or one
newton metre for every joint. It knows neither slips nor motions of the hand. So it is where the search for the least
grip begins, not its answer.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.hand.design.sticking import Sticking

_DIRECTIONS = 16  # faces of a friction cone in a tangent plane
_BALL = 64  # faces of a soft finger's limit surface
_SMALL = 1e-6  # weight of the grip's sum and of its largest: among grips with the same torques the gentlest, evenly


def least_grip(states: Sequence[Sticking], section: Section, share: Array, pattern: Array) -> Array | None:
    """(k,) grip forces [N]; None: with no such grip all fingertips stick.

    states : under each load. share (nv,) : s [N·m]. pattern (k, p) : the grip is a combination ≥ 0 of these columns.
    """
    from scipy.optimize import linprog  # half a second of import that only this question should pay

    p = pattern.shape[1]
    unit = max(float(np.linalg.norm(s.scene.geometry.wrench[:3])) for s in states) or 1.0
    above, most = list[Array](), list[Array]()
    for by_grip, rest, state in _ends(states):
        at = by_grip @ pattern
        cone = _cone(state.scene, section)
        torque, held = state.levers @ at, state.levers @ rest + state.held
        above += [np.column_stack([-cone @ at * unit, np.zeros((len(cone), 2))])]
        none = np.zeros(len(share))
        above += [np.column_stack([way * torque * unit, none, -share]) for way in (1.0, -1.0)]
        most += [cone @ rest, -held, held]
    above.append(np.column_stack([pattern, -np.ones(len(pattern)), np.zeros(len(pattern))]))  # the largest of the grip
    most.append(np.zeros(len(pattern)))
    size = max(float(abs(b).max(initial=0.0)) for b in most) or 1.0
    cost = np.append(np.full(p + 1, _SMALL), 1.0)
    found = linprog(cost, np.vstack(above), np.concatenate(most), bounds=[(0.0, None)] * (p + 2), method="highs")
    if found.x is None or not found.x[:p].max(initial=0.0) * unit < 1e6 * size:
        return None
    return np.asarray(pattern @ found.x[:p] * unit)


def _ends(states: Sequence[Sticking]) -> list[tuple[Array, Array, Sticking]]:
    """(by_grip, rest, state) after the squeeze, and under every load."""
    return [(states[0].by_grip, states[0].unloaded, states[0]), *((s.by_grip, s.rest, s) for s in states)]


def _cone(scene: Scene, section: Section) -> Array:
    """Rows A with A r ≥ 0 for forces (c,) within friction, on faces inside the cones."""
    rows = list[Array]()
    for own, radius in zip(scene.kind.contact_components, scene.limits(section), strict=True):
        if own[0] < 0:
            continue
        ways, inside = _faces(int((own >= 0).sum()) - 1)
        for way in ways:
            row = np.zeros(scene.components)
            row[own[0]] = radius * inside
            row[own[1 : 1 + len(way)]] = -way
            rows.append(row)
    return np.array(rows).reshape(-1, scene.components)


def _faces(tangents: int) -> tuple[Array, float]:
    """Unit normals of faces in so many tangential directions, and how far inside the unit ball they lie."""
    if tangents == 0:
        return np.zeros((1, 0)), 1.0
    if tangents == 1:
        return np.array([[1.0], [-1.0]]), 1.0
    if tangents == 2:
        angle = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        return np.column_stack([np.cos(angle), np.sin(angle)]), float(np.cos(np.pi / _DIRECTIONS))
    k = np.arange(_BALL) + 0.5
    height, turn = 1.0 - 2.0 * k / _BALL, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - height**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height]), 0.95
