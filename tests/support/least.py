"""Doors into the search for a least value: loadings that end differently with few steps, or with a larger value."""

from handlcp.grasp.design.required_value import ChangedGrasp


def believes_less(monkeypatch, share):
    """Loadings in few steps hold with this share of what it takes, as those do that miss what happens in between."""
    holds = ChangedGrasp.is_held
    monkeypatch.setattr(ChangedGrasp, "is_held", lambda self, x: holds(self, x / share))


def lost_above(monkeypatch, most):
    """Loadings with a larger value end as those with none do."""
    path = ChangedGrasp.path
    monkeypatch.setattr(ChangedGrasp, "path", lambda self, x: path(self, 0.0 if x > most else x))
