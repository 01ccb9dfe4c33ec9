"""`Grasp.load_limit`: which geometry, and what is asked."""

from __future__ import annotations

from typing import Any

from handlcp.grasp.friction import Section
from handlcp.grasp.limits.asked import is_followed, load_of, tolerance
from handlcp.grasp.limits.fixed import fixed_limit
from handlcp.grasp.limits.followed.answers import followed_limit
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["load_limit"]


def load_limit(
    spec: GraspSpec, section: Section, wrench: Any, geometry: Any, motion: Any, turn: Any
) -> LoadLimit:  # fmt: skip
    """See `Grasp.load_limit`."""
    limit = followed_limit if is_followed(spec, geometry) else fixed_limit
    most = (tolerance("motion", motion), tolerance("turn", turn))
    return limit(spec, section, load_of(spec, wrench), most)
