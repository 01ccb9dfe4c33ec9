"""Doors into sweeps: spaces of parameters, which designs start together, tables and journals, main effects."""

from __future__ import annotations

from handlcp.design.main_effects import main_effect
from handlcp.design.space import Space
from handlcp.design.study import not_beaten
from handlcp.design.sweep.cells import MOST, cells_of
from handlcp.design.sweep.journal import beside
from handlcp.design.sweep.study_file import BriefFrom, HandFrom
from handlcp.design.sweep.table import write_table
from handlcp.show.study.axes import parameter

__all__ = [
    "MOST", "BriefFrom", "HandFrom", "Space", "beside", "cells_of", "main_effect", "not_beaten", "parameter",
    "write_table",
]  # fmt: skip
