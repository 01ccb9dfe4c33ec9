"""Derivatives of what a whole path leads to, such as a load limit, by differences of whole paths.

    y'(p) ≈ [y(p + h) - y(p - h)] / 2h,    error ≈ |[y(p + h) - y(p)] - [y(p) - y(p - h)]| / h

A path depends on its history: which contact slid first, and how far, has to be gone through again. Where friction has
flat faces a load limit is piecewise smooth in every parameter, and such differences are off by rounding alone. `error`
is how much the two sides differ: large where events change places, so that there are two derivatives, and where steps
of a path are rougher than the change. A derivative whose sides differ by more than a thousandth is that of a parameter
that grows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.sensitivity.by.vary import STEPS, shape_of, vary

__all__ = ["PathSensitivity"]

_APART = 1e-3  # of the larger: sides that differ by more are two derivatives


class PathSensitivity:
    """Derivatives `<quantity>_by_<parameter>` of the end of a path: arrays in the shape of the quantity followed by
    that of the parameter, SI, as in `Sensitivity`, whose parameters these are. Each is made of differences of whole
    paths when it is first asked for: two paths for each entry of the parameter. NaN where a path has no such end.
    """

    def __init__(self, spec: GraspSpec, end: Callable[[GraspSpec], dict[str, Array]], coarser: float = 1.0) -> None:
        """End : the quantities at the end of the path of a grasp. coarser : times the steps of `STEPS`."""
        self._spec, self._end, self._coarser = spec, end, coarser
        self._here = end(spec)
        self._found: dict[str, dict[str, tuple[Array, Array]]] = {}

    @property
    def parameters(self) -> tuple[str, ...]:
        """What there are derivatives by."""
        return tuple([name for name in STEPS if np.prod(shape_of(self._spec, name)) > 0])

    @property
    def quantities(self) -> tuple[str, ...]:
        """What there are derivatives of."""
        return tuple(self._here)

    def of(self, quantity: str, parameter: str) -> Array:
        """The derivative, as the attribute. Raises UnknownName."""
        return self._pair(quantity, parameter)[0]

    def error(self, quantity: str, parameter: str) -> Array:
        """By how much the derivatives on the two sides differ, in the same shape. Raises UnknownName."""
        return self._pair(quantity, parameter)[1]

    def _pair(self, quantity: str, parameter: str) -> tuple[Array, Array]:
        if quantity not in self._here:
            raise UnknownName("quantity", "a quantity", [str(quantity)], self.quantities)
        if parameter not in self.parameters:
            raise UnknownName("parameter", "a parameter", [str(parameter)], self.parameters)
        if parameter not in self._found:
            self._found[parameter] = self._differences(parameter)
        return self._found[parameter][quantity]

    def _differences(self, parameter: str) -> dict[str, tuple[Array, Array]]:
        shape, h = shape_of(self._spec, parameter), STEPS[parameter] * self._coarser
        columns: dict[str, list[tuple[Array, Array]]] = {name: [] for name in self._here}
        for k in range(int(np.prod(shape))):
            ahead, behind = (self._end(vary(self._spec, parameter, k, step)) for step in (h, -h))
            for name, here in self._here.items():
                a, b = (ahead[name] - here) / h, (here - behind[name]) / h
                apart = abs(a - b)
                both = apart <= _APART * np.maximum(abs(a), abs(b))
                columns[name].append((np.where(both, (a + b) / 2.0, a), apart))
        return {
            name: (_stacked([a for a, _ in pairs], shape), _stacked([e for _, e in pairs], shape))
            for name, pairs in columns.items()
        }

    def __getattr__(self, name: str) -> Any:
        """`<quantity>_by_<parameter>`."""
        quantity, by, parameter = name.partition("_by_")
        if not by or name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
        return self.of(quantity, parameter)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(f"{q}_by_{p}" for q in self.quantities for p in self.parameters)]


def _stacked(columns: list[Array], shape: tuple[int, ...]) -> Array:
    whole = np.stack(columns, axis=-1)
    return read_only(whole.reshape(*whole.shape[:-1], *shape))
