"""Doors into the studies: what is left out and planned, the paper's settings, limits in many directions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.contact.friction import as_section
from handlcp.grasp.limits.directions import limits_of
from handlcp.studies.accuracy.cost import variants
from handlcp.studies.accuracy.methods import settings


def left_out(grasp: Any) -> dict[str, Any]:
    """The grasp without each effect that the study of accuracy leaves out, by the effect's name."""
    return {name: without for name, _, without in variants(grasp)}


def planned_rows(methods: Iterable[Any], faces: tuple[int, ...], tolerances: tuple[float, ...]) -> int:
    """How many rows a study of these methods has in a scene with pyramids, where nobody asks for faces or tolerances
    and these are the study's own.
    """
    return sum(map(len, settings(tuple(methods), (faces, False), (tolerances, False), True).values()))


def limits_of_directions(grasp: hl.Grasp, wrenches: Any, faces: Any) -> np.ndarray:
    """(m,) factors on these wrenches (m, 6), contacts fixed: what an envelope asks for."""
    section = as_section(faces, planar=grasp.scene.kind.planar)
    return np.asarray(limits_of(grasp.spec, section, wrenches, "fixed", None, None).factors)
