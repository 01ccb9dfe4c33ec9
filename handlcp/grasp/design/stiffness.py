"""How stiff must the joints be, so that the object moves no further than allowed while weight and load come?

One factor on the stiffness of all joints. Pads stay as they are, and no stiffness of the joints takes away what they
alone let the object move.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, number
from handlcp.errors import InputError
from handlcp.grasp.analysis.least import least
from handlcp.grasp.analysis.required import tolerance_of
from handlcp.grasp.answer.verdict import HELD
from handlcp.grasp.assembly.build import build
from handlcp.grasp.cause.judge import MOTION, OBJECT, Cause, limits_of, over
from handlcp.grasp.cause.wording import needs_more, said
from handlcp.grasp.design.least import ORDER, Changed, word
from handlcp.grasp.friction import Section
from handlcp.grasp.model.kind import cross_rows
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter import named
from handlcp.grasp.path.follow import Loading
from handlcp.grasp.tangent.solutions import without_slip
from handlcp.progress import told
from handlcp.record import Record
from handlcp.text_table import wrapped

_MOST = 256.0


@dataclass(frozen=True, slots=True)
class RequiredStiffness(Record):
    """The least stiffness of the joints with which the object moves no further than allowed.

    factor : on the stiffness of every joint (of the fingers where no joints are known), with which the grasp holds
        within its torque limits and the object moves no further; below 1 where softer joints will do. None: none found.
    fails : the largest factor tried below it with which it does not, None where every smaller one holds.
    motion : allowed [m]. moved : with this factor, from the end of the squeeze to the whole load [m]; where none was
        found, with the stiffest joints that still hold the object, NaN: none do.
    pads : what is left with rigid joints, where nothing slips [m].
    verdict : what `check()` says of the grasp with this factor. why : why `fails` is not enough, or why none was found.
    """

    entries = ("factor", "fails", "motion_m", "moved_m", "pads_m", "verdict", "why")

    factor: float | None
    fails: float | None
    motion: float
    moved: float
    pads: float
    verdict: str
    why: str

    @property
    def pads_share(self) -> float:
        """What the pads alone let the object move, as a share of what is allowed; above 1 no joints are enough."""
        return self.pads / self.motion

    def __str__(self) -> str:
        allowed, moved = words.lengths((self.motion, self.moved))
        if self.factor is None:
            return wrapped(f"no stiffness of the joints found that keeps the object within {allowed}: {self.why}", "  ")
        less = "" if self.fails is None else f"; with × {self.fails:.4g} {self.why}"
        called = "" if self.verdict == HELD else f"{self.verdict}, as check() says of this: "
        text = f"{called}joints × {self.factor:.4g} as stiff let the object move {moved} of {allowed} allowed{less}"
        return wrapped(f"{text}; the pads alone make {words.percent(self.pads_share)} of it", "  ")


@told("looking for the least stiffness")
def required_stiffness(spec: GraspSpec, section: Section, motion: Any, tolerance: Any) -> RequiredStiffness:
    """See `Grasp.required_stiffness`."""
    allowed, near = number("motion", motion, above=0.0), tolerance_of(tolerance)

    def made(factor: float) -> GraspSpec:
        if (found := named("stiffness").scaled(spec, factor)) is None:
            raise InputError("flexibility", "that of joints, whose stiffness can be changed", "one that is not theirs")
        return found

    changed, pads = Changed(made, section), _pads(spec)

    def enough(factor: float) -> bool:
        path = changed.path(factor)
        return path.held and not _over(path) and _moved(path) <= allowed

    def too_much(factor: float) -> bool:
        return changed.too_much(factor) or bool(_over(changed.path(factor)))

    found = least(enough, 1.0, _MOST, near, floor=1.0 / _MOST, too_much=too_much)
    if (value := found.value) is not None:
        moved, below = _moved(changed.path(value)), found.fails
        short = "" if below is None else _short(changed.path(below))
        return RequiredStiffness(value, below, allowed, moved, pads, word(made(value), section), short)
    held = {x: path for x, path in changed.paths.items() if path.held and not _over(path)}
    moved = _moved(held[max(held)]) if held else np.nan
    return RequiredStiffness(None, None, allowed, moved, pads, "", _why(changed, held, allowed, pads))


def _short(path: Loading) -> str:
    """Why a factor is not enough."""
    if not path.held:
        return "the object is lost"
    return _short_of_torque(path) or said([Cause(MOTION, OBJECT)])


def _why(changed: Changed, held: dict[float, Loading], allowed: float, pads: float) -> str:
    if pads > allowed:
        motion = f"{words.length(pads)}, {words.percent(pads / allowed)} of that"
        return f"the pads alone let it move {motion}; stiffer pads help, or more of them"
    if held:
        return f"with joints × {max(held):.4g} as stiff it still moves {words.length(_moved(held[max(held)]))}"
    lost = [path for path in changed.paths.values() if not path.held]
    if lost:
        return lost[-1].why
    return f"{_short_of_torque(next(reversed(changed.paths.values())))}, however stiff the joints are"


def _over(path: Loading) -> tuple[Cause, ...]:
    """The joints that need more than their torque limits at the end."""
    spec = path.steps.grasp.spec
    return () if spec.mechanism is None else over(limits_of(spec), path.last.efforts)


def _short_of_torque(path: Loading) -> str:
    """Which joints these are, in words; "" where there is none."""
    found = _over(path)
    return needs_more([c.who for c in found], path.steps.grasp.spec) if found else ""


def _moved(path: Loading) -> float:
    """How far the reference point is at the end from where it was when the load began [m]."""
    steps = path.steps
    begun = int((steps.stage == 0).sum()) if path.stages[0] == ORDER[0] else 1  # weight and load come after it
    u = steps.displacement
    return float(np.linalg.norm(u[-1, :3] - u[max(begun - 1, 0), :3]))


def _pads(spec: GraspSpec) -> float:
    """How far the load moves the reference point where only pads and the environment give way and nothing slips [m]."""
    scene, mechanism = build(spec), spec.mechanism
    E = scene.flexibility.copy()
    if mechanism is None:
        k = 3 * spec.of_hand
        E[:k] = E[:, :k] = 0.0
    else:
        joints = mechanism.compliance(mechanism.rows(scene.soft))
        E -= joints if scene.scale is None else joints * np.outer(scene.scale, scene.scale)
    still, load = np.zeros((scene.components, 1)), scene.geometry.wrench[:, None]
    twist = without_slip(scene, E, still, load)[1][:, 0]
    arm: Array = spec.reference - scene.geometry.centre
    return float(np.linalg.norm(twist[:3] + cross_rows(twist[3:], arm)))
