"""`lift_and_shake`: a ball at 50 % and a cube at 85 % of a rated payload, lifted and shaken along gravity.

The hand points down. It is lifted by h in the time T, and then shaken by A sin(2π f t) along gravity:

    lift    a = 4 h / T²          speeding up for half of the way, and slowing down for the other half
    shake   a = A (2π f)²         > 4 h / T²: the shake decides

Quasi-statically the object weighs m (g ± a). The weight comes and goes between the two as often as the hand is
shaken, and friction remembers what slipped: a path with 2 f t stages, which is followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, check_call, check_number, check_unit_vector
from handlcp.errors import HandLCPError, InputError
from handlcp.geometry import Box, Object, Sphere
from handlcp.geometry.shape import check_object_metres
from handlcp.grasp import Loading, Stage, TorqueSaturation
from handlcp.grasp.failure.failure_mode import is_exceeded, state_limits
from handlcp.hand import Found, Hand, HandGrasp, find_grasp
from handlcp.progress import track_progress
from handlcp.record import Record
from handlcp.studies.grip_strength.measure import (
    close_with_full_torque,
    largest_limit_share,
    require_torque_limits,
)
from handlcp.studies.payload.result import format_mass
from handlcp.words import wrap_text

_SOURCE = "NVIDIA SimReady Foundation, FET028, gripper_close_lift_sphere and gripper_close_lift_cube 1.4.0"


@dataclass(frozen=True, eq=False)
class ShakenObject(Record):
    """One object, lifted and shaken in the best grasp that was found.

    shape : "sphere" or "cube".
    size : its diameter or edge [m].
    mass : of the object [kg].
    held : whether it is held from the lift to the end of the shake, moves less than `allowed` and no joint is over its
        limit.
    says : how it ends, in words.
    moved : how far its centre moves at most in the hand once that has closed [m].
    allowed : how far it may move [m].
    used : the largest share of a torque limit on the way; 0 where none is known.
    most : the mass [kg] that the same grip holds under the largest acceleration, its joints giving way at their torque
        limits.
    period : of the object's swing along gravity in this grasp [s]; statics is right where that is short beside the
        period of the shake. NaN where the object is not held, or some motion of it is left open.
    grasp : closed, its object under the largest acceleration.
    loading : the whole path.
    """

    entries = (
        "shape", "size_m", "mass_kg", "held", "says", "moved_m", "allowed_m", "used", "mass_held_kg = most", "period_s",
        "normal_force_N",
    )  # fmt: skip

    shape: str
    size: float
    mass: float
    held: bool
    says: str
    moved: float
    allowed: float
    used: float
    most: float
    period: float
    grasp: HandGrasp
    loading: Loading

    @property
    def normal_force(self) -> dict[str, float]:
        """How hard each contact presses at the end, by name [N]."""
        return self.loading.solution.pressed

    def __str__(self) -> str:
        held = "held" if self.held else "not held"
        what = f"{self.shape}, {words.format_length(self.size)}, {format_mass(self.mass)}: {held}"
        return f"{what}: {self.says}; this grip holds up to {format_mass(self.most)}"


@dataclass(frozen=True, eq=False)
class LiftAndShake(Record):
    """A ball and a cube, lifted and shaken; made by `lift_and_shake`.

    rated : the payload that is tested [kg]. opening : of the hand [m]. acceleration : the largest of the shake [m/s²].
    sphere, cube : what becomes of them; None where the hand has no grasp of it, with the reason in `missing`.
    source : the document that has the test.
    """

    entries = (
        "source", "passed", "rated_payload_kg = rated", "opening_m", "acceleration_m_per_s2", "sphere", "cube",
        "missing",
    )  # fmt: skip

    rated: float
    opening: float
    acceleration: float
    sphere: ShakenObject | None
    cube: ShakenObject | None
    missing: dict[str, str] = field(default_factory=dict)
    source: str = _SOURCE

    @property
    def passed(self) -> bool:
        """Whether both are held."""
        return all(row is not None and row.held for row in (self.sphere, self.cube))

    def __str__(self) -> str:
        """What was asked, and a line for each object."""
        asked = f"lift and shake at a rated payload of {format_mass(self.rated)}, up to {self.acceleration:.3g} m/s²"
        lines = [f"{asked}: {'passed' if self.passed else 'not passed'}"]
        lines += [str(row) for row in (self.sphere, self.cube) if row is not None]
        lines += [f"{shape}: not held: {why}" for shape, why in self.missing.items()]
        return "\n".join([wrap_text(line, "  ") for line in lines])

    def __repr__(self) -> str:
        return f"LiftAndShake(rated={self.rated:g}, passed={self.passed})"


# ----------------------------------------------------------------
# Numbers of the test, as NVIDIA's documents state them, but for how the lift speeds up, which they leave open.

SPHERE, CUBE = "sphere", "cube"
PAYLOAD_SHARES = {SPHERE: 0.5, CUBE: 0.85}  # of the rated payload
SIZE_SHARE = 0.7  # of the opening: the diameter of the ball, the edge of the cube
LIFT_HEIGHT, LIFT_TIME = 0.2, 1.0  # [m], [s]
AMPLITUDE, FREQUENCY, SHAKE_TIME = 0.02, 2.0, 2.0  # [m], [1/s], [s]
ALLOWED_SLIP = 0.03  # [m] that the object may slip while it is shaken
_GRAVITY = 9.81
# Of the weight, under which grasps are looked for: each plans its grip with a part of the friction
_SEARCH_WEIGHT_SHARE = 0.25
_MAX_GRASPS = 3  # grasps that are lifted, until one of them holds
_MAX_ROUNDS = 4  # in which the grip comes within the torque limits of the whole path
_TORQUE_MARGIN = 1e-6  # relative, by which it then stays below them

LIFT_ACCELERATION = 4.0 * LIFT_HEIGHT / LIFT_TIME**2
SHAKE_ACCELERATION = AMPLITUDE * (2.0 * np.pi * FREQUENCY) ** 2
_LARGEST_PULL = _GRAVITY + SHAKE_ACCELERATION


@check_call()
def lift_and_shake(
    hand: Hand,
    rated_payload: Any,
    opening: Any,
    *,
    forward: Any = (0.0, 0.0, 1.0),
    friction: Any = None,
    fingers: Sequence[str] | None = None,
    tries: int = 64,
) -> LiftAndShake:
    """Whether a hand lifts and shakes a ball at 50 % and a cube at 85 % of a rated payload, in the manner of the
    gripper tests of NVIDIA's SimReady Foundation (FET028).

    rated_payload : [kg]. opening : the widest object that goes into the hand [m]; ball and cube are 70 % as wide.
    forward : (3,) in which the hand points, axes of its base; it points down. friction : of all contacts, as in
    `state.grasp`; the documents give the objects 2.0 and leave the pads to the hand's file. fingers : names of those
    that take part; None: all. tries : as in `find_grasp`.

    `find_grasp` places the object between the fingertips. The grip grows until a joint is at its torque limit, under
    the largest weight m (g + a), with a = 3.16 m/s² of the shake (2 cm, 2 Hz, 2 s). The weight then comes and goes,
    four times, followed. Of the three best grasps the first that holds counts, or else the one that holds most.
    Motions are slow: `period` of each object tells how quickly it swings in the grasp.

    A hand that has no grasp of an object has None for it, with the reason in `missing`. Raises InputError,
    UnknownName; InputError for a hand whose torque limits are not all known.
    """
    if not isinstance(hand, Hand):
        raise InputError("hand", "a Hand", repr(hand)[:80])
    rated = check_number("rated_payload", rated_payload, above=0.0)
    wide = check_number("opening", opening, above=0.0)
    down = check_unit_vector("forward", forward, (3,))
    require_torque_limits(hand)
    size = SIZE_SHARE * wide
    objects: dict[str, Object] = {
        SPHERE: Sphere(0.5 * size, mass=PAYLOAD_SHARES[SPHERE] * rated),
        CUBE: Box(size, mass=PAYLOAD_SHARES[CUBE] * rated),
    }
    check_object_metres("opening", objects[SPHERE], hand.at(hand.neutral).tip_positions)
    rows, missing = dict[str, ShakenObject | None](), dict[str, str]()
    with track_progress("lifting and shaking"):
        for shape, obj in objects.items():
            rows[shape] = None
            try:
                pull = _SEARCH_WEIGHT_SHARE * _LARGEST_PULL * down
                found = find_grasp(hand, obj, friction=friction, gravity=pull, fingers=fingers, tries=tries)
                rows[shape] = _choose_best_grasp(found, shape, size, down)
            except InputError:
                raise
            except HandLCPError as error:
                missing[shape] = str(error)
    return LiftAndShake(rated, wide, SHAKE_ACCELERATION, rows[SPHERE], rows[CUBE], missing)


def _choose_best_grasp(found: Found, shape: str, size: float, down: Array) -> ShakenObject:
    """The first grasp that holds, or else the one that holds most."""
    rows = list[ShakenObject]()
    for candidate in list(found)[:_MAX_GRASPS]:
        planned: Any = candidate.grasp.spec.asked
        grip, share = np.array(planned.grip_force), float(np.nanmax(candidate.solution.torque_check.utilisation))
        grasp = close_with_full_torque(candidate.grasp.replace(gravity=_LARGEST_PULL * down), grip, share).grasp
        for _ in range(_MAX_ROUNDS):
            row = shake_grasp(grasp, shape, size, down)
            if not is_exceeded(row.used):
                break
            closer: Any = grasp.spec.asked
            grasp = grasp.replace(grip_force=np.array(closer.grip_force) * (1.0 - _TORQUE_MARGIN) / row.used)
        rows.append(row)
        if row.held:
            break
    return max(rows, key=lambda row: (row.held, np.nan_to_num(row.most, posinf=np.inf)))


def shake_grasp(grasp: HandGrasp, shape: str, size: float, down: Array) -> ShakenObject:
    """A grasp whose object has its largest weight, m (g + a), lifted and shaken."""
    loading = grasp.follow(order=make_stages())
    limits, target, steps = state_limits(grasp.spec, nominal=grasp.state.q), grasp.target, loading.steps
    assert target is not None  # it was placed
    share = max([largest_limit_share(limits, state) for state in steps.states])
    begins = int(np.flatnonzero(steps.stage == steps.stage.min())[-1]) if loading.stages[0] == "squeeze" else 0
    shifts = steps.displacement[begins:, :3] - steps.displacement[begins, :3]  # since the hand has closed
    moved, period, says = float(np.linalg.norm(shifts, axis=1).max()), np.nan, loading.why.rstrip(".")
    if loading.in_place:  # as on a spring: 2π √(m c), with the compliance c along gravity
        c = float(down @ loading.solution.sensitivity().displacement_by_wrench[:3, :3] @ down)
        period = float(2.0 * np.pi * np.sqrt(target.mass * max(c, 0.0)))
    if loading.in_place and is_exceeded(share):
        says += f", but a joint needs {share:.3g} times its limit"
    elif loading.in_place and moved > ALLOWED_SLIP:
        says += ", but the object slips too far"
    pull = np.append(_LARGEST_PULL * down, np.zeros(3))
    limit = grasp.replace(mass=0.0, effects=(TorqueSaturation(),)).load_limit(pull)
    return ShakenObject(
        shape=shape,
        size=size,
        mass=target.mass,
        held=loading.in_place and moved <= ALLOWED_SLIP and not is_exceeded(share),
        says=says,
        moved=moved,
        allowed=ALLOWED_SLIP,
        used=share,
        most=limit.factor,
        period=period,
        grasp=grasp,
        loading=loading,
    )


def make_stages() -> list[Any]:
    """Squeeze, lift, the largest weight and the least in turn, and the weight at rest; as shares of the largest."""
    ways = LIFT_ACCELERATION, -SHAKE_ACCELERATION, 0.0
    lift, least, rest = ((_GRAVITY + a) / _LARGEST_PULL for a in ways)
    found: list[Any] = ["squeeze", Stage("lift", weight=lift)]
    for k in range(1, round(FREQUENCY * SHAKE_TIME) + 1):
        found += [Stage(f"down {k}", weight=1.0), Stage(f"up {k}", weight=least)]
    return [*found, Stage("at rest", weight=rest)]
