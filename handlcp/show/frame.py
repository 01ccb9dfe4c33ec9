"""Tables for pandas, which is imported when one is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.grasp import GraspSolution
from handlcp.words import distinct

Frame = Any  # pandas'


def data_frame(columns: Mapping[str, Any], index: Any = None) -> Frame:
    """A `pandas.DataFrame`. Raises Unsupported when pandas is not installed."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise Unsupported("tables need pandas: pip install 'handlcp[table]'") from None
    return DataFrame(dict(columns), index=index)


def solution_frame(solution: GraspSolution, of: str) -> Frame:
    """See `GraspSolution.to_frame`."""
    if of == "contacts":
        return data_frame(_contacts(solution), distinct(solution.names))
    check, yielded = (getattr(solution, name, None) for name in ("torque_check", "joint_yield"))
    if of != "joints" or check is None:
        expected = '"contacts"' if check is None else '"contacts" or "joints"'
        raise InputError("of", f"{expected}{' for a grasp without a hand' if check is None else ''}", repr(of))
    columns = {
        "torque_Nm": check.torque, "limit_Nm": check.limit, "utilisation": check.utilisation,
        "margin_Nm": check.margin, "yield_rad": yielded,
    }  # fmt: skip
    return data_frame(columns, list(check.joints))


def _contacts(s: GraspSolution) -> dict[str, Any]:
    found: dict[str, Any] = {
        "state": list(s.contact_state), "normal_N": s.normal_force, "friction_N": np.hypot(*s.tangential_force.T),
        "friction_used": s.friction_used, "friction_margin_N": s.friction_margin, "slip_m": np.hypot(*s.slip.T),
        "gap_m": s.gap,
    }  # fmt: skip
    found |= _along(s.forces, "") | _along(s.forces_world, "world_")
    if s.torsion is not None:
        found |= {"moment_Nm": s.torsion, "spin_rad": s.spin}
    return found


def _along(forces: Array, prefix: str) -> dict[str, Array]:
    return {f"{prefix}{axis}_N": forces[:, k] for k, axis in enumerate("xyz")}
