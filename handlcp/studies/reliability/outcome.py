"""`SampleOutcomes`: what becomes of samples: held or not, within the torque limits or not, and by how much.

margin = 1 - the larger of  Σ|f_T| / Σ μ f_N  over all contacts with friction,  and  max |τ| / τ_max

The first is the share of all friction that is used: 1 where every contact slides. The margin is below 0 where a joint
is over its limit. It is NaN where it is not known that anything holds the object.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.contact.friction import Pyramid, as_section
from handlcp.grasp import GraspSolution, solve_many
from handlcp.grasp.batch.grasp_batch import solve_rows
from handlcp.grasp.batch.solutions import shift_twists
from handlcp.grasp.failure.failure_mode import is_exceeded
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
from handlcp.grasp.solve.compiled_answer import CompiledAnswer, get_compiled_kind
from handlcp.grasp.verdict.check import judge_grasp
from handlcp.grasp.verify.contact_state import GLIDING, SLIDING, STICKING
from handlcp.lcp import Status
from handlcp.studies.reliability.sample_placer import PlacedSample, SampleArrays, SamplePlacer

SOLVE, CHECK = "solve", "check"
OUTCOME_WORDS = (HELD, OVER_LIMIT, NOT_HELD, UNDECIDED)
HELD_CODE, OVER_LIMIT_CODE, NOT_HELD_CODE, UNDECIDED_CODE = range(4)


@dataclass(frozen=True, slots=True)
class SampleOutcomes:
    """What has become of m samples.

    codes (m,) : the word of each, as its number in `OUTCOME_WORDS`.
    margin (m,) : what is left of friction or torque, whichever is less, as a share; NaN where it is not known to hold.
    again (m,) : which samples the solver's first stage left open, and were solved in full.
    unplaced (m,) : which are no grasp that could be judged; they are UNDECIDED.
    far (m,) : which move so far that one solve says nothing (`is_beyond_small_motions`); they are UNDECIDED.
    """

    codes: Ints
    margin: Array
    again: Bools
    unplaced: Bools
    far: Bools


def solve_samples(
    placer: SamplePlacer, values: Array, faces: int | str | Pyramid, workers: int, decide: int
) -> SampleOutcomes:
    """Of samples with values (m, d), by one certified solve each. decide : how many of those that the first stage
    leaves are solved in full.
    """
    arrays, m = placer.make_sample_arrays(values), len(values)
    placed: Bools = np.asarray(~arrays.unplaceable.any(axis=1))
    same_kind = bool(((arrays.mu > 0.0) == (placer.grasp.scene.mu > 0.0)).all())
    if placer.has_row_form and same_kind and not arrays.samples.remade:
        codes, margin, far, look = _solve_rows(placer, arrays, faces, workers)
    else:
        codes, margin, far, look = np.zeros(m, np.int64), np.full(m, np.nan), np.zeros(m, bool), np.ones(m, bool)
    if (some := np.flatnonzero(look & placed)).size:
        codes[some], margin[some], far[some] = _solve_grasps(placer, arrays, some, faces, workers, proof=False)
    far &= placed
    codes[~placed | far], margin[~placed | far] = UNDECIDED_CODE, np.nan
    again = np.zeros(m, bool)
    chosen = np.flatnonzero((codes == UNDECIDED_CODE) & placed & ~far)[:decide]
    if chosen.size:
        codes[chosen], margin[chosen], far[chosen] = _solve_grasps(placer, arrays, chosen, faces, workers, proof=True)
        codes[far], margin[far] = UNDECIDED_CODE, np.nan
        again[chosen] = True
    return SampleOutcomes(codes, margin, again, ~placed, far)


def _solve_rows(
    placer: SamplePlacer, arrays: SampleArrays, faces: int | str | Pyramid, workers: int
) -> tuple[Ints, Array, Bools, Bools]:
    """Codes (m,) and margins (m,) by the solver's first stage, of scenes as rows; of which answers the motions are too
    large; and which samples have to be looked at as grasps, since an answer leaves something free.
    """
    scene, mu = placer.grasp.scene, arrays.mu
    section = as_section(faces, planar=scene.kind.planar)
    kind, m, n = get_compiled_kind(scene, section), len(mu), scene.n
    found = solve_rows(placer.make_rows(arrays, kind, section.share), kind, workers)
    held, forces = found.passes, found.components[:, : 3 * n]
    codes = np.where(found.escapes, NOT_HELD_CODE, UNDECIDED_CODE)
    most = np.zeros(m)
    if arrays.joints is not None and (mechanism := placer.spec.mechanism) is not None:
        torque = (forces[:, None] @ arrays.joints.jacobian)[:, 0] + arrays.joints.weight
        most = np.nan_to_num(abs(torque) / mechanism.limits).max(axis=1, initial=0.0)
    codes[held] = np.where(is_exceeded(most[held]), OVER_LIMIT_CODE, HELD_CODE)
    x, y, z = forces.reshape(m, n, 3).transpose(2, 0, 1)
    tangential, limit = (np.hypot(x, y) * (mu > 0.0)).sum(axis=1), (mu * z).sum(axis=1)
    used = np.divide(tangential, limit, out=np.zeros(m), where=limit > 0.0)
    margin = np.where(held, 1.0 - np.maximum(used, most), np.nan)
    return codes, margin, held & _are_too_far(placer, arrays, found), held & ~found.is_unique


def _are_too_far(placer: SamplePlacer, arrays: SampleArrays, found: CompiledAnswer) -> Bools:
    """(m,) whether motions are too large for one solve, as `solution_motions` says it of a solution."""
    spec, n, k = placer.spec, arrays.mu.shape[1], placer.spec.n - placer.grasp.scene.environment
    twist, centre, motion, states = found.twist, found.centre, found.motion, found.states
    offset = placer.total_offsets(arrays)[:, 2::3]
    size = np.sqrt(((arrays.positions - centre[:, None]) ** 2).sum(axis=2).mean(axis=1))
    turn, shift = np.linalg.norm(twist[:, 3:], axis=1), shift_twists(twist, spec.reference - centre)[:, :3]
    move = np.maximum(np.linalg.norm(shift, axis=1), turn * size)
    slip = np.linalg.norm(motion.reshape(-1, n, 3)[:, :, :2], axis=2).max(axis=1)
    share = force_error_share(turn, move, slip, -offset.min(axis=1, initial=0.0), size)
    sticks, slides = states == STICKING, (states == SLIDING) | (states == GLIDING)
    adrift = is_adrift(offset[:, :k], sticks[:, :k], slides[:, :k], arrays.mu[:, :k])
    return np.asarray(is_beyond_small_motions(share, adrift))


def _solve_grasps(
    placer: SamplePlacer, arrays: SampleArrays, some: Ints, faces: int | str | Pyramid, workers: int, proof: bool
) -> tuple[Ints, Array, Bools]:
    """Codes and margins of some samples, which are made one by one, and which motions are too large."""
    found = solve_many([placer.make_grasp(arrays, int(k)) for k in some], faces, workers=workers, proof=proof)
    none = np.isin(found.status, (Status.NOT_HOLDABLE.name, Status.NO_EQUILIBRIUM.name))
    codes = np.where(none, NOT_HELD_CODE, UNDECIDED_CODE)
    margin, far = np.full(len(some), np.nan), np.zeros(len(some), bool)
    for k in np.flatnonzero(found.held).tolist():
        solution = found[k]
        codes[k] = OVER_LIMIT_CODE if is_exceeded(_largest_utilisation(solution)) else HELD_CODE
        margin[k], far[k] = solution_margin(solution), solution_motions(solution).too_large
    return codes, margin, far


def check_samples(samples: Sequence[PlacedSample], faces: int | str | Pyramid) -> SampleOutcomes:
    """By `Grasp.check` each, without its advice: squeezed, then loaded, contacts followed."""
    m = len(samples)
    codes, margin = np.full(m, UNDECIDED_CODE), np.full(m, np.nan)
    again, unplaced, far = np.zeros((3, m), bool)
    for k, (grasp, why_not) in enumerate(samples):
        if why_not is not None:
            unplaced[k] = True
            continue
        section = as_section(faces, planar=grasp.scene.kind.planar)
        one = grasp.solve(faces, throw=False, proof=False)
        verdict = judge_grasp(grasp.spec, grasp.scene, section, ("squeeze", "load"), one)
        codes[k], path = OUTCOME_WORDS.index(verdict.word), verdict.loading
        end = one if path is None else path.solution if path.in_place else None
        if end is not None and end.held:
            margin[k] = solution_margin(end)
    return SampleOutcomes(codes, margin, again, unplaced, far)


def solution_margin(solution: GraspSolution) -> float:
    """The margin of a solution: what is left of friction or torque, whichever is less, as a share."""
    scene = solution.scene
    assert scene is not None  # every solution that is looked at here was made from one
    slack = friction_margin(scene, solution.forces, getattr(solution, "torsion", None))
    forces = scene.forces_to_law_axes(np.append(solution.forces, np.zeros(len(scene.soft))))
    limit = float((scene.mu * forces[2 : 3 * scene.n : 3]).sum())
    used = 0.0 if limit <= 0.0 else 1.0 - float(np.nansum(slack)) / limit
    return 1.0 - max(used, _largest_utilisation(solution))


def _largest_utilisation(solution: GraspSolution) -> float:
    """The largest utilisation of any joint; 0 without a hand."""
    check = getattr(solution, "torque_check", None)
    return 0.0 if check is None else float(np.nan_to_num(check.utilisation).max(initial=0.0))
