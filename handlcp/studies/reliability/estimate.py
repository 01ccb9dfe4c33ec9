"""`Reliability`: how sure a grasp is: chances with intervals, counts, the worst sample, and what matters most."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from handlcp import words
from handlcp.check import Array, Ints, check_call, check_integer, check_method_calls, check_number, check_workers
from handlcp.contact.friction import Pyramid, as_section
from handlcp.errors import InputError
from handlcp.grasp import GraspSolution, Verdict
from handlcp.grasp.failure.reason import make_reason
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solution.verdict import solution_motions
from handlcp.progress import Progress
from handlcp.record import Record, make_data_frame
from handlcp.studies.reliability.chance import Chance, Influence, estimate_chance, format_value, rank_influences
from handlcp.studies.reliability.outcome import (
    CHECK,
    NOT_HELD_CODE,
    OUTCOME_WORDS,
    OVER_LIMIT_CODE,
    SOLVE,
    UNDECIDED_CODE,
    SampleOutcomes,
)
from handlcp.studies.reliability.run import (
    MIN_BLOCKS,
    JudgingMethod,
    ResumeFile,
    SobolBlocks,
    make_blocks,
    make_question,
    margin_slopes,
    run_samples,
    sample_values,
)
from handlcp.studies.reliability.sample_placer import HandNumberPlacer, SamplePlacer
from handlcp.studies.reliability.spread import HAND_NUMBER, read_spread
from handlcp.words import TextTable, wrap_text

_MAX_TABLE_ROWS = 8  # of the printed table
_MARGIN_NOTE = "margin: unused share of all friction or of a joint’s torque limit, the smaller"


@dataclass(frozen=True, eq=False)
class Sample(Record):
    """One sample of a reliability, with its grasp, which is solved when that is looked at.

    number : 0 to `samples` - 1. values : by name, SI units. word : "HELD", "OVER LIMIT", "NOT HELD", "UNDECIDED".
    margin : what is left of friction or torque, whichever is less, as a share; NaN where it is not known to hold.
    grasp : with the sample's values. method : how it is judged.
    why_not : why it is UNDECIDED without a look at the grasp, such as a contact past an edge, which then has its
    nominal axes; else None.
    """

    entries = ("number", "values", "word", "margin", "cause")

    number: int
    values: dict[str, float]
    word: str
    margin: float
    grasp: Grasp = field(repr=False)
    method: JudgingMethod = field(repr=False)
    why_not: str | None = None

    @cached_property
    def solution(self) -> GraspSolution:
        """One certified solve, with proof where nothing holds."""
        return self.grasp.solve(self.method.faces, throw=False)

    @cached_property
    def verdict(self) -> Verdict:
        """As the sample was judged: of one solve, or of `grasp.check()`."""
        if self.why_not is not None:
            return Verdict(self.word, (make_reason("unplaced", "decides", why=self.why_not),))
        if self.method.by == "check":
            return self.grasp.check(faces=self.method.faces, solution=self.solution)
        return self.solution.verdict

    @property
    def cause(self) -> str:
        """Why it comes to its word, in one sentence."""
        return self.verdict.text

    def __str__(self) -> str:
        return wrap_text(f"sample {self.number}, {self.word}: {self.cause}", "  ")


@check_method_calls
@dataclass(frozen=True, eq=False)
class Reliability(Record):
    """The answer of `hl.reliability`.

    chance_held : that the grasp holds. chance_within_limits : that it holds with every joint within its torque limit;
    None where no joint has a known limit. counts : samples by word. samples, seed. influences : what matters, the most
    first. outcomes : of each sample.
    """

    entries = (
        "samples", "seed", "judged_by = method.by", "counts", "chance_held", "chance_within_limits", "worst",
        "nearest_failure", "influences",
    )  # fmt: skip

    chance_held: Chance
    chance_within_limits: Chance | None
    counts: dict[str, int]
    influences: tuple[Influence, ...]
    outcomes: SampleOutcomes = field(repr=False)
    blocks: SobolBlocks = field(repr=False)
    placer: SamplePlacer = field(repr=False)
    method: JudgingMethod = field(repr=False)

    @property
    def samples(self) -> int:
        """How many samples there are."""
        return len(self.codes)

    @property
    def codes(self) -> Ints:
        """(m,) the word of each sample, as a number: 0 HELD, 1 OVER LIMIT, 2 NOT HELD, 3 UNDECIDED."""
        return self.outcomes.codes

    @property
    def margin(self) -> Array:
        """(m,) 1 - the larger of all friction used and the largest torque over its limit; NaN where it is not known to
        hold.
        """
        return self.outcomes.margin

    @property
    def seed(self) -> int:
        """The seed of the points; the same seed gives the same samples."""
        return self.blocks.seed

    @property
    def names(self) -> tuple[str, ...]:
        """Of the values that vary, in the order of `values`."""
        return tuple([d.name for d in self.placer.dimensions])

    @cached_property
    def values(self) -> Array:
        """(m, d) of every sample, SI units."""
        return sample_values(self.placer.dimensions, self.blocks.points(0, self.samples))

    def sample(self, k: int) -> Sample:
        """Sample k, 0 to `samples` - 1. Raises InputError."""
        k = check_integer("k", k, 0, self.samples - 1)
        row = sample_values(self.placer.dimensions, self.blocks.points(k, k + 1))[0]
        values = dict(zip(self.names, row.tolist(), strict=True))
        word = OUTCOME_WORDS[int(self.codes[k])]
        (placed,) = self.placer.place_samples(row[None])
        return Sample(k, values, word, float(self.margin[k]), placed.grasp, self.method, placed.why_not)

    @cached_property
    def why_not(self) -> dict[int, str]:
        """Why samples are UNDECIDED without a look at their grasp, by number, such as a contact past an edge."""
        some = np.flatnonzero(self.outcomes.unplaced)
        if not some.size:
            return {}
        unplaceable = self.placer.make_sample_arrays(self.values[some]).unplaceable
        return {int(k): str(self.placer.why_unplaced(one)) for k, one in zip(some, unplaceable, strict=True)}

    @cached_property
    def worst(self) -> Sample:
        """Of the samples that come to the worst word, the one whose values are farthest to the bad side: by their ranks
        in standard deviations, each times its rank correlation with the margin. Where all hold: the least margin.
        """
        failed = self._worst_samples
        if not len(failed):
            return self.sample(int(np.nanargmin(self.margin)))
        by_name = {f.name: np.nan_to_num(f.rank) for f in self.influences}
        helps = np.array([by_name[name] for name in self.names])
        return self.sample(int(failed[np.argmin(self._normal_scores(failed) @ helps)]))

    @cached_property
    def nearest_failure(self) -> Sample | None:
        """Of the samples that come to the worst word, the one whose values are nearest to their medians, all together;
        None where all hold.
        """
        failed = self._worst_samples
        if not len(failed):
            return None
        return self.sample(int(failed[np.argmin((self._normal_scores(failed) ** 2).sum(axis=1))]))

    @property
    def _worst_samples(self) -> Ints:
        """Samples with the worst word of all there are: not held, over a limit, undecided; () where all are held."""
        found = [np.flatnonzero(self.codes == code) for code in (NOT_HELD_CODE, OVER_LIMIT_CODE, UNDECIDED_CODE)]
        return next((some for some in found if len(some)), found[0])

    def _normal_scores(self, some: Ints) -> Array:
        """(k, d) how many standard deviations of a normal distribution the values of some samples are off."""
        u = self.blocks.points(0, self.samples)[some]
        return np.asarray(scipy.special.ndtri(np.clip(u, 1e-9, 1.0 - 1e-9)))

    def to_frame(self) -> Any:
        """A pandas table with a row for each sample: its values, "word", "margin", and "why_not": why it is UNDECIDED
        without a look at its grasp, "" of all others. Raises Unsupported without pandas.
        """
        columns = {name: self.values[:, k] for k, name in enumerate(self.names)}
        said = np.array(OUTCOME_WORDS)[self.codes]
        why = [self.why_not.get(k, "") for k in range(self.samples)]
        return make_data_frame({**columns, "word": said, "margin": self.margin, "why_not": why})

    def plot(self, path: Any = None, *, title: str = "") -> Path | Any:
        """The margins of all samples, and what matters most: a matplotlib figure, or the file. Raises as
        `GraspSolution.plot`.
        """
        from handlcp.viz import draw_or_save, draw_reliability  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_reliability, self, title)

    @property
    def chances(self) -> tuple[str, ...]:
        """In words, a line each; one line where torque limits change nothing."""
        within = self.chance_within_limits
        if within is None:
            return (f"holds: {self.chance_held}",)
        if within == self.chance_held:
            return (f"holds, and within torque limits: {self.chance_held}",)
        return f"holds: {self.chance_held}", f"holds within torque limits: {within}"

    @property
    def table(self) -> TextTable:
        """What matters most, from the samples and from the derivatives."""
        heads = ("what varies", "by", "samples:\nshare", "rank\ncorr.", "derivative:\nshare", "margin\nper sd")
        rows = []
        for f in self.influences[:_MAX_TABLE_ROWS]:
            rank = f"{f.rank:+.2f}" if np.isfinite(f.rank) else "–"
            slope = "–" if not np.isfinite(f.slope) else "0 %" if abs(f.slope) < 5e-6 else f"{100 * f.slope:+.2g} %"
            rows.append((f.name, f.said, _format_share(f.share), rank, _format_share(f.linear), slope))
        return TextTable(heads, tuple(rows), "<>>>>>")

    def __str__(self) -> str:
        lines = [wrap_text(line, "  ") for line in self.chances]
        counted = ", ".join([f"{k:,} {word}" for word, k in self.counts.items() if k])
        lines.append(wrap_text(f"{self.samples:,} samples: {counted}{self._describe_estimate}", "  "))
        if self.outcomes.far.any():
            lines.append(wrap_text(f"Advice: {self._follow_advice}", "  "))
        units = {d.name: d.unit for d in self.placer.dimensions}
        for what, sample in (("worst", self.worst), ("nearest failure", self.nearest_failure)):
            if sample is not None:  # with its values that matter most
                names = [f.name for f in self.influences[:4]]
                values = ", ".join([f"{name} {format_value(sample.values[name], units[name])}" for name in names])
                text = f"{what}: sample {sample.number} ({values}): {sample.word}: {sample.cause}"
                lines.append(wrap_text(text, "  "))
        more = len(self.influences) - _MAX_TABLE_ROWS
        left = [f"and {more} that matter less"] if more > 0 else []
        return "\n".join([*lines, "", str(self.table), *left, _MARGIN_NOTE])

    @property
    def _describe_estimate(self) -> str:
        """What is said of samples that cannot be judged, or were left open."""
        fully_solved, unplaced = self.outcomes.again, int(self.outcomes.unplaced.sum())
        said = f"; {unplaced:,} are no grasp, with a contact past an edge" if unplaced else ""
        if count := int(self.outcomes.far.sum()):
            said += f"; {count:,} move farther than one solve can tell anything of"
        undecided = self.codes == UNDECIDED_CODE
        unresolved = undecided & ~fully_solved & ~self.outcomes.unplaced & ~self.outcomes.far
        if not fully_solved.any() or not unresolved.any():
            return said
        held = int((fully_solved & (self.codes < NOT_HELD_CODE)).sum())
        solved, inconclusive = int(fully_solved.sum()), int((fully_solved & undecided).sum())
        stay = f", {inconclusive} stay undecided" if inconclusive else ""
        told = f"of the undecided ones {solved} were solved in full, {held} of them hold{stay}"
        return f"{said}; {told}: the rest counts alike"

    @property
    def _follow_advice(self) -> str:
        """What to ask instead, where samples move too far for one solve."""
        nominal = self.placer.grasp.solve(self.method.faces, throw=False)
        also = "; the grasp itself is one of these" if nominal.held and solution_motions(nominal).too_large else ""
        return f'by="check" follows each sample while it is squeezed and loaded; it is slower, so ask for fewer{also}'


def _format_share(x: float) -> str:
    return words.format_percent(x if not x < 5e-4 else 0.0)


# ----------------------------------------------------------------
# How sure is it that a grasp holds, when friction, springs, masses and places are not known exactly?


_MAX_RANKED_SAMPLES = 2**17  # samples from which is read off what matters


@check_call()
def reliability(
    grasp: Grasp,
    spread: Any,
    samples: int = 10_000,
    *,
    seed: int = 0,
    faces: int | str | Pyramid = "cone",
    by: str = SOLVE,
    confidence: float = 0.95,
    decide: int = 200,
    workers: int | None = None,
    progress: Progress = None,
    resume: Any = None,
) -> Reliability:
    """The chance that a grasp holds, and that it does within its torque limits, when what it is made of varies.

    spread : what varies, each on its own, by name. A number is a standard deviation; a frozen distribution of
        scipy.stats says it all.
        "friction" : of the fingers' contacts, one coefficient for all. A share of the coefficient, or a distribution of
            the coefficient. By contact name: each its own, the environment's contacts among them.
        "stiffness" : of the joints, "pads" : flexibility of the fingertips' pads. A share, or a distribution of a
            factor. By joint, or by fingertip: each its own. A grasp without a hand: stiffness of all its fingers.
        "mass" : of the object. A share, or a distribution [kg].
        "load" : what loads the object besides its weight. A share, or a distribution of a factor.
        "squeeze" : how hard the hand closes, preloads and commands. A share, or a distribution of a factor.
        "positions" : where each finger's contact is, along both tangents [m]. It stays on the surface of a ball, box,
            cylinder or ellipsoid, and its normal turns with that; elsewhere it moves in its tangent plane. By finger:
            those. A sample with a contact past an edge of a box or a rim of a cylinder is UNDECIDED, whatever `by` is:
            it has no normal there.
        "posture" : how far each joint stands from where it is said to be [rad, m]; the fingertip goes along, and its
            squeeze changes by as much. By joint: those.
        A number of the hand, by its name for `Hand.vary`, such as "finger_1_distal.length" or "joint_stiffness" : a
            share, or a distribution [SI]. The grasp is made anew as by `vary_grasp`, some 10 milliseconds a sample;
            where fingertips do not come to touch again it is UNDECIDED. Not beside "positions" and "posture".
        A share of 0.1 is lognormal with the nominal value as its mean and a tenth of it as its standard deviation: it
        is never negative. Metres and radians are normal about 0. Of a distribution that reaches below the least
        possible value, up to a millionth is cut off; with more it is refused.
    samples : at least so many, ≥ 64; rounded up to 16 to 32 blocks of a power of two.
    by : "solve": one certified solve for small motions, squeeze and load together: 10 to 50 microseconds a sample once
        kernels are compiled. A sample that moves too far for that is UNDECIDED, as `solution.verdict` calls it.
        "check": `grasp.check()`, squeezed, then loaded, contacts followed: 10 milliseconds a sample, and 0.1 to 0.4 s
        where positions and posture vary. Postures that a hand cannot take are UNDECIDED there.
    confidence : of the intervals. decide : of the samples that the first stage of the solver leaves open, about so many
        are solved in full, with proofs. Each 512 samples have their share of these, rounded up. They tell how many of
        the others hold, and the interval grows by that.
    workers, progress : as in `solve_many`. seed : of the points; the same seed gives the same bits.
    resume : a file (.npz) that keeps what is done: the same call goes on where an interrupted one was.

    Sobol points, scrambled in independent blocks, fill the space of what varies; each sample is a whole grasp. Its word
    is that of a verdict: HELD, OVER LIMIT (held, but a joint is over its limit), NOT HELD or UNDECIDED. The lower end
    of an interval counts UNDECIDED as not held, the upper one as held.

    Raises InputError, UnknownName; InputError also for a `resume` file of another question.
    """
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    if by not in (SOLVE, CHECK):
        raise InputError("by", f'"{SOLVE}" or "{CHECK}"', repr(by)[:80])
    section = as_section(faces, planar=grasp.scene.kind.planar)
    level = check_number("confidence", confidence, above=0.0)
    if level >= 1.0:
        raise InputError("confidence", "a number below 1", confidence)
    dimensions = read_spread(grasp, spread)
    of_numbers = any(d.parameter == HAND_NUMBER for d in dimensions)
    placer = (HandNumberPlacer if of_numbers else SamplePlacer)(grasp, dimensions)
    seed, samples = check_integer("seed", seed, 0), check_integer("samples", samples, 4 * MIN_BLOCKS, 2**30)
    blocks = make_blocks(seed, len(dimensions), samples)
    method = JudgingMethod(by, faces, check_workers(workers), check_integer("decide", decide, 0))
    asked = {"seed": blocks.seed, "samples": blocks.samples, "faces": str(section), "by": by, "decide": method.decide}
    question = make_question(grasp.spec, dimensions, **asked)
    found = run_samples(placer, blocks, method, ResumeFile(resume, question), progress)
    some = min(blocks.samples, _MAX_RANKED_SAMPLES)
    names = [(d.name, d.unit, d.distribution.sd) for d in dimensions]
    matter = rank_influences(names, blocks.points(0, some), found.margin[:some], margin_slopes(placer, method))
    mechanism = grasp.spec.mechanism
    limited = mechanism is not None and bool(np.isfinite(mechanism.limits).any())
    held = _chance_below(found, NOT_HELD_CODE, blocks.size, level)
    within = _chance_below(found, OVER_LIMIT_CODE, blocks.size, level) if limited else None
    counts = {word: int((found.codes == code).sum()) for code, word in enumerate(OUTCOME_WORDS)}
    return Reliability(held, within, counts, tuple(matter), found, blocks, placer, method)


def _chance_below(found: SampleOutcomes, worse: int, size: int, level: float) -> Chance:
    """The chance of a code below `worse`. size : samples of a block. level : confidence of the interval."""
    good, undecided, fully_solved = found.codes < worse, found.codes == UNDECIDED_CODE, found.again
    unresolved = undecided & ~fully_solved & ~found.unplaced & ~found.far
    if not fully_solved.any():  # none tells anything of the others
        unresolved = np.zeros(len(good), bool)
    solved_and_good = fully_solved, fully_solved & good
    return estimate_chance(good, unresolved, undecided & ~unresolved, solved_and_good, size, level)
