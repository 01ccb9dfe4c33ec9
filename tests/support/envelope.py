"""Envelopes whose paths find no limit: what then is told."""

from types import SimpleNamespace

import numpy as np

from handlcp.studies.envelope import question as ask


def without_limits(monkeypatch):
    """From now on, no path of an envelope finds where it ends."""

    def endless(spec, section, wrenches, *asked):
        none = np.full(len(wrenches), np.nan)
        return SimpleNamespace(factors=np.full(len(wrenches), np.inf), binds=((),) * len(wrenches), accuracy=none)

    monkeypatch.setattr(ask, "limits_of", endless)
