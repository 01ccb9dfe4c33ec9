"""What tests put in the place of something inside, one function for each: nobody else names such a target.

Each takes pytest's `monkeypatch`, so that what it puts there is gone after the test.
"""

from __future__ import annotations

from typing import Any

import pytest

from handlcp.grasp.analysis.required_value import required_preload
from handlcp.grasp.model import effect as _effect
from handlcp.grasp.path.follow import geometry_of
from handlcp.grasp.solve import compiled_answer as _first
from tests.support.clocks import Ticking, a_quarter_less
from tests.support.steps import told

Patch = pytest.MonkeyPatch


# ---------------------------------------------------------------- pictures
def coarse_pictures(patch):
    """Pictures of grasps have so few dots that they are drawn at once; texts and lines stay where they are."""
    patch.setattr("handlcp.viz.picture.figure.PICTURE_DPI", 30)


# ---------------------------------------------------------------- many grasps
def chunks_of(patch, count):
    """`solve_many` hands out so many grasps at a time."""
    patch.setattr("handlcp.grasp.batch.grasp_batch._GRASPS_PER_TASK", count)


def shards_of(patch, count):
    """`solve_many` sends an executor so many grasps at a time."""
    patch.setattr("handlcp.grasp.batch.solve_many._FIRST_SHARD_GRASPS", (count, count))
    patch.setattr("handlcp.grasp.batch.solve_many._MAX_LATER_GRASPS", count)


def everything_to_processes(patch):
    """`solve_many` gives whatever the first stage doesn't solve to processes, however little there is of it."""
    for name in ("_TRIAL_SECONDS", "_MIN_PROCESS_SECONDS"):
        patch.setattr(f"handlcp.grasp.batch.solve_many.{name}", 0.0)


# ---------------------------------------------------------------- objects
def meshes_of_at_most(patch, count):
    """Larger meshes than of so many triangles are refused."""
    patch.setattr("handlcp.geometry.mesh.MAX_TRIANGLES", count)


def contacts_take_long(patch):
    """To a payload no contacts count as known in closed form."""

    def slow(spec, geometry):
        found = geometry_of(spec, geometry)
        found.quick = False
        return found

    patch.setattr("handlcp.studies.payload.largest_mass.geometry_of", slow)


# ---------------------------------------------------------------- stages of a solve
def nothing_is_eliminated(patch):
    """No free block counts as well enough conditioned to be eliminated."""
    patch.setattr("handlcp.lcp.contact_problem.MIN_ELIMINATION_RCOND", 2.0)


def no_newton_on_cones(patch, solver):
    """`solve(accuracy=...)` looks for the equilibrium on the cone with this solver."""
    patch.setattr("handlcp.grasp.analysis.solve_to_accuracy._NEWTON", solver)


def no_solve_takes_more_than(patch, solves):
    """A grasp whose flexibility depends on its forces is solved so many times at most."""
    patch.setattr("handlcp.grasp.solve.solve_spec._MAX_SOLVES", solves)


def watched_first_stage(patch):
    """What the first stage finds while shares are measured: steps in `iterations`, forces (n, 3) in `forces`."""
    seen: list[Any] = []

    def watched(*arguments):
        found = _first.solve_scene(*arguments)
        seen.append(told(found))
        return found

    patch.setattr("handlcp.grasp.analysis.explanation.solve_scene", watched)
    return seen


def advice_is_watched(patch):
    """Each time that somebody asks for the squeeze that would hold."""
    asked: list[Any] = []

    def watched(*arguments, **named):
        asked.append(arguments)
        return required_preload(*arguments, **named)

    patch.setattr("handlcp.grasp.analysis.required_value.required_preload", watched)
    return asked


# ---------------------------------------------------------------- clocks
def shares_of_a_quarter(patch):
    """`explain(measure=True)` finds that every effect takes a quarter of a solve of two seconds."""
    patch.setattr("handlcp.grasp.analysis.explanation.best_times", a_quarter_less)


def ticks_of_studies(patch, tick):
    """The study of accuracy has a clock each look at which takes so long [s]: the same always fits its budget."""
    clock = Ticking(tick)
    patch.setattr("handlcp.studies.accuracy.cost.time", clock)
    patch.setattr("handlcp.studies.accuracy.measure.time", clock)


def ticks_of_equilibria(patch, tick=2e-3):
    """`grasp.equilibria` looks at its clock after every candidate, and that takes so long [s]: its two seconds are
    enough for a thousand, however busy the machine is.
    """
    clock = Ticking(tick)
    patch.setattr("handlcp.grasp.analysis.equilibria.time", clock)


# ---------------------------------------------------------------- studies
def another_effect(patch, kind):
    """The catalogue has one effect more."""
    key = kind.__module__, kind.__qualname__
    _effect._KINDS.pop(key)  # it joined when it was made; put there by the patch, it leaves with the test
    patch.setitem(_effect._KINDS, key, kind)


def costs_of_effects(patch, costs):
    """The command line has its costs of effects from here."""
    patch.setattr("handlcp.studies.effect_catalogue.costs", costs)


def paper_report(patch, made):
    """The paper's command prints this report."""
    patch.setattr("handlcp.studies.paper.run", made)


def without_module(patch, name):
    """As if a package that is optional were not installed."""
    import builtins

    real = builtins.__import__

    def missing(module, *arguments, **words):
        if module.startswith(name):
            raise ImportError(module)
        return real(module, *arguments, **words)

    patch.setattr(builtins, "__import__", missing)
