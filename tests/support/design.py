"""Doors into briefs, evaluations, reports, and numbers of a hand by name."""

from handlcp.design import evaluate as _evaluating
from handlcp.studies import perturbation as _varied
from handlcp.viz.report import report as _reporting


def evaluated_by(monkeypatch, evaluate):
    """`handlcp evaluate` asks this, in place of the search."""
    monkeypatch.setattr(_evaluating, "evaluate", evaluate)


def reported_by(monkeypatch, evaluate):
    """`hl.report` asks this, in place of the search."""
    monkeypatch.setattr(_reporting, "evaluate", evaluate)


def varied_by(monkeypatch, vary):
    """Derivatives by a number are of what this makes, in place of grasps."""
    monkeypatch.setattr(_varied, "vary_grasp", vary)
