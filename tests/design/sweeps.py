"""Small sweeps for tests: one of real hands, and one whose designs all fail at once, which is bookkeeping alone."""

import json

import pytest

import handlcp as hl

SPACE = {"length": (0.048, 0.052), "stiffness": (3.0, 4.0, "log"), "friction": [0.7, 0.75]}
NO_HANDS = {"x": (0.0, 1.0), "kind": ["a", "b"]}


def make(length, stiffness):
    """Three fingers; below 49 mm nobody can make it."""
    if length < 0.049:
        raise ValueError("too short")
    return hl.finger_hand(3, (length, 0.04), joint_stiffness=stiffness)


def brief(friction):
    """One ball, few placements."""
    return hl.Brief({"ball": hl.Sphere(0.03, mass=0.04)}, friction=friction, tries=3)


def no_hand(x, kind):
    """Fails, with a reason of its own."""
    raise RuntimeError(f"{kind} {x!r}")


def run(out=None, executor="serial", **changed):
    """The sweep of real hands."""
    given = {"sampling": "sobol", "samples": 5, "progress": False, **changed}
    return hl.sweep(make, SPACE, brief, out=out, executor=executor, **given)


def run_without_hands(out, make=no_hand, **changed):
    """The sweep of designs that fail."""
    given = {"sampling": "lhs", "samples": 100, "executor": "serial", "progress": False, "space": NO_HANDS, **changed}
    return hl.sweep(make, brief=hl.Brief(hl.Sphere(0.03)), out=out, **given)


def bits(study):
    """All that its table has."""
    return json.dumps(study.columns)


def stopped_after(out, after):
    """A sweep that Ctrl-C stops; its rows so far."""

    def stop(done, total):
        if done >= after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_without_hands(out, progress=stop)
    return hl.Study.load(out)
