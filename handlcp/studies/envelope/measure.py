"""How much a grasp holds in each direction: limits along many directions, more of them where the cause changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Ints, check_call, check_integer
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.grasp import Grasp
from handlcp.grasp.model.request import check_loads
from handlcp.grasp.path.follow import geometry_of
from handlcp.progress import Progress
from handlcp.studies.envelope.direction import BindingCauses, DirectionGrid, DirectionRequest, read_directions
from handlcp.studies.envelope.question import (
    FIXED_GEOMETRY,
    FOLLOWED_GEOMETRY,
    FORCE,
    WRENCH,
    DirectionalLoad,
    EnvelopeQuestion,
    read_load,
)
from handlcp.studies.envelope.result import Envelope

_MAX_ADDED_SHARE = 2.0  # directions that are added at most, for each one that was asked for
_REFINEMENT_ROUNDS = 2
_MAX_FOLLOWED_DIRECTIONS = 100  # directions: followed ones of these take seconds


@check_call()
def envelope(
    grasp: Grasp,
    directions: Any = 362,
    *,
    of: str = FORCE,
    at: Any = None,
    geometry: str | None = None,
    faces: int | str | Pyramid = "cone",
    adaptive: int = _REFINEMENT_ROUNDS,
    motion: float | None = None,
    turn: float | None = None,
    accuracy: float | None = None,
    max_slip: Any = 1e-3,
    progress: Progress = None,
) -> Envelope:
    """How much the grasp holds in each direction, and what gives out first: `grasp.load_limit` along all of them.

    directions : an integer: at least so many all around, spread evenly, ±x, ±y and ±z among them. A plane "xy", "yz",
        "xz" or its normal (3,), one every 5°; with a number, such as ("xy", 180). (m, 3) vectors, of which the
        direction counts. (m, 6) wrenches about the grasp's reference, which the factors multiply. World axes.
    of : "force": a force on the object, factors in N. "torque": a torque, in N·m. "gravity": the largest mass of the
        object, in kg, where gravity points in this direction, seen from the hand; the mass that the object has is left
        out, and its fingers' weight turns with gravity if the grasp counts it (`finger_weight=`). Forces and torques
        come after the squeeze and the weight, in place of the grasp's other load. Contacts without a hand keep their
        wrench, of which nobody knows what is weight: everything comes beside it.
    at : (3,) where the force acts [m]; None: at the grasp's reference, the object's centre of mass unless said
        otherwise.
    geometry : "fixed": contact points and normals of this posture. "followed": hand and object move under the load, and
        contacts are detected anew; ten to thirty times slower. None: "followed" for a hand of round fingertips on an
        object whose surface is known in closed form, in up to a hundred directions, which takes seconds; else "fixed".
        The answer says which it was.
    faces : as in `Grasp.solve`. motion, turn : how far the object may move [m] and turn [rad] since the load began;
        None: any distance.
    adaptive : how many times the steps between directions with different causes are halved, with at most two
        directions more for each that was asked for; 0: not at all. (m, 3) and (m, 6) stay as they are.
    accuracy : estimated error of the forces that a step may have, as a share of the largest; None: 1e-3. What was
        reached is `.accuracy` of the answer, in each direction.
    max_slip : how far a contact that presses may slide since the load began [m]: a number, one for each contact or by
        name; inf: any distance.
    progress : None: a line on the terminal once it takes long. False: none. True: a line on stderr that stays. A
        function: called with (done, total).

    A direction in which nothing ever gives out has the factor infinity. Raises InputError; Unsupported for grasps that
    cannot be followed.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    if geometry not in (None, FIXED_GEOMETRY, FOLLOWED_GEOMETRY):
        raise InputError("geometry", '"fixed", "followed" or None', repr(geometry)[:80])
    rounds = check_integer("adaptive", adaptive, 0, 12)
    section = as_section(faces, planar=grasp.scene.kind.planar)
    asked, load = _read_question(grasp, directions, of, at)
    how = geometry or FIXED_GEOMETRY
    if geometry is None and len(asked.grid.points) <= _MAX_FOLLOWED_DIRECTIONS:
        moves = geometry_of(grasp.spec, None)
        how = FOLLOWED_GEOMETRY if moves.follows and moves.quick else FIXED_GEOMETRY
    question = EnvelopeQuestion.read(load, grasp.spec.names, section, how, motion, turn, accuracy, max_slip)
    grid, (factors, binds, off) = asked.grid, question.find_factors(asked.grid.points, asked.wrenches, progress)
    room = round(_MAX_ADDED_SHARE * len(grid.points))
    for _ in range(rounds if asked.is_refinable else 0):
        cut = _edges_between_causes(grid, binds)[:room]
        if not len(cut):
            break
        grid, before = grid.divide_edges(cut), len(grid.points)
        more, why, apart = question.find_factors(grid.points[before:], None, progress)
        factors, binds, off, room = np.append(factors, more), (*binds, *why), np.append(off, apart), room - len(cut)
    return Envelope(question, grid, asked.wrenches, factors, binds, asked.plane, off)


def _read_question(grasp: Grasp, directions: Any, of: Any, at: Any) -> tuple[DirectionRequest, DirectionalLoad]:
    """Directions and load; in a planar scene, the directions in its plane. Raises InputError."""
    asked, normal = read_directions(directions), grasp.spec.plane
    if of == WRENCH or asked.wrenches is not None:
        if asked.wrenches is None or of not in (FORCE, WRENCH):
            raise InputError("of", '"force", "torque" or "gravity" for directions, none for wrenches', repr(of)[:80])
        check_loads(grasp.spec, asked.wrenches, "directions")
        return asked, read_load(grasp, WRENCH, at)
    load = read_load(grasp, of, at)
    if normal is None:
        return asked, load
    if isinstance(directions, (int, np.integer)):
        if of == "torque":
            return read_directions([normal, -normal]), load
        asked = read_directions((normal, max(int(directions), 3)))
    points = asked.grid.points
    off = np.cross(points, normal) if of == "torque" else points @ normal
    if (abs(off) > 1e-9).any():
        expected = "directions about the normal of a planar scene" if of == "torque" else "directions in its plane"
        raise InputError("directions", expected, "a planar scene")
    return asked, load


def _edges_between_causes(grid: DirectionGrid, binds: Sequence[BindingCauses]) -> Ints:
    """(c, 2) edges whose ends have different causes, the longest first."""
    number = dict[frozenset[Any], int]()
    own = np.array([number.setdefault(frozenset(b), len(number)) for b in binds])
    edges = grid.edges
    between = edges[own[edges[:, 0]] != own[edges[:, 1]]]
    along = (grid.points[between[:, 0]] * grid.points[between[:, 1]]).sum(axis=1)
    return np.asarray(between[np.argsort(np.round(along, 9), kind="stable")])
