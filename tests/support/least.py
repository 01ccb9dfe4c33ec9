"""A door into the search for a least value: loadings that end differently with a larger value."""

from handlcp.grasp.design.required_value import ChangedGrasp


def lost_above(monkeypatch, most):
    """Loadings with a larger value end as those with none do."""
    path = ChangedGrasp.path
    monkeypatch.setattr(ChangedGrasp, "path", lambda self, x: path(self, 0.0 if x > most else x))
