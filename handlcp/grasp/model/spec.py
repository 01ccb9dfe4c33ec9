"""What was asked of a grasp, as data."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp.check import Array, read_only, sealed
from handlcp.errors import InputError
from handlcp.grasp.friction import FrictionLaw
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.flexibility import flexible, kept
from handlcp.grasp.model.kind import Placement, cross_rows
from handlcp.lazy import lazy

_ARRAYS = ("positions", "frames", "wrench", "reference", "flexibility", "offset")


@flexible
@dataclass(frozen=True, eq=False)
class GraspSpec(Placement):
    """A grasp before it is built: sound arrays, read-only, SI. Immutable; `build` makes a `Scene` of it.

    Besides what `Placement` says: wrench (6,) force and torque about reference (3,) that the world applies to the
    object. flexibility (3n, 3n) of fingers and environment in contact axes, made of a `Flexibility` where one was
    given, and offset (n, 3) of the object relative to them before any load, both without what the effects add.
    effects : all that were asked for, in `effects=` or by an argument of their own, such as `finger_weight=`. asked :
    the arguments that all this was made of, which `replace` of a grasp changes; None: they are not known, as after any
    change of the specification itself.
    """

    wrench: Array
    reference: Array
    flexibility: Array
    offset: Array
    effects: tuple[Effect, ...] = ()
    asked: Any = None

    def __post_init__(self) -> None:
        """Raises InputError where shapes do not fit one another; the numbers were checked where they came in."""
        n = self.n
        shapes = ((n, 3), (n, 3, 3), (6,), (3,), (3 * n, 3 * n), (n, 3))
        arrays = (self.positions, self.frames, self.wrench, self.reference, kept(self), self.offset)
        if tuple([a.shape for a in arrays]) == shapes:
            return
        for name, array, shape in zip(_ARRAYS, arrays, shapes, strict=True):
            if array.shape != shape:
                raise InputError(f"GraspSpec.{name}", f"shape {shape} with {n} contacts", array.shape)

    def replace(self, **changes: Any) -> Self:
        """The same with other values of some fields."""
        return dataclasses.replace(self, **({"asked": None, "flexibility": kept(self)} | changes))

    def with_laws(self, laws: tuple[FrictionLaw, ...]) -> Self:
        """The same with other friction, a law for each contact."""
        return self.replace(contacts=tuple([c.with_friction(f) for c, f in zip(self.contacts, laws, strict=True)]))

    def squeezed(self, extra: float) -> Self:
        """The same with `extra` [m] more squeeze of every finger whose force is not prescribed."""
        offset = self.offset.copy()
        offset[self.free_fingers, 2] -= extra
        return self.replace(offset=read_only(offset))

    @property
    def resting(self) -> Array:
        """(6,) what is on the object before another load grows, about the reference [N, N·m]: its weight, where a hand
        knows it; of contacts without a hand the whole wrench, of which nobody knows what is weight.
        """
        return self.wrench if self.mechanism is None else self.mechanism.weight_of_object(self.reference)

    @property
    def free_fingers(self) -> list[int]:
        """Numbers of the fingers whose force is not prescribed: those that a squeeze acts on."""
        known = {i for e in self.effects for i in e.prescribed()}
        return [i for i in range(self.of_hand) if i not in known]

    def fingers_alone(self) -> Self:
        """The same without the environment."""
        k, mechanism = self.of_hand, self.mechanism
        if mechanism is not None:
            mechanism = dataclasses.replace(mechanism, jacobian=mechanism.jacobian[: 3 * k])
        return self.replace(
            contacts=self.contacts[:k], positions=self.positions[:k], frames=self.frames[:k], offset=self.offset[:k],
            flexibility=read_only(self.flexibility[: 3 * k, : 3 * k].copy()), fingers=None, mechanism=mechanism,
        )  # fmt: skip

    @lazy
    def names(self) -> tuple[str, ...]:
        """(n,) finger names: the contacts' own, or "finger 1", "finger 2", …; then the environment's."""
        return tuple([c.name or f"finger {i + 1}" for i, c in enumerate(self.contacts)])

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(sealed(state))


def wrench_about(point: Array, force: Array, moment: Array) -> Array:
    """(6,) the wrench about a point (3,) from its force and its moment about the world's origin, (3,) each."""
    return read_only(np.append(force, moment - cross_rows(point, force)))
