"""Derivatives of an answer, made when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.parameter import named, parameters, present
from handlcp.grasp.parameter.posture import by_depth
from handlcp.grasp.sensitivity.kinks import Kink
from handlcp.grasp.sensitivity.respond import Response
from handlcp.grasp.sensitivity.table import QUANTITIES, what_matters
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, Rates
from handlcp.keywords import helped_methods
from handlcp.record import Record, data_frame, plain
from handlcp.tolerances import ACTIVE

_MADE_AGAIN = "posture", "lengths"  # by these the grasp is made again as it was asked for


@dataclass(frozen=True, eq=False)
class Along:
    """What an answer does while a parameter moves along a direction: derivatives per unit of it, where it begins to
    grow (`ahead`) and where it begins to shrink (`behind`). Both are the same away from kinks. Each maps a quantity to
    its derivative, in the shape that the quantity has in the solution; NaN: there is no answer on that side.
    """

    ahead: dict[str, Array]
    behind: dict[str, Array]


@helped_methods
class Sensitivity(Record):
    """Derivatives of a solution, `<quantity>_by_<parameter>`: read-only arrays in the shape of the quantity followed by
    that of the parameter, SI. Made by `solution.sensitivity()`.

    Quantities: forces (n, 3) contact axes, torsion (n,) of soft fingers, slip (n, 2), gap (n,), displacement (6,) about
    the reference, friction_margin (n,); of a hand torques (nv,), torque_margin (nv,).
    Parameters: wrench (6,) about the reference, squeeze (n,) [m], pads (n,) [m/N], friction (n,) the coefficient, with
    which the law grows as a whole, positions (n, 3) [m] world axes, normals (n, 3) turns of the contact axes about
    themselves [rad]; of a hand stiffness (nv,) [N·m/rad], joint_offset (nv,) [rad], torque_limits (nv,) [N·m], which
    matter beside `TorqueSaturation`, posture (nv,) [rad], lengths (m, 3) [m] of `length_names`.

    One parameter changes and all else stays: contacts, offsets and commands of the joints stay as they are while
    contacts move or turn. By posture and lengths the grasp is made again as it was asked for: contacts on an object are
    detected anew, those that were given stay, and so do the arguments squeeze, grip_force and joint_offset. (These two
    are central differences of what is detected, not of answers.)

    Contacts keep their states. Where a state depends on the direction of a change, `kinks` says which, and each entry
    is the derivative for a parameter that grows; `along` has both sides. By posture and lengths alone, a fingertip that
    just touches the object it was detected on is such a kink: what is deeper counts as squeezed as `close_on` squeezes,
    with the sideways motion of the tip, and a gap does not. NaN: not determined, because the solution leaves it free,
    or no answer lies in that direction.
    """

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        self._response = Response.of(answer)
        self._rates: dict[str, tuple[Rates, Change]] = {}

    @property
    def parameters(self) -> tuple[str, ...]:
        """What there are derivatives by."""
        return tuple([p.name for p in present(self._answer.spec)])

    @property
    def quantities(self) -> tuple[str, ...]:
        """What there are derivatives of."""
        hand = self._answer.spec.mechanism is not None
        return tuple([name for name, q in QUANTITIES.items() if hand or not q.joints])

    @property
    def length_names(self) -> tuple[str, ...]:
        """(m,) joints and fingertips whose places are `lengths`; () without a hand."""
        mechanism = self._answer.spec.mechanism
        return () if mechanism is None else mechanism.lengths

    @property
    def kinks(self) -> tuple[Kink, ...]:
        """Where a derivative has two sides; () where nothing does."""
        return (*self._response.kinks, *_touching_kinks(self._answer))

    @property
    def free(self) -> int:
        """In how many directions forces and motion are free, so that derivatives along them are NaN."""
        return int(self._response.free.shape[1])

    def of(self, quantity: str, parameter: str) -> Array:
        """The derivative, as the attribute `<quantity>_by_<parameter>`. Raises UnknownName, and Unsupported where a
        grasp has no such derivative.
        """
        if quantity not in QUANTITIES or (QUANTITIES[quantity].joints and self._answer.spec.mechanism is None):
            raise UnknownName("quantity", "a quantity", [str(quantity)], self.quantities)
        rates, change = self._by(parameter)
        found = QUANTITIES[quantity].rate(self._answer, rates, change.ahead)
        return read_only(found.reshape(*found.shape[:-1], *self._shape(parameter)))

    def along(self, parameter: str, direction: Any) -> Along:
        """The derivatives along a direction, an array in the parameter's shape, on both sides. Raises UnknownName,
        InputError.
        """
        _, change = self._by(parameter)
        way = array("direction", direction, self._shape(parameter)).reshape(-1)
        ahead, behind = self._one_side(change.toward(way)), self._one_side(change.toward(-way))
        return Along(ahead, {name: read_only(-rate) for name, rate in behind.items()})

    def _one_side(self, change: Change) -> dict[str, Array]:
        rates = self._response.to(change)
        return {name: read_only(QUANTITIES[name].rate(self._answer, rates, change)[..., 0]) for name in self.quantities}

    def _shape(self, parameter: str) -> tuple[int, ...]:
        return named(parameter).shape(self._answer.spec)

    def _by(self, parameter: str) -> tuple[Rates, Change]:
        if (known := self._rates.get(parameter)) is not None:
            return known
        spec = self._answer.spec
        of = next((p for p in parameters() if p.name == parameter and 0 not in p.shape(spec)), None)
        if of is None:
            raise UnknownName("parameter", "a parameter", [str(parameter)], self.parameters)
        change = of.change(self._answer)
        known = self._rates[parameter] = self._response.to(change.ahead), change
        return known

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, by name: nested lists, SI, None for what is not a finite number; and the kinks."""
        found: dict[str, Any] = {"kinks": [str(k) for k in self.kinks], "free_directions": self.free}
        return found | {f"{q}_by_{p}": plain(self.of(q, p)) for p in self.parameters for q in self.quantities}

    def to_frame(self, quantity: str, parameter: str) -> Any:
        """A pandas table of one derivative: a row for each entry of the quantity, a column for each of the parameter,
        both named by their numbers, such as "0.2". Raises UnknownName, and Unsupported without pandas.
        """
        value = self.of(quantity, parameter)
        of = self._shape(parameter)
        rows, columns = value.shape[: value.ndim - len(of)], [".".join(map(str, k)) for k in np.ndindex(*of)]
        flat = value.reshape(-1, len(columns))
        index = [".".join(map(str, k)) for k in np.ndindex(*rows)]
        return data_frame({name: flat[:, k] for k, name in enumerate(columns)}, index)

    def __str__(self) -> str:
        """What a tenth more of each parameter, at all fingers or joints together, does to the largest force, the
        friction to spare, the largest torque, and the motion.
        """
        return what_matters(self, self._answer)

    def __getattr__(self, name: str) -> Array:
        """`<quantity>_by_<parameter>`."""
        quantity, by, parameter = name.partition("_by_")
        if not by or quantity not in QUANTITIES or all(p.name != parameter for p in parameters()):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        value = self.of(quantity, parameter)
        self.__dict__[name] = value
        return value

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(f"{q}_by_{p}" for q in self.quantities for p in self.parameters)]


def _touching_kinks(answer: Answer) -> tuple[Kink, ...]:
    """Fingertips that just touch, where that gives derivatives by posture and lengths two sides."""
    deeper, mechanism = by_depth(answer), answer.spec.mechanism
    found = None if mechanism is None else mechanism.inside(answer.spec)
    if deeper is None or found is None:
        return ()
    some = [int(i) for i in deeper.contacts if found[1][i]]
    return tuple([Kink(answer.spec.names[i], "just touches where it was detected", i, _MADE_AGAIN) for i in some])


def sensitivity_of(solution: Any) -> Sensitivity:
    """Of a `GraspSolution`. Raises InputError for one that is not held, and so has no forces."""
    s = solution
    if not s.held or s.spec is None or s.scene is None or s.section is None:
        raise InputError("solution", "a solution that is held: others have no forces", s.status.name)
    weak, slow = ACTIVE * s.residuals.force_scale, ACTIVE * max(s.residuals.motion_scale, s.scene.units.motion)
    twist = s.object_displacement
    return Sensitivity(Answer(s.spec, s.scene, s.section, s.forces, s.torsion, twist, s.extra, weak, slow))
