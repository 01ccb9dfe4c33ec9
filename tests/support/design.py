"""Doors into briefs, evaluations, reports, and numbers of a hand by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from handlcp.contact.friction import as_law
from handlcp.design import evaluate as _evaluating
from handlcp.design.brief_file import BriefTables
from handlcp.design.evaluation import NOT_FOUND, REQUIREMENT_UNITS, ObjectCase, parse_requirement
from handlcp.design.sweep.same import digest
from handlcp.hand.vary.vary import hand_number, hand_numbers, number_unit
from handlcp.studies import perturbation as _varied
from handlcp.viz.picture.figure import draw_comparable_pictures
from handlcp.viz.report import report as _reporting
from handlcp.viz.report.report import compare_hands, describe_better_hands, describe_brief, mark_best

__all__ = [
    "NOT_FOUND", "REQUIREMENT_UNITS", "BriefTables", "ObjectCase", "as_law", "compare_hands", "describe_better_hands",
    "describe_brief", "digest", "draw_comparable_pictures", "evaluated_by", "hand_number", "hand_numbers", "mark_best",
    "number_unit", "parse_requirement", "reported_by", "varied_by",
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
