"""Doors into the studies: what is left out and planned, the paper's figures as carried over, its rows and misses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

import handlcp as hl
from handlcp.grasp.friction import as_section
from handlcp.grasp.limits.directions import limits_of
from handlcp.method.accuracy.cost import UNDETERMINED, variants
from handlcp.method.accuracy.methods import settings
from handlcp.method.accuracy.result import CERTIFIED, LOOSE, NOT_RUN, OTHER
from handlcp.method.nsngrk import RES, STEPS
from handlcp.method.paper.data import NUMBERS, PRELOAD, Number, raw
from handlcp.method.paper.misses import Miss, no_equilibrium, search_grasp
from handlcp.method.paper.printed import compatibility, signed_forces
from handlcp.method.paper.render import render
from handlcp.method.paper.report import run_case
from handlcp.method.paper.tables import Mark, mark_of, rows_of

__all__ = [
    "CERTIFIED",
    "LOOSE",
    "NOT_RUN",
    "NUMBERS",
    "OTHER",
    "PRELOAD",
    "RES",
    "STEPS",
    "UNDETERMINED",
    "Mark",
    "Miss",
    "Number",
    "compatibility",
    "left_out",
    "limits_of_directions",
    "mark_of",
    "no_equilibrium",
    "planned_rows",
    "raw",
    "render",
    "rows_of",
    "run_case",
    "search_grasp",
    "signed_forces",
]


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
