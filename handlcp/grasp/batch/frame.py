"""A batch as named columns, for a data frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp.batch.columns import Group
from handlcp.grasp.grasp import Grasp
from handlcp.tolerances import OVER
from handlcp.words import distinct

_OBJECT = ("x", "y", "z", "rx", "ry", "rz")


def frame(grasps: Sequence[Grasp], groups: Sequence[Group]) -> dict[str, Any]:
    """Columns of m rows each, by name, as `Solutions.to_dict` says; NaN where a grasp has no such number."""
    m = len(grasps)
    fingers: dict[str, Array] = {}
    whole = {f"object.{axis}": np.full(m, np.nan) for axis in _OBJECT}
    joints: dict[str, Array] = {}
    most, binding = np.full(m, np.nan), np.full(m, None, dtype=object)

    def put(columns: dict[str, Array], name: str, at: Any, values: Array) -> None:
        columns.setdefault(name, np.full(m, np.nan))[at] = values

    for g in groups:
        for names, rows in _by_names(grasps, g).items():
            for i, name in enumerate(distinct(names)):
                for a, axis in enumerate("xyz"):
                    put(fingers, f"{name}.force_{axis}", g.at[rows], g.forces[rows, i, a])
        for a, axis in enumerate(_OBJECT):
            put(whole, f"object.{axis}", g.at, g.displacement[:, a])
        for j, name in enumerate(g.joints):
            put(joints, f"{name}.torque", g.at, g.torques[:, j])
            put(joints, f"{name}.utilisation", g.at, g.utilisation[:, j])
        if g.joints:
            most[g.at], binding[g.at] = g.utilisation.max(axis=1), _binding(g)
    if joints:
        joints["utilisation"] = most
        return {**fingers, **whole, **joints, "binding": binding.tolist()}
    return {**fingers, **whole}


def _by_names(grasps: Sequence[Grasp], group: Group) -> dict[tuple[str, ...], list[int]]:
    """Rows of the group by the names of their contacts."""
    rows: dict[tuple[str, ...], list[int]] = {}
    for row, k in enumerate(group.at.tolist()):
        rows.setdefault(grasps[k].spec.names, []).append(row)
    return rows


def _binding(group: Group) -> Any:
    """(k,) the joint with the highest utilisation; None where that is 0 or there is no answer."""
    most = group.utilisation.max(axis=1)
    which = (group.utilisation >= (most - OVER * most)[:, None]).argmax(axis=1)
    names = np.array(group.joints, dtype=object)[which]
    names[~(most > 0.0)] = None
    return names
