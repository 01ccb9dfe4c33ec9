"""Doors into the studies: what is left out and planned, samples and their chances, paths that find no limit."""

from types import SimpleNamespace

import numpy as np

from handlcp.studies.accuracy.cost import variants
from handlcp.studies.accuracy.methods import settings
from handlcp.studies.envelope import question as ask
from handlcp.studies.reliability import run
from handlcp.studies.reliability.chance import estimate_chance
from handlcp.studies.reliability.sample_placer import SamplePlacer
from handlcp.studies.reliability.spread import read_spread


def left_out(grasp):
    """The grasp without each effect that the study of accuracy leaves out, by the effect's name."""
    return {name: without for name, _, without in variants(grasp)}


def planned_rows(methods):
    """How many rows a study of these methods has in a scene with pyramids, with faces and tolerances of its own."""
    return sum(map(len, settings(tuple(methods), None, None, True).values()))


def without_limits(monkeypatch):
    """From now on, no path of an envelope finds where it ends."""

    def endless(spec, section, wrenches, *asked):
        none = np.full(len(wrenches), np.nan)
        return SimpleNamespace(factors=np.full(len(wrenches), np.inf), binds=((),) * len(wrenches), accuracy=none)

    monkeypatch.setattr(ask, "limits_of", endless)


# ---------------------------------------------------------------- reliability
def chance(good, blocks, level=0.95):
    """From samples (N,) of which each is known to be good or not."""
    none = np.zeros(len(good), bool)
    return estimate_chance(good, none, none, (none, none), blocks.size, level)


def chance_in_two_looks(good, open_, every, blocks, level=0.95):
    """The same where a first look leaves some open (N,), and every so many of them are looked at again."""
    looked = np.zeros(len(good), bool)
    looked[np.flatnonzero(open_)[::every]] = True
    seen = good & (~open_ | looked)
    none = np.zeros(len(good), bool)
    return estimate_chance(seen, open_ & ~looked, none, (looked, looked & good), blocks.size, level)


def grasp_with(grasp, **values):
    """The grasp of a sample: each parameter at a value, or a mapping of values by name (positions: (x, y))."""
    spread = {p: dict.fromkeys(v, 0.1) if isinstance(v, dict) else 0.1 for p, v in values.items()}
    dimensions = read_spread(grasp, spread)

    def value(d):
        own = values[d.parameter]
        if not isinstance(own, dict):
            return float(own)
        name = next(n for n in own if f" {n}" in d.name)
        return float(own[name][d.index[1]] if d.parameter == "positions" else own[name])

    return SamplePlacer(grasp, dimensions).place_samples(np.array([[value(d) for d in dimensions]]))[0].grasp


def steps_of(monkeypatch, size, seconds):
    """Samples between two looks at the clock, and seconds between two writings of what is done."""
    monkeypatch.setattr(run, "_SAMPLES_PER_SLICE", {"solve": size, "check": size})
    monkeypatch.setattr(run, "_WRITE_INTERVAL", seconds)
