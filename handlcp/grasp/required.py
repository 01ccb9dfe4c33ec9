"""How much squeeze, or how much friction, it takes: the smallest common value that holds, found by certified solves.

Whether a grasp holds need not be monotone in either: more squeeze can push a finger off, more friction can let an
equilibrium vanish. So the search goes upwards from the least that could hold, doubling its steps, stops at the first
value that holds and closes in on it from below. What comes back holds; the value a tolerance below it does not. A
narrower window further down may have been stepped over.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Bools, number, read_only
from handlcp.errors import InputError
from handlcp.grasp.certify import judge
from handlcp.grasp.changed import changed
from handlcp.grasp.holdable import escaping_twist, load_to_balance
from handlcp.grasp.overload import overload
from handlcp.grasp.pyramid import Section, as_section
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_form import chain_form
from handlcp.lcp import Auto, proposals

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["Required", "holds", "required_friction", "required_preload", "smallest", "with_friction", "with_preload"]

_FIRST = 2.0**-10  # of the natural size: the first step upwards
_LIMIT_FRICTION = 10.0


@dataclass(frozen=True, slots=True)
class Required:
    """The smallest common value that holds.

    value : it holds (certified); 0 when nothing more is needed; None when nothing up to `limit` was found to hold.
    fails : the largest value tried below `value` that does not hold, value - fails ≤ tolerance · value or, for a
        tolerance finer than that, one rounding step; None when value is 0.
    proven : whether below `value` nothing can hold, because no force in the friction cones balances the load there
        (or, where value is None, at any value). Otherwise `fails` only means that no solver found an equilibrium.
    unit : "m" of squeeze or "" for a friction coefficient. limit : largest value tried. tolerance : relative.
    checked : ((value, whether it holds), …) in the order tried.
    hint : what to change instead where value is None, "" if nothing is known.
    """

    value: float | None
    fails: float | None
    proven: bool
    unit: str
    limit: float
    tolerance: float
    checked: tuple[tuple[float, bool], ...] = field(repr=False)
    hint: str = ""

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if self.value is None:
            if self.proven:
                return "no value found that holds: no force within friction and limits balances the load"
            return f"no value up to {self.limit:.3g}{unit} found that holds" + (f": {self.hint}" if self.hint else "")
        if self.value == 0.0:
            return "holds with nothing added" if self.unit else "holds without friction"
        less = "" if self.fails is None else f", {self.fails:.4g}{unit} does not"
        return f"{self.value:.4g}{unit} holds{less}"


def required_preload(
    grasp: Grasp,
    faces: int | str | Section = 8,
    tolerance: float = 1e-3,
    limit: float | None = None,
    check: Callable[[Grasp], bool] | None = None,
) -> Required:
    """The smallest squeeze [m] that, added to every finger whose force is not prescribed, makes the grasp hold.

    limit : largest squeeze tried [m]; None: 10⁴ natural motions, the fingers' mean deflection under the load (rigid
        fingers: the size of the grasp). check : whether a grasp holds; None: `holds`, the solver chain and certifier.

    Squeeze changes no friction cone: where no force in them balances the load, none is enough, and that is proven.
    """
    tolerance, section = _tolerance(tolerance), as_section(faces, planar=grasp.scene.plane is not None)
    size = grasp.scene.units.motion
    most = 1e4 * size if limit is None else number("limit", limit, above=0.0)
    if _escapes(grasp, section):
        return Required(None, None, True, "m", most, tolerance, ())
    test = check or (lambda g: holds(g, section))
    return smallest(lambda x: test(with_preload(grasp, x)), 0.0, _FIRST * size, most, tolerance, "m")


def required_friction(
    grasp: Grasp,
    faces: int | str | Section = 8,
    tolerance: float = 1e-3,
    limit: float | None = None,
    check: Callable[[Grasp], bool] | None = None,
) -> Required:
    """The smallest friction coefficient, common to all contacts that have friction, with which the grasp holds.

    limit : largest coefficient tried, 10 when None. check : as in `required_preload`.

    Friction cones grow with μ, so whether some force balances the load is monotone: bisection on that gives a lower
    bound that is proven, and the search for an equilibrium starts there.
    """
    tolerance, section = _tolerance(tolerance), as_section(faces, planar=grasp.scene.plane is not None)
    most = _LIMIT_FRICTION if limit is None else number("limit", limit, above=0.0)
    if _escapes(with_friction(grasp, most), section):
        return Required(None, None, True, "", most, tolerance, ())
    low, high = 0.0, most
    if not _escapes(with_friction(grasp, 0.0), section):
        high = 0.0
    while high - low > 0.25 * tolerance * high:
        middle = math.sqrt(low * high) if low > 0.0 else (high / 16 if high > 1e-9 else 0.0)
        if not low < middle < high:  # a tolerance finer than floats can be halved
            break
        low, high = (middle, high) if _escapes(with_friction(grasp, middle), section) else (low, middle)
    test = check or (lambda g: holds(g, section))
    found = smallest(
        lambda x: test(with_friction(grasp, x)), high, max(0.25 * tolerance * high, 1e-6), most, tolerance, ""
    )
    if found.value is not None and found.value == high > 0.0:  # the first value tried holds, and below nothing can
        return Required(high, low, True, "", most, tolerance, found.checked)
    if found.value is None and (grasp.scene.offset[_squeezed(grasp.scene), 2] >= 0.0).all():
        return replace(found, hint="no finger carries preload; required_preload() says how much would do")
    return found


def smallest(
    test: Callable[[float], bool], start: float, step: float, limit: float, tolerance: float, unit: str
) -> Required:
    """The first value that holds, going from `start` upwards in steps that double, then bisected from below.

    The result's tolerance is relative to its value: value - fails ≤ tolerance · value, or one rounding step.
    """
    checked: list[tuple[float, bool]] = []

    def ok(x: float) -> bool:
        checked.append((x, bool(test(x))))
        return checked[-1][1]

    if ok(start):  # nothing below it was tried
        return Required(start, None, False, unit, limit, tolerance, tuple(checked))
    low, high = start, start
    while True:
        if high >= limit:
            return Required(None, high, False, unit, limit, tolerance, tuple(checked))
        low, high, step = high, min(high + step, limit), 2.0 * step
        if ok(high):
            break
    while high - low > tolerance * high:
        middle = 0.5 * (low + high)
        if not low < middle < high:  # neighbouring floats: a finer tolerance would never be met
            break
        low, high = (low, middle) if ok(middle) else (middle, high)
    return Required(high, low, False, unit, limit, tolerance, tuple(checked))


def holds(grasp: Grasp, section: Section) -> bool:
    """Whether the solver chain finds an equilibrium that the certifier passes; no exhaustive search is made."""
    problem = chain_form(grasp.scene, section, grasp.effects)
    return any(
        judge(grasp.scene, problem.effects, section, problem.candidate(p.z)).residuals.passes
        for _, p in proposals(problem, Auto())
    )


def with_preload(grasp: Grasp, extra: float) -> Grasp:
    """The same grasp with `extra` [m] more squeeze of every finger whose force is not prescribed."""
    offset = grasp.offset.copy()
    offset[_squeezed(grasp.scene), 2] -= extra
    return changed(grasp, offset=read_only(offset))


def with_friction(grasp: Grasp, mu: float) -> Grasp:
    """The same grasp with the coefficient `mu` at every contact that has friction; a law with several keeps their
    ratios, and `mu` is the one it calls so.
    """
    return changed(
        grasp, contacts=tuple([c.with_friction(c.friction.with_mu(mu)) if c.mu > 0 else c for c in grasp.contacts])
    )


def _squeezed(scene: Scene) -> Bools:
    """(n,) which contacts a squeeze acts on: fingers whose force is not prescribed."""
    return scene.governed_mask & (np.arange(scene.n) < scene.n - scene.environment)


def _escapes(grasp: Grasp, section: Section) -> bool:
    """Whether it is proven that no force within friction, and within what effects limit, balances the load."""
    if escaping_twist(grasp.scene, section, load_to_balance(grasp.scene, grasp.effects)) is not None:
        return True
    return overload(grasp.scene, section, grasp.effects) is not None


def _tolerance(value: float) -> float:
    tolerance = number("tolerance", value, above=0.0)
    if tolerance >= 1.0:
        raise InputError("tolerance", "a relative tolerance below 1", value)
    return tolerance
