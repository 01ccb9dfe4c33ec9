"""Doors into briefs, evaluations, reports, and numbers of a hand by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from handlcp.design import evaluate as _evaluating
from handlcp.studies import perturbation as _varied
from handlcp.viz.report import report as _reporting


def evaluated_by(monkeypatch: pytest.MonkeyPatch, evaluate: Callable[..., Any]) -> None:
    """`handlcp evaluate` asks this, in place of the search."""
    monkeypatch.setattr(_evaluating, "evaluate", evaluate)


def reported_by(monkeypatch: pytest.MonkeyPatch, evaluate: Callable[..., Any]) -> None:
    """`hl.report` asks this, in place of the search."""
    monkeypatch.setattr(_reporting, "evaluate", evaluate)


def varied_by(monkeypatch: pytest.MonkeyPatch, vary: Callable[..., Any]) -> None:
    """Derivatives by a number are of what this makes, in place of grasps."""
    monkeypatch.setattr(_varied, "vary_grasp", vary)
