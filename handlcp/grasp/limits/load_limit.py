"""`Grasp.load_limit`: which geometry, and what is asked."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.asked import is_followed, load_of, tolerance
from handlcp.grasp.limits.fixed import fixed_limit
from handlcp.grasp.limits.followed.answers import followed_limit
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.sensitivity.paths import PathSensitivity

__all__ = ["load_limit"]


def load_limit(
    spec: GraspSpec, section: Section, wrench: Any, geometry: Any, motion: Any, turn: Any
) -> LoadLimit:  # fmt: skip
    """See `Grasp.load_limit`."""
    limit = followed_limit if is_followed(spec, geometry) else fixed_limit
    asked, most = load_of(spec, wrench), (tolerance("motion", motion), tolerance("turn", turn))

    def factor(varied: GraspSpec) -> dict[str, Array]:
        load = read_only(asked + varied.wrench - spec.wrench)
        own = varied.replace(wrench=spec.wrench, asked=varied.asked)
        return {"factor": np.array(limit(own, section, load, most).factor)}

    return replace(limit(spec, section, asked, most), differences=lambda: PathSensitivity(spec, factor))
