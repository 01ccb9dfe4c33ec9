"""How much squeeze, or how much friction, it takes: the smallest common value that holds, found by certified solves.

The search (`least`) goes upwards from the least value that could hold. What comes back holds; the value a tolerance
below it does not, as `Grasp.solve` says.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from handlcp.check import number
from handlcp.errors import InputError
from handlcp.grasp.analysis.least import least
from handlcp.grasp.answer.verdict import HELD
from handlcp.grasp.assembly.build import build
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.friction import with_friction
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.solve.stages import BRIEF
from handlcp.grasp.verify.capacity import overload
from handlcp.grasp.verify.holdable import escaping_twist
from handlcp.keywords import helped_methods
from handlcp.lcp import Auto
from handlcp.record import Record, data_frame
from handlcp.text_table import wrapped

Holds = Callable[[GraspSpec, Section], bool]

CHAIN = Auto(search_work=BRIEF)
_FIRST = 2.0**-10  # of the natural size: the first step upwards
_FRICTION = 10.0  # the largest coefficient that is tried


@helped_methods
@dataclass(frozen=True, slots=True)
class Required(Record):
    """The smallest common value that holds.

    value : it holds (certified); 0 when nothing more is needed; None when nothing up to `limit` was found to hold.
    fails : the largest value tried below `value` that does not hold, value - fails ≤ tolerance · value or, for a
        tolerance finer than that, one rounding step; None when value is 0.
    proven : whether below `value` nothing can hold, because no force in the friction cones balances the load there
        (or, where value is None, at any value). Otherwise `fails` only means that no equilibrium was found.
    unit : "m" of squeeze, "N" of grip or "" for a friction coefficient. limit : largest value that would be tried.
    tolerance : relative.
    checked : ((value, whether it holds), …) in the order tried.
    hint : what to change instead where value is None; what less or more does where more does not always hold better;
    "" if nothing is known.
    verdict : the word of `check()` at `value`, where the loading is followed; "" where it was not asked. What prints
        begins with it unless it is HELD.
    """

    value: float | None
    fails: float | None
    proven: bool
    unit: str
    limit: float
    tolerance: float
    checked: tuple[tuple[float, bool], ...] = field(repr=False)
    hint: str = ""
    verdict: str = ""

    def to_frame(self) -> Any:
        """A pandas table of the values tried, in their order: "value", "holds". Raises Unsupported without pandas."""
        return data_frame({name: [pair[k] for pair in self.checked] for k, name in enumerate(("value", "holds"))})

    def __str__(self) -> str:
        if self.value is None:
            if self.proven:
                return "no value found that holds: no force within friction and limits balances the load"
            none = f"no value up to {self._said(self.limit)} found that holds"
            return wrapped(f"{none}: {self.hint}" if self.hint else none, "  ")
        bare = "nothing added" if self.unit else "no friction"
        value = self._said(self.value) if self.value > 0.0 else bare
        if self.verdict == HELD:
            text = f"{value} holds" if self.value > 0.0 else f"holds with {bare}"
        elif self.verdict:
            text = f"{self.verdict}: check() says so of the grasp with {value}, the least found"
        else:
            text = f"NOT FOLLOWED: one solve holds with {value}, and check() was not asked"
        if self.fails is not None and self.value > 0.0:
            text += f"{', ' if self.verdict == HELD else '; '}{self._said(self.fails)} does not"
            text += "" if self.verdict == HELD else " hold"
        return wrapped("; ".join([part for part in (text, self.hint) if part]), "  ")

    def _said(self, value: float) -> str:
        """A coefficient, newtons, or a squeeze in millimetres, with digits enough to tell the two values apart."""
        if self.unit != "m":
            return f"{value:.4g} {self.unit}".rstrip()
        size, unit = (1e6, "µm") if 0.0 < value < 1e-4 else (1e3, "mm")
        return f"{size * value:.4g} {unit}"


def holds(spec: GraspSpec, section: Section) -> bool:
    """Whether the solver chain, with a brief search, finds an equilibrium that the certifier passes."""
    return solve_spec(spec, section, CHAIN).held


def surely(spec: GraspSpec, section: Section) -> bool:
    """The same with all the time that `Grasp.solve` takes."""
    return solve_spec(spec, section).held


def required_preload(
    spec: GraspSpec, section: Section, tolerance: float = 1e-3, limit: float | None = None, test: Holds = holds,
    sure: Holds = surely,
) -> Required:  # fmt: skip
    """The smallest squeeze [m] that, added to every finger whose force is not prescribed, makes the grasp hold.

    limit : largest squeeze tried [m]; None: 10⁴ natural motions, the fingers' mean deflection under the load (rigid
        fingers: the size of the grasp). test : whether a grasp holds; sure : asked where the answer hangs on a "no".

    Squeeze changes no friction cone: where no force in them balances the load, none is enough, and that is proven.
    """
    tolerance, size = tolerance_of(tolerance), build(spec).units.motion
    most = 1e4 * size if limit is None else number("limit", limit, above=0.0)
    if _escapes(spec, section):
        return Required(None, None, True, "m", most, tolerance, ())
    tests = [lambda x, t=t: t(spec.squeezed(x), section) for t in (test, sure)]
    found = least(tests[0], 0.0, most, tolerance, step=_FIRST * size, sure=tests[1])
    return Required(found.value, found.fails, False, "m", most, tolerance, found.tried)


def required_friction(
    spec: GraspSpec, section: Section, tolerance: float = 1e-3, limit: float | None = None, test: Holds = holds,
    sure: Holds = surely,
) -> Required:  # fmt: skip
    """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds.

    limit : largest coefficient tried, 10 when None. test, sure : as in `required_preload`.

    Friction cones grow with μ, so whether some force balances the load is monotone: bisection on that gives a lower
    bound that is proven, and the search for an equilibrium starts there.
    """
    tolerance, most = tolerance_of(tolerance), number("limit", _FRICTION if limit is None else limit, above=0.0)
    if _escapes(with_friction(spec, most), section):
        return Required(None, None, True, "", most, tolerance, ())
    low, high = 0.0, most if _escapes(with_friction(spec, 0.0), section) else 0.0
    while high - low > 0.25 * tolerance * high:
        middle = math.sqrt(low * high) if low > 0.0 else (high / 16 if high > 1e-9 else 0.0)
        if not low < middle < high:  # a tolerance finer than floats can be halved
            break
        low, high = (middle, high) if _escapes(with_friction(spec, middle), section) else (low, middle)
    step = max(0.25 * tolerance * high, 1e-6)
    tests = [lambda x, t=t: t(with_friction(spec, x), section) for t in (test, sure)]
    first = least(tests[0], high, most, tolerance, step=step, floor=high, sure=tests[1])
    found = Required(first.value, first.fails, False, "", most, tolerance, first.tried)
    if found.value is not None and found.value == high > 0.0:  # the first value tried holds, and below nothing can
        return replace(found, fails=low, proven=True)
    if found.value is None and (build(spec).offset[2 : 3 * spec.n : 3][spec.free_fingers] >= 0.0).all():
        return replace(found, hint="no finger squeezes the object; required_preload() says how much would do")
    return found


def _escapes(spec: GraspSpec, section: Section) -> bool:
    """Whether it is proven that no force within friction, and within what effects limit, balances the load."""
    scene = build(spec)
    return escaping_twist(scene, section) is not None or overload(scene, section, spec.effects) is not None


def tolerance_of(value: Any) -> float:
    """A relative tolerance, above 0 and below 1. Raises InputError."""
    tolerance = number("tolerance", value, above=0.0)
    if tolerance >= 1.0:
        raise InputError("tolerance", "a relative tolerance below 1", value)
    return tolerance
