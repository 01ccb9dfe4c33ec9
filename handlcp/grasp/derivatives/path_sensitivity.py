"""`PathSensitivity`: derivatives of what a whole path leads to, such as a load limit, by differences of whole paths.

    ahead = [y(p + h) - y(p)] / h,    behind = [y(p) - y(p - h)] / h,    y'(p) = (ahead + behind) / 2

A path depends on its history: which contact slid first, and how far, has to be gone through again. Where the two sides
differ by more than a tenth there is no derivative, and NaN stands for it: events change places there, so that the end
jumps or has a corner. A symmetric grasp is such a place: one finger weaker than the others slides first, however little
weaker it is. A common change of all fingers keeps the symmetry, and has a derivative.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, check_method_calls, check_number, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.derivatives.parameter import (
    find_parameter,
    find_present_parameter,
    parameters_by_effort,
    present_parameters,
)
from handlcp.grasp.derivatives.parameter.parameter import TABLE_SHARE
from handlcp.grasp.derivatives.sensitivity import format_value
from handlcp.grasp.model.request import GraspSpec
from handlcp.record import to_plain
from handlcp.words import TextTable, first_largest_index, wrap_text

_MAX_SIDE_GAP = 0.1  # of the larger side: where they differ by more, there is no derivative
# Of the largest difference quotient of a quantity: the sides of an entry that differ by less differ by the roughness of
# the path
_ROUGHNESS_SHARE = 1e-3
_ROUNDING_SHARE = 1e-10  # of a quantity, which a difference divides by the step
_ALL_PREFIX = "all_"


class TwoSidedDifferences(NamedTuple):
    """Differences on the two sides, each in the shape of the quantity followed by that of the parameter, SI."""

    ahead: Array
    behind: Array
    derivative: Array


@check_method_calls
class PathSensitivity:
    """Derivatives `<quantity>_by_<parameter>` of the end of a path: arrays in the shape of the quantity followed by
    that of the parameter, SI, as in `Sensitivity`, whose parameters these are. With `all_` before its
    name (friction, pads, squeeze, stiffness, torque_limits) a parameter is the same change of all fingers or joints at
    once, without a shape of its own. Each is made of differences of whole paths when it is first asked for: two paths
    for each entry of the parameter. NaN where a path has no such end, and where it jumps or has a corner: `jumps` names
    those that were asked for, `sides` has what was found on either side.
    """

    def __init__(self, spec: GraspSpec, end: Callable[[GraspSpec], dict[str, Array]], coarser: float = 1.0) -> None:
        """Take the quantities at the end of a grasp's path as they are now.

        end : the quantities at the end of the path of a grasp.
        coarser : how many times the usual steps of the parameters are.
        """
        self._spec, self._end, self._coarser = spec, end, coarser
        self._here = end(spec)
        self._found: dict[str, dict[str, TwoSidedDifferences]] = {}

    @property
    def parameters(self) -> tuple[str, ...]:
        """What there are derivatives by."""
        each = present_parameters(self._spec)
        return (*(p.name for p in each), *(_ALL_PREFIX + p.name for p in each if p.together))

    @property
    def quantities(self) -> tuple[str, ...]:
        """What there are derivatives of."""
        return tuple(self._here)

    @property
    def jumps(self) -> tuple[str, ...]:
        """Of the derivatives asked for so far, those with an entry where the end jumps or has a corner."""
        return tuple(
            f"{quantity}_by_{parameter}"
            for parameter, found in self._found.items()
            for quantity, s in found.items()
            if (np.isnan(s.derivative) & np.isfinite(s.ahead) & np.isfinite(s.behind)).any()
        )

    def of(self, quantity: str, parameter: str) -> Array:
        """The derivative, as the attribute. Raises UnknownName."""
        return self.sides(quantity, parameter).derivative

    def error(self, quantity: str, parameter: str) -> Array:
        """By how much the derivatives on the two sides differ, in the same shape. Raises UnknownName."""
        ahead, behind, _ = self.sides(quantity, parameter)
        with np.errstate(invalid="ignore"):
            return read_only(np.asarray(abs(ahead - behind)))

    def sides(self, quantity: str, parameter: str) -> TwoSidedDifferences:
        """The differences where the parameter is a little larger, and where it is a little smaller. Where the end jumps
        they say which way, but not how fast. Raises UnknownName.
        """
        if quantity not in self._here:
            raise UnknownName("quantity", "a quantity", [str(quantity)], self.quantities)
        if parameter not in self.parameters:
            raise UnknownName("parameter", "a parameter", [str(parameter)], self.parameters)
        if parameter not in self._found:
            self._found[parameter] = self._differences(parameter)
        return self._found[parameter][quantity]

    def of_share(self, parameter: str, share: float) -> dict[str, Array]:
        """By quantity, its change to first order when all entries of a parameter grow by a share of themselves; {}
        where they are all zero.
        """
        share, of = check_number("share", share), find_present_parameter(self._spec, parameter)
        sizes = of.values(self._spec)
        largest = float(abs(sizes).max(initial=0.0))
        if largest == 0.0:
            return {}
        found = self._two_sides(lambda h: of.varied_all(self._spec, h * sizes / largest), of.step)
        return {name: share * largest * sides.derivative for name, sides in found.items()}

    def _differences(self, parameter: str) -> dict[str, TwoSidedDifferences]:
        of = find_parameter(parameter.removeprefix(_ALL_PREFIX))
        shape = of.shape(self._spec)
        if parameter.startswith(_ALL_PREFIX):
            return self._two_sides(lambda h: of.varied_all(self._spec, h * np.ones(shape)), of.step)
        columns = [self._two_sides(partial(of.varied, self._spec, k), of.step) for k in range(int(np.prod(shape)))]
        found = {}
        for name, here in self._here.items():
            sides = [np.stack(side, axis=-1) for side in zip(*(column[name] for column in columns), strict=True)]
            found[name] = TwoSidedDifferences(*[read_only(side.reshape(*here.shape, *shape)) for side in sides])
        return found

    def _two_sides(self, varied: Callable[[float], GraspSpec], step: float) -> dict[str, TwoSidedDifferences]:
        """Of grasps with a parameter larger by steps of either sign."""
        h = step * self._coarser
        ahead, behind = self._end(varied(h)), self._end(varied(-h))
        return {name: self._sides(name, ahead, behind, h) for name in self._here}

    def _sides(self, name: str, ahead: dict[str, Array], behind: dict[str, Array], h: float) -> TwoSidedDifferences:
        here = self._here[name]
        with np.errstate(invalid="ignore"):  # no limit at all: inf - inf
            a, b = np.asarray((ahead[name] - here) / h), np.asarray((here - behind[name]) / h)
            larger = np.maximum(abs(a), abs(b))
            least = _ROUGHNESS_SHARE * np.nanmax(larger, initial=0.0) if larger.size > 1 else 0.0
            rounding = _ROUNDING_SHARE * np.nanmax(abs(here), initial=0.0) / h
            same = abs(a - b) <= np.maximum(_MAX_SIDE_GAP * larger, least + rounding)
        return TwoSidedDifferences(read_only(a), read_only(b), read_only(np.where(same, (a + b) / 2.0, np.nan)))

    def to_dict(self) -> dict[str, Any]:
        """The quantities and the derivatives asked for so far as plain data, in SI, None for what is no number;
        `jumps`.
        """
        found = {f"{of}_by_{by}": to_plain(s.derivative) for by, each in self._found.items() for of, s in each.items()}
        return {**{name: to_plain(here) for name, here in self._here.items()}, **found, "jumps": list(self.jumps)}

    def __str__(self) -> str:
        """What a tenth more of each parameter, of all fingers or joints together, does to each quantity."""
        here = self._here
        cells, unclear = [("now", *(f"{abs(value).max(initial=0.0):.4g}" for value in here.values()))], []
        for p in parameters_by_effort():
            if p.common and p.name in self.parameters and (changes := self.of_share(p.name, TABLE_SHARE)):
                found = [_largest_change(here[name], change) for name, change in changes.items()]
                cells.append((f"{p.common} +10 %", *(format_value(x, "+.3g") for x in found)))
                if not np.isfinite(found).all():
                    unclear.append(p.common)
        lines = [str(TextTable(("all fingers, all joints", *here), tuple(cells), "<" + ">" * len(here)))]
        if any(value.ndim for value in here.values()):
            lines.append("Of each quantity its largest component, SI: its size, and the change of it.")
        if unclear:
            lines.append(
                wrap_text(f"–: no derivative, for the end jumps or has a corner there ({', '.join(unclear)}).")
            )
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"PathSensitivity(of={', '.join(self.quantities)})"

    def __getattr__(self, name: str) -> Any:
        """Return the derivative that `<quantity>_by_<parameter>` names."""
        quantity, by, parameter = name.partition("_by_")
        if not by or name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        return self.of(quantity, parameter)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(f"{q}_by_{p}" for q in self.quantities for p in self.parameters)]


def _largest_change(here: Array, change: Array) -> float:
    """The change of the size of the largest component."""
    if not here.size:
        return 0.0
    k = first_largest_index(abs(here.reshape(-1)))
    return float(change.reshape(-1)[k] * (-1.0 if here.reshape(-1)[k] < 0.0 else 1.0))
