"""Beyond the limit of a slowly growing load: the largest load for which any equilibrium is found.

Each load is asked of a solve of its own, which knows nothing of the way there: squeeze, weight and load all at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.geometry import length_of
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.solve_spec import solve_spec

_TRIED, _HALVED = 12, 20
_FAR = 16.0  # times the limit, where nothing bounds the load; without a limit, times a load as large as the weight
_SLACK = 1e-9  # of a torque limit
_SAME = 1e-6  # factors that differ by less are the same


def largest_held(spec: GraspSpec, section: Section, weight: Array, wrench: Array, factor: float, most: float) -> float:
    """The largest factor between `factor`, which holds, and `most`, for which a solve finds an equilibrium within
    torque limits; loads are tried at intervals and then between two of them. weight (6,) : what rests on the object
    beside the load.
    """
    if not factor < np.inf or not most > (1.0 + _SAME) * factor:
        return factor
    length = length_of(spec.positions)
    end = min(most, _FAR * (factor or _size(weight, length) / _size(wrench, length) or 1.0))
    holds = _asker(spec, section, weight, wrench)
    tried = factor + (end - factor) * np.linspace(0.0, 1.0, _TRIED + 1)[1:] ** 3  # most of them near the limit
    held = [k for k, f in enumerate(tried) if holds(float(f))]
    low = float(tried[held[-1]]) if held else factor
    high = float(tried[held[-1] + 1]) if held and held[-1] + 1 < len(tried) else end if held else float(tried[0])
    for _ in range(_HALVED):
        if not high > low:
            break
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _size(wrench: Array, length: float) -> float:
    """[N] of a wrench (6,), its torque as a force at this length [m]."""
    return float(np.hypot(np.linalg.norm(wrench[:3]), np.linalg.norm(wrench[3:]) / length))


def _asker(spec: GraspSpec, section: Section, weight: Array, wrench: Array) -> Callable[[float], bool]:
    def holds(factor: float) -> bool:
        s = solve_spec(spec.replace(wrench=read_only(weight + factor * wrench)), section, proof=False)
        return s.held and _within(spec, s)

    return holds


def _within(spec: GraspSpec, s: GraspSolution) -> bool:
    """Whether every joint is within its torque limit."""
    torques = getattr(s, "torques", None)
    if torques is None or spec.mechanism is None:
        return True
    return bool((abs(torques) <= (1.0 + _SLACK) * spec.mechanism.limits).all())
