"""Which effects a scene calls for, and why: from its data, and from what was asked for by name."""

from __future__ import annotations

from handlcp.grasp.effects import (
    AnisotropicFriction,
    ContactCompliance,
    CoulombCone,
    CoulombPlanar,
    CoulombPyramid,
    Effect,
    FingerFlexibility,
    FingerForceBound,
    GeometricStiffness,
    KnownForce,
    ObjectBalance,
    PrescribedForce,
    SoftFingerCone,
    SoftFingerPyramid,
    SoftWrist,
    TorqueSaturation,
    TotalForceBound,
    UnilateralContact,
)
from handlcp.grasp.pyramid import Interval, Pyramid, Section
from handlcp.grasp.scene import Scene

__all__ = ["BY_NAME", "FROM_DATA", "absent", "asked_for", "called_for"]


def called_for(scene: Scene, section: Section, asked: tuple[Effect, ...], multipliers: bool) -> tuple[Effect, ...]:
    """The effects of this scene, in stamping order.

    multipliers : friction as a linear problem, with one multiplier a face; otherwise as a set that the solver projects
        on (always so for the exact cone).
    """
    effects: list[Effect] = [ObjectBalance(), UnilateralContact()]
    if scene.rough:
        if multipliers and isinstance(section, Interval):
            effects.append(CoulombPlanar())
        elif multipliers and isinstance(section, Pyramid):
            effects.append(CoulombPyramid(section))
        else:
            effects.append(CoulombCone(section))
    if scene.soft:
        effects.append(SoftFingerPyramid(section) if isinstance(section, Pyramid) and multipliers else SoftFingerCone())
    if scene.anisotropic:
        effects.append(AnisotropicFriction())
    if scene.flexible:
        effects.append(FingerFlexibility())
    return (*effects, *asked)


FROM_DATA: tuple[type[Effect], ...] = (
    ObjectBalance, UnilateralContact, CoulombPyramid, CoulombCone, CoulombPlanar, SoftFingerPyramid, SoftFingerCone,
    AnisotropicFriction, FingerFlexibility,
)  # fmt: skip
BY_NAME: tuple[type[Effect], ...] = (
    TotalForceBound, FingerForceBound, TorqueSaturation, PrescribedForce, KnownForce, ContactCompliance, SoftWrist,
    GeometricStiffness,
)  # fmt: skip


def asked_for(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those of a scene's effects that were asked for by name; its data call for the others, whatever the section."""
    return tuple(e for e in effects if not isinstance(e, FROM_DATA))


def absent(scene: Scene, present: tuple[Effect, ...]) -> tuple[tuple[type[Effect], str], ...]:
    """(effect, why it is off) for the effects this scene does without."""
    on = {type(e) for e in present}
    friction = "every contact with friction is soft" if scene.soft else "no contact has μ > 0"
    if CoulombPlanar in on:
        friction = "the scene is planar: one tangent, exact"
    elif CoulombPyramid in on:
        friction = "a pyramid was asked for"
    elif CoulombCone in on:
        friction = "the exact cone was asked for"
    soft = "no contact is a SoftFinger"
    if scene.soft:
        soft = "the exact cone was asked for" if SoftFingerCone in on else "a pyramid was asked for"
    reasons: dict[type[Effect], str] = {
        CoulombPyramid: friction,
        CoulombCone: friction,
        CoulombPlanar: friction if scene.plane is not None or not scene.rough else "the scene is not planar",
        SoftFingerPyramid: soft,
        SoftFingerCone: soft,
        AnisotropicFriction: "every contact holds alike in all directions",
        FingerFlexibility: "E is zero: rigid fingers",
    } | dict.fromkeys(BY_NAME, "not asked for")
    return tuple((kind, why) for kind, why in reasons.items() if kind not in on)
