"""`SampleOutcomes`: what becomes of samples: held or not, within the torque limits or not, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.contact.friction import Pyramid, as_section
from handlcp.grasp import GraspSolution, Solutions, solve_many
from handlcp.grasp.batch.first_stage import STATUSES, FirstStageAnswers, solve_rows
from handlcp.grasp.batch.solutions import shift_twists
from handlcp.grasp.failure.failure_mode import is_exceeded
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solution.verdict import (
    HELD,
    NOT_HELD,
    OVER_LIMIT,
    UNDECIDED,
    force_error_share,
    friction_margin,
    is_adrift,
    is_beyond_small_motions,
    solution_motions,
)
from handlcp.grasp.solve.compiled_answer import get_compiled_kind
from handlcp.grasp.verdict.check import judge_grasp
from handlcp.grasp.verify.contact_state import GLIDING, SLIDING, STICKING
from handlcp.lcp import Status
from handlcp.studies.reliability.sample_arrays import SampleArrays
from handlcp.studies.reliability.sample_placer import SamplePlacer

# ----------------------------------------------------------------
# What becomes of many samples: held, over a torque limit, not held, or undecided; and by how much.
#
# margin = 1 - the larger of  Σ|f_T| / Σ μ f_N  over all contacts with friction,  and  max |τ| / τ_max
#
# The first is the share of all friction that is used: 1 where every contact slides. The margin is below 0 where a joint
# is over its limit, and there is none (NaN) where nothing holds the object.

SOLVE, CHECK = "solve", "check"
OUTCOME_WORDS = (HELD, OVER_LIMIT, NOT_HELD, UNDECIDED)  # by their codes


@dataclass(frozen=True, slots=True)
class SampleOutcomes:
    """What has become of m samples.

    codes (m,) : the word of each, as its number in `OUTCOME_WORDS`.
    margin (m,) : what is left of friction or torque, whichever is less, as a share; NaN where nothing holds.
    again (m,) : which samples the solver's first stage left open, and were solved in full.
    unplaced (m,) : which are no grasp that could be judged; they are UNDECIDED.
    far (m,) : which move so far that one solve says nothing (`is_beyond_small_motions`); they are UNDECIDED.
    """

    codes: Ints
    margin: Array
    again: Bools
    unplaced: Bools
    far: Bools


def join_outcomes(parts: Sequence[SampleOutcomes]) -> SampleOutcomes:
    """The outcomes of several runs of samples, one after the other."""
    names = [one.name for one in fields(SampleOutcomes)]
    return SampleOutcomes(*[np.concatenate([getattr(p, name) for p in parts]) for name in names])


def fill_unplaced(found: SampleOutcomes, placed: Bools) -> SampleOutcomes:
    """Outcomes of all samples, where `found` has those that are grasps. placed (m,) : which ones these are."""
    if placed.all():
        return found
    m = len(placed)
    codes, margin, again, far = np.full(m, OUTCOME_WORDS.index(UNDECIDED)), np.full(m, np.nan), *np.zeros((2, m), bool)
    codes[placed], margin[placed], again[placed], far[placed] = found.codes, found.margin, found.again, found.far
    return SampleOutcomes(codes, margin, again, ~placed, far)


def solve_samples(
    placer: SamplePlacer, values: Array, faces: int | str | Pyramid, workers: int, decide: int
) -> SampleOutcomes:
    """Of samples with values (m, d), by one certified solve each. decide : how many of those that the first stage
    leaves are solved in full.
    """
    arrays = placer.make_sample_arrays(values)
    placed: Bools = np.asarray(~arrays.past_edge.any(axis=1))
    same_kind = bool(((arrays.mu > 0.0) == (placer.grasp.scene.mu > 0.0)).all())
    again, far = np.zeros((2, len(values)), bool)
    codes, margin, look = np.zeros(len(values), np.int64), np.full(len(values), np.nan), np.ones(len(values), bool)
    if placer.has_row_form and same_kind and not arrays.samples.remade:
        codes, margin, far, look = _solve_rows(placer, arrays, faces, workers)
    if (some := np.flatnonzero(look & placed)).size:
        codes[some], margin[some], far[some] = _solve_grasps(placer, arrays, some, faces, workers, proof=False)
    far &= placed
    codes[~placed | far], margin[~placed | far] = OUTCOME_WORDS.index(UNDECIDED), np.nan
    chosen = np.flatnonzero((codes == OUTCOME_WORDS.index(UNDECIDED)) & placed & ~far)[:decide]
    if chosen.size:
        codes[chosen], margin[chosen], far[chosen] = _solve_grasps(placer, arrays, chosen, faces, workers, proof=True)
        codes[far], margin[far] = OUTCOME_WORDS.index(UNDECIDED), np.nan
        again[chosen] = True
    return SampleOutcomes(codes, margin, again, ~placed, far)


def _solve_rows(
    placer: SamplePlacer, arrays: SampleArrays, faces: int | str | Pyramid, workers: int
) -> tuple[Ints, Array, Bools, Bools]:
    """Codes (m,) and margins (m,) by the solver's first stage, of scenes as rows; of which answers the motions are too
    large; and which samples have to be looked at as grasps, since an answer leaves something free.
    """
    scene = placer.grasp.scene
    section = as_section(faces, planar=scene.kind.planar)
    kind, m, n = get_compiled_kind(scene, section), len(arrays.mu), scene.n
    rows = solve_rows(placer.make_rows(arrays, kind, section.share), kind, workers)
    found = FirstStageAnswers(kind, np.arange(m), rows)
    held = found.is_certified
    forces = found.forces_and_twists(found.at)[0][:, : 3 * n]
    codes = np.where(
        found.status == STATUSES.index(Status.UNDECIDED), OUTCOME_WORDS.index(UNDECIDED), OUTCOME_WORDS.index(NOT_HELD)
    )
    most = np.zeros(m)
    if arrays.joints is not None and (mechanism := placer.spec.mechanism) is not None:
        torque = (forces[:, None] @ arrays.joints.jacobian)[:, 0] + arrays.joints.weight
        most = np.nan_to_num(abs(torque) / mechanism.limits).max(axis=1, initial=0.0)
    codes[held] = np.where(is_exceeded(most[held]), OUTCOME_WORDS.index(OVER_LIMIT), OUTCOME_WORDS.index(HELD))
    margin = np.where(held, 1.0 - np.maximum(_friction_use(arrays.mu, forces.reshape(m, n, 3)), most), np.nan)
    return codes, margin, held & _are_too_far(placer, arrays, found), held & ~found.is_unique


def _are_too_far(placer: SamplePlacer, arrays: SampleArrays, found: FirstStageAnswers) -> Bools:
    """(m,) whether motions are too large for one solve, as `motions` says it of a solution."""
    spec, n, k = placer.spec, arrays.mu.shape[1], placer.spec.n - placer.grasp.scene.environment
    twist, centre = found.forces_and_twists(found.at)[1:]
    motion, states = found.motions_and_states
    offset = placer.total_offsets(arrays)[:, 2::3]
    size = np.sqrt(((arrays.positions - centre[:, None]) ** 2).sum(axis=2).mean(axis=1))
    turn, shift = np.linalg.norm(twist[:, 3:], axis=1), shift_twists(twist, spec.reference - centre)[:, :3]
    move = np.maximum(np.linalg.norm(shift, axis=1), turn * size)
    slip = np.linalg.norm(motion.reshape(-1, n, 3)[:, :, :2], axis=2).max(axis=1)
    share = force_error_share(turn, move, slip, -offset.min(axis=1, initial=0.0), size)
    sticks, slides = states == STICKING, (states == SLIDING) | (states == GLIDING)
    return np.asarray(
        is_beyond_small_motions(share, is_adrift(offset[:, :k], sticks[:, :k], slides[:, :k], arrays.mu[:, :k]))
    )


def _solve_grasps(
    placer: SamplePlacer, arrays: SampleArrays, some: Ints, faces: int | str | Pyramid, workers: int, proof: bool
) -> tuple[Ints, Array, Bools]:
    """Codes and margins of some samples, which are made one by one, and which motions are too large."""
    grasps = [placer.make_grasp(arrays, int(k)) for k in some]
    found = solve_many(grasps, faces, workers=workers, proof=proof)
    return (
        _solution_codes(found),
        _solution_margins(grasps, found),
        np.array([s.held and solution_motions(s).too_large for s in found]),
    )


def check_samples(grasps: Sequence[Grasp], faces: int | str | Pyramid) -> SampleOutcomes:
    """By `Grasp.check` each, without its advice: squeezed, then loaded, contacts followed."""
    codes, margin = np.empty(len(grasps), np.int64), np.full(len(grasps), np.nan)
    for k, g in enumerate(grasps):
        section = as_section(faces, planar=g.scene.kind.planar)
        one = g.solve(faces, throw=False, proof=False)
        verdict = judge_grasp(g.spec, g.scene, section, ("squeeze", "load"), one)
        codes[k] = OUTCOME_WORDS.index(verdict.word)
        path = verdict.loading
        end = one if path is None else path.solution if path.held else None
        if end is not None and end.held:
            margin[k] = solution_margin(end)
    return SampleOutcomes(codes, margin, *np.zeros((3, len(grasps)), bool))


def solution_margin(solution: GraspSolution) -> float:
    """The margin of a solution: what is left of friction or torque, whichever is less, as a share."""
    scene = solution.scene
    assert scene is not None  # every solution that is looked at here was made from one
    slack = friction_margin(scene, solution.forces, getattr(solution, "torsion", None))
    limit = float((scene.mu * scene.forces_to_law_axes(_pad_forces(scene, solution.forces))[2 : 3 * scene.n : 3]).sum())
    used = 0.0 if limit <= 0.0 else 1.0 - float(np.nansum(slack)) / limit
    check = getattr(solution, "torque_check", None)
    return 1.0 - max(used, 0.0 if check is None else float(check.utilisation.max(initial=0.0)))


def _pad_forces(scene: Any, forces: Array) -> Array:
    return np.append(forces, np.zeros(len(scene.soft)))


def _solution_codes(found: Solutions) -> Ints:
    """The code (m,) of each solution; one that is held is over a limit where a joint is."""
    codes = np.full(len(found), OUTCOME_WORDS.index(UNDECIDED))
    names = found.status
    none = (names == Status.NOT_HOLDABLE.name) | (names == Status.NO_EQUILIBRIUM.name)
    codes[none] = OUTCOME_WORDS.index(NOT_HELD)
    codes[found.held] = OUTCOME_WORDS.index(HELD)
    codes[found.held & is_exceeded(_largest_utilisation(found))] = OUTCOME_WORDS.index(OVER_LIMIT)
    return codes


def _largest_utilisation(found: Solutions) -> Array:
    """(m,) the largest utilisation of any joint; 0 without a hand or an answer."""
    if not len(found) or getattr(found[0], "torque_check", None) is None:
        return np.zeros(len(found))
    return np.asarray(np.nan_to_num(found.utilisation).max(axis=1, initial=0.0))


def _solution_margins(grasps: Sequence[Grasp], found: Solutions) -> Array:
    """The margin (m,) of each solution; NaN where nothing is held."""
    if any(g.scene.scale is not None for g in grasps):  # forces in coordinates of their own: one by one
        return np.array([solution_margin(s) if s.held else np.nan for s in found])
    forces, mu = found.forces, np.array([g.scene.mu for g in grasps])
    return np.where(found.held, 1.0 - np.maximum(_friction_use(mu, forces), _largest_utilisation(found)), np.nan)


def _friction_use(mu: Array, forces: Array) -> Array:
    """(m,) the share of all friction that forces (m, n, 3) use, with coefficients (m, n)."""
    limit = (mu * forces[:, :, 2]).sum(axis=1)
    tangential = (np.hypot(forces[:, :, 0], forces[:, :, 1]) * (mu > 0.0)).sum(axis=1)
    return np.asarray(np.divide(tangential, limit, out=np.zeros(len(mu)), where=limit > 0.0))
