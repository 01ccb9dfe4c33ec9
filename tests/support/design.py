"""Doors into briefs, evaluations, reports, and numbers of a hand by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from handlcp.contact.friction import as_law
from handlcp.design import evaluate as _evaluating
from handlcp.design.brief_file import BriefTables
from handlcp.design.evaluation import NOT_FOUND, ObjectCase
from handlcp.design.require import UNITS, read
from handlcp.design.sweep.same import digest
from handlcp.hand.vary.vary import hand_number, hand_numbers, number_unit
from handlcp.show.picture.figure import alike
from handlcp.show.report import report as _reporting
from handlcp.show.report.told import asked, best_of, better, differences
from handlcp.study import varied as _varied

__all__ = [
    "NOT_FOUND",
    "UNITS",
    "BriefTables",
    "ObjectCase",
    "alike",
    "as_law",
    "asked",
    "best_of",
    "better",
    "differences",
    "digest",
    "evaluated_by",
    "hand_number",
    "hand_numbers",
    "number_unit",
    "read",
    "reported_by",
    "varied_by",
]  # fmt: skip


def evaluated_by(monkeypatch: pytest.MonkeyPatch, evaluate: Callable[..., Any]) -> None:
    """`handlcp evaluate` asks this, in place of the search."""
    monkeypatch.setattr(_evaluating, "evaluate", evaluate)


def reported_by(monkeypatch: pytest.MonkeyPatch, evaluate: Callable[..., Any]) -> None:
    """`hl.report` asks this, in place of the search."""
    monkeypatch.setattr(_reporting, "evaluate", evaluate)


def varied_by(monkeypatch: pytest.MonkeyPatch, vary: Callable[..., Any]) -> None:
    """Derivatives by a number are of what this makes, in place of grasps."""
    monkeypatch.setattr(_varied, "vary_grasp", vary)
