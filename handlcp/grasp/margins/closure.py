"""The classic tests of closure, by linear programs, each with what proves its answer.

Force closure: friction can balance any load, if the fingers only press hard enough. So it is where the wrenches W of
the contacts span all loads and internal forces lie strictly within friction: W has full rank, W a = 0 for some a > 0.
Form closure: no motion is possible, even without friction. The same with the wrenches of the normals alone.

Where there is none, a motion t proves it: Wᵀ t ≥ 0, so that no contact ever resists it. This is the test of first
order: bodies that fewer contacts lock by their curvature fail it. Springs, squeeze and torque limits play no part, nor
whether anything commands the fingers to press. Sources: Murray, Li & Sastry, A Mathematical Introduction to Robotic
Manipulation (1994), chapter 5; Nguyen, Int. J. Robotics Research 7 (1988), two fingers with friction; Lakshminarayana,
ASME paper 78-DET-32 (1978), four contacts in a plane and seven in space; Rimon & Burdick, IEEE Trans. Robotics and
Automation 14 (1998), the second order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.diagnosis import Sentences
from handlcp.grasp.answer.make_solution import certificate_of
from handlcp.grasp.friction import Cone, Pyramid, Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verify.holdable import escape_of, generators
from handlcp.record import Record
from handlcp.tolerances import CERTIFY, RANK

_FACES = (8, 32, 128, 512)  # of pyramids in the cone and around it, until one of them tells
_FACES_OF_SOFT = (8, 24, 64)
_INSIDE = 1e-6  # share of the mean force along an edge: what is less is not strictly within friction


@dataclass(frozen=True, slots=True, eq=False)
class Closure(Record):
    """One test and its proof.

    kind : "force" or "form". closed : whether there is closure; None: so near to the edge that rounding decides.
    forces : (n, 3) contact axes, for a sum of normal forces of 1 N: internal forces strictly within friction (of form
    closure: normal forces, all > 0) that balance one another; None where there is no closure.
    motion : (6,) small motion about the grasp's reference that no contact resists, for one metre of travel [m, rad];
    None where there is closure. sentence : the answer in words.
    """

    entries = ("closed", "sentence", "forces_N (n, 3)", "motion (6,)")

    kind: str
    closed: bool | None
    forces: Array | None
    motion: Array | None
    sentence: str


def force_closure(spec: GraspSpec, scene: Scene, section: Section) -> Closure:
    """With the friction of a scene. The cone has it where a pyramid within has it, and lacks it where one around it
    does; contacts whose force is prescribed take no part, those of the environment do.
    """
    if not isinstance(section, Cone) or not scene.frictional:
        return _told(spec, scene, "force", *_test(*generators(scene, section)))
    for faces in _FACES_OF_SOFT if scene.soft else _FACES:
        inner = _test(*generators(scene, Pyramid(faces)))
        if inner[0] is not None:
            return _told(spec, scene, "force", *inner)
        outer = _test(*generators(scene, Pyramid(faces, inscribed=False)))
        if outer[1] is not None:
            return _told(spec, scene, "force", None, outer[1])
    return _told(spec, scene, "force", None, None)


def form_closure(spec: GraspSpec, scene: Scene) -> Closure:
    """As if no contact had friction."""
    at = scene.kind.normal_index
    F = np.zeros((scene.components, len(at)))
    F[at, np.arange(len(at))] = 1.0
    return _told(spec, scene, "form", *_test(F, scene.natural.every[:, at]))


def _test(F: Array, W: Array) -> tuple[Array | None, Array | None]:
    """The proof of closure (c,), forces with a sum of normal forces of one; or that against it (dof,), a motion; or
    neither. F (c, g) forces along edges, W (dof, g) their wrenches.
    """
    dof = len(W)
    few = np.zeros((dof, max(dof - W.shape[1], 0)))  # so that there are as many directions as dimensions
    u, s, _ = np.linalg.svd(np.hstack([W, few]), full_matrices=False)
    rank = int((s > RANK * s.max(initial=0.0)).sum())
    if rank < dof:
        return None, _plain(u[:, rank:])
    from scipy.optimize import linprog  # half a second of import that few grasps should pay

    g, size = W.shape[1], np.sqrt((W * W).sum(axis=0))
    # The widest least share s: a = s + b, b ≥ 0, W a = 0, mean of a is one
    lp = linprog(
        np.append(np.zeros(g), -1.0), A_eq=np.vstack([np.column_stack([W, W.sum(axis=1)]), np.append(np.ones(g), g)]),
        b_eq=np.append(np.zeros(dof), g), bounds=[(0.0, None)] * g + [(0.0, None)], method="highs",
    )  # fmt: skip
    if lp.x is not None and lp.x[-1] > _INSIDE:
        a = (lp.x[:-1] + lp.x[-1]) / g
        a = a - np.linalg.pinv(W) @ (W @ a)  # balance to the last bit
        if a.min() > 0.0:
            return F @ (a / a.sum()), None
    lp = linprog(
        -(W / size).sum(axis=1), A_ub=-(W / size).T, b_ub=np.zeros(g), bounds=[(-1.0, 1.0)] * dof, method="highs",
    )  # fmt: skip
    if lp.x is not None:
        t = lp.x / (np.sqrt(lp.x @ lp.x) or 1.0)
        work = W.T @ t / size
        if work.max(initial=0.0) > _INSIDE and work.min(initial=0.0) > -CERTIFY:
            return None, t
    return None, None


def _plain(free: Array) -> Array:
    """(dof,) of all motions that columns (dof, k) span, the one nearest to a translation along an axis or to a turn
    about one: which basis a decomposition happens to find says nothing.
    """
    near = (free * free).sum(axis=1)  # how much of each axis they hold: its cosine, squared
    t = free @ free[int(np.argmax(near >= near.max() - _INSIDE))]
    return np.asarray(t / np.sqrt(t @ t))


def _told(spec: GraspSpec, scene: Scene, kind: str, forces: Array | None, motion: Array | None) -> Closure:
    """In SI, and in words."""
    if forces is not None:
        own = scene.physical(forces)[: 3 * scene.n].reshape(-1, 3)
        text = (
            "friction balances any load, if the fingers press hard enough (by geometry alone, whatever squeeze and "
            "motors)"
        )
        if kind == "form":
            text = "the contacts leave no motion, even without friction"
        return Closure(kind, True, read_only(own), None, text)
    if motion is None:
        text = "so near to the edge between yes and no that rounding decides"
        return Closure(kind, None, None, None, text)
    t = certificate_of(spec, scene, escape_of(scene, motion))
    say = Sentences(spec.names, scene.positions, spec.reference, scene.environment, who=spec.who)
    way = say.motion(t, "slides", "turns")
    less = "without friction " if kind == "form" else ""
    return Closure(kind, False, None, t, f"{less}the object {way}, and no contact resists")
