"""What a solver's chain works on: friction as a set, with soft fingers balls or polyhedra in three tangents."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.assemble import GraspContact, GraspProblem, assemble, assemble_contact
from handlcp.grasp.assembled import Assembled, picked
from handlcp.grasp.catalogue import called_for
from handlcp.grasp.effects import Effect
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Cone, Pyramid, Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, layout
from handlcp.lcp.balls import BallProblem
from handlcp.lcp.problem import LCP
from handlcp.lcp.scaling import Units

__all__ = ["GraspBalls", "assembled", "chain_form"]


class GraspBalls(Assembled, BallProblem):
    """A `BallProblem` that knows what its unknowns mean."""


def chain_form(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspContact | GraspBalls:
    """The form of the problem that `Auto` solves."""
    return _balls(scene, section, asked) if scene.soft else assemble_contact(scene, section, asked)


def assembled(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspProblem | GraspContact | GraspBalls:
    """The problem as `Grasp.problem` gives it: friction with a multiplier a face, or as a set on the exact cone."""
    if not isinstance(section, Cone):
        return assemble(scene, called_for(scene, section, asked, multipliers=True))
    return chain_form(scene, section, asked)


def _balls(scene: Scene, section: Section, asked: tuple[Effect, ...]) -> GraspBalls:
    effects = called_for(scene, section, asked, multipliers=False)
    system = System(layout(u for e in effects for u in e.unknowns(scene)))
    for e in effects:
        e.stamp(scene, system)
    at, hard, soft = system.at, len(scene.rough), len(scene.soft)
    balls = np.full((hard + soft, 4), -1, dtype=np.int64)
    balls[:, 0] = at["r_N"].start + np.concatenate([scene.rough_rows, scene.soft_rows])
    points, patches = np.split(system.tangential + np.arange(2 * hard + 3 * soft), [2 * hard])
    balls[:hard, 1:3], balls[hard:, 1:] = points.reshape(-1, 2), patches.reshape(-1, 3)
    free, surface = np.arange(len(system.q)) >= at["u"].start, limit_surface(section)
    limits = np.append(section.limit(scene.mu)[list(scene.rough)], surface.limit(scene.mu)[list(scene.soft)])
    flat = np.vstack([section.normals, np.zeros(section.normals.shape[1])]).T
    faces = None if surface.exact else (read_only(np.ascontiguousarray(flat)), surface.outward)
    return GraspBalls(
        system.M, system.q, free, balls, limits, faces, Units(*system.sizes(scene)),
        lambda m: _pyramid(scene, asked, system, _with_faces(section, m)), section.faces,
    ).of(scene, system, effects)  # fmt: skip


def _pyramid(
    scene: Scene, asked: tuple[Effect, ...], balls: System, section: Section
) -> tuple[LCP, Callable[[Array], Array]]:
    """The same scene as a plain LCP on polyhedra, and how its z becomes an x of `balls`."""
    p = assemble(scene, called_for(scene, section, asked, multipliers=True))
    return p, picked(p.every, p._system, balls)


def _with_faces(section: Section, faces: int) -> Section:
    """This very section where it has so many faces, an inscribed pyramid elsewhere."""
    return section if section.faces == faces else Pyramid(faces)
