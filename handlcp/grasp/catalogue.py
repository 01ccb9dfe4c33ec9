"""Which effects a scene calls for, and why: from its data, and from what was asked for by name."""

from __future__ import annotations

from handlcp.grasp.effects import (
    CoulombPlanar,
    CoulombPyramid,
    Effect,
    FingerFlexibility,
    ObjectBalance,
    PrescribedForce,
    TotalForceBound,
    UnilateralContact,
)
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.scene import Scene

__all__ = ["absent", "called_for"]


def called_for(scene: Scene, pyramid: Pyramid, asked: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """The effects of this scene, in stamping order."""
    effects: list[Effect] = [ObjectBalance(), UnilateralContact()]
    if scene.rough:
        effects.append(CoulombPyramid(pyramid) if scene.plane is None else CoulombPlanar())
    if scene.flexibility.any():
        effects.append(FingerFlexibility())
    return (*effects, *asked)


def absent(scene: Scene, asked: set[type]) -> tuple[tuple[type[Effect], str], ...]:
    """(effect, why it is off) for the effects this scene does without."""
    off: list[tuple[type[Effect], str]] = []
    if not scene.rough:
        off.append((CoulombPyramid if scene.plane is None else CoulombPlanar, "no contact has μ > 0"))
    elif scene.plane is None:
        off.append((CoulombPlanar, "the scene is not planar"))
    else:
        off.append((CoulombPyramid, "the scene is planar: one tangent, exact"))
    if not scene.flexibility.any():
        off.append((FingerFlexibility, "E is zero: rigid fingers"))
    off += [(kind, "not asked for") for kind in (TotalForceBound, PrescribedForce) if kind not in asked]
    return tuple(off)
