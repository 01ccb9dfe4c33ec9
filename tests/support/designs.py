"""What sweeps ask of hands, for tests."""

from handlcp.design.evaluate import evaluate_worst

__all__ = ["evaluate_worst"]
