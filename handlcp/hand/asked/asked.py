"""The arguments of `state.grasp`, and the specification made of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.asked import as_asked, fastened
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import beside, offset_beside
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.fingers import found_on, given_by
from handlcp.hand.asked.load import load_of, point_of
from handlcp.hand.command import commanded, standing_off
from handlcp.hand.mechanism import finger_flexibility, mechanism_of
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.table import surrounding
from handlcp.hand.robot.posture import GRAVITY, Posture

_GRAVITY = "an acceleration [m/s²], such as (0, 0, -9.81) or (0, 0, 0): finite numbers"


@dataclass(frozen=True, eq=False)
class HandAsked:
    """The arguments of `state.grasp`, and what `replace` alone can say.

    flexibility : of the fingers, in place of the hand's own; None: that. load : the whole load, in place of wrench and
    weight; None: these. found : contacts and offsets (k, 3) of the fingers as they are, in place of a detection.
    inside : (k,) [m] how far fingertips count as inside the object; None: as detected.
    """

    state: Posture
    target: Any
    friction: Any = None
    wrench: Any = None
    gravity: Any = GRAVITY
    preload: Any = 0.0
    offset: Any = None
    reference: Any = None
    fingers: Any = None
    max_gap: Any = 1e-3
    effects: Any = ()
    finger_weight: Any = False
    plane: Any = None
    squeeze: Any = None
    grip_force: Any = None
    joint_offset: Any = None
    environment: Any = None
    flexibility: Any = None
    load: Any = None
    found: tuple[tuple[Contact, ...], Array] | None = None
    inside: Array | None = None

    def __post_init__(self) -> None:
        fastened(self)

    def spec(self) -> GraspSpec:
        """See `state.grasp`. Raises NotReached, UnknownName, InputError."""
        obj = self.target if isinstance(self.target, Object) else None
        weighed = _weight_given(self.finger_weight)
        tips, contacts, gaps = self._fingers(obj)
        k, around = len(contacts), None if self.environment is None else surrounding(self.environment, obj)
        if around is not None:
            contacts = validate.contacts((*contacts, *around.contacts))
        positions, frames, normal = validate.placed(self.plane, contacts)
        positions, frames, planar = read_only(positions), read_only(frames), normal is not None
        g = array("gravity", self.gravity, (3,), what=_GRAVITY)
        mechanism = mechanism_of(self.state, tips, positions[:k], frames[:k], obj, g, read_only(np.zeros((k, 3))))
        given = self.flexibility
        E = finger_flexibility(mechanism) if given is None else validate.flexibility(given, k, planar)
        if self.found is not None:
            mechanism = replace(mechanism, stand_off=self.found[1])
        elif obj is not None:
            mechanism = standing_off(mechanism, gaps, planar, self.inside)
        d = offset_beside(self.offset, self.preload, k, np.zeros((0, 3)) if around is None else around.offset).copy()
        d[:k] += mechanism.stand_off
        if around is not None:
            mechanism, E = mechanism.beside(len(around.contacts)), beside(E, around.flexibility)
        point = point_of(self.reference, obj, positions, normal)
        if self.load is None:
            load = load_of(self.wrench, point, obj, g, positions, normal)
        else:
            load = validate.wrench(self.load, normal, validate.lift(positions, point, normal))
        spec = GraspSpec(
            contacts, positions, frames, normal, None if around is None else k, mechanism, load, point, E,
            read_only(d), _weight(self.state, weighed, g),
        )  # fmt: skip
        spec = commanded(as_asked(spec, self.effects), self.squeeze, self.grip_force, self.joint_offset)
        return spec.replace(asked=self)

    def _fingers(self, obj: Object | None) -> tuple[tuple[int, ...], tuple[Contact, ...], Array]:
        """Numbers of the fingertips, their contacts, and their gaps (k,) [m]."""
        if self.found is not None:
            contacts = self.found[0]
            return self.state.hand.tip_numbers("fingers", self.fingers), contacts, np.zeros(len(contacts))
        if obj is None:
            return given_by(self.state, self.target, self.friction, self.fingers)
        return found_on(self.state, obj, self.friction, self.fingers, self.max_gap)


def _weight_given(value: Any) -> bool | str:
    """False, True or "torques". Raises InputError."""
    if isinstance(value, bool) or (isinstance(value, str) and value == "torques"):
        return value
    raise InputError("finger_weight", 'True, False or "torques"', repr(value))


def _weight(state: Posture, weighed: bool | str, gravity: Array) -> tuple[Effect, ...]:
    """The fingers' own weight, where it was asked for."""
    return (FingerWeight(read_only(state.gravity_torque(gravity)), weighed is True),) if weighed else ()
