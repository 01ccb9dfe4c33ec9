"""How sure a grasp is: chances with intervals, counts, the worst sample, and what matters most."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, Ints, integer
from handlcp.grasp import GraspSolution, Verdict
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solution.verdict import Reason, solution_motions
from handlcp.keywords import helped_methods
from handlcp.record import Record, data_frame
from handlcp.study.reliability.interval import Chance, Influence, value_with
from handlcp.study.reliability.outcome import WORDS, Outcomes
from handlcp.study.reliability.place import Placer
from handlcp.study.reliability.run import Blocks, Method, values_at
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view

_ROWS = 8  # of the printed table
_MARGIN = "margin: unused share of all friction or of a joint’s torque limit, the smaller"
OVER_LIMIT, NOT_HELD, UNDECIDED = 1, 2, 3  # codes


@dataclass(frozen=True, eq=False)
class Sample(Record):
    """One sample of a reliability, with its grasp, which is solved when that is looked at.

    number : 0 to `samples` - 1. values : by name, SI units. word : "HELD", "OVER LIMIT", "NOT HELD", "UNDECIDED".
    margin : what is left of friction or torque, whichever is less, as a share; NaN where nothing holds.
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
    method: Method = field(repr=False)
    why_not: str | None = None

    @cached_property
    def solution(self) -> GraspSolution:
        """One certified solve, with proof where nothing holds."""
        return self.grasp.solve(self.method.faces, throw=False)

    @cached_property
    def verdict(self) -> Verdict:
        """As the sample was judged: of one solve, or of `grasp.check()`."""
        if self.why_not is not None:
            return Verdict(self.word, (Reason("unplaced", "decides", self.why_not),))
        if self.method.by == "check":
            return self.grasp.check(faces=self.method.faces, solution=self.solution)
        return self.solution.verdict

    @property
    def cause(self) -> str:
        """Why it comes to its word, in one sentence."""
        return self.verdict.text

    def __str__(self) -> str:
        return wrapped(f"sample {self.number}, {self.word}: {self.cause}", "  ")


@helped_methods
@dataclass(frozen=True, eq=False)
class Reliability(Record):
    """The answer of `hl.reliability`.

    chance_held : that the grasp holds. chance_within_limits : that it holds with every joint within its torque limit;
    None where no joint has a known limit. counts : samples by word. samples, seed. influences : what matters, the most
    first. outcomes : of each sample.
    """

    entries = (
        "samples",
        "seed",
        "judged_by = method.by",
        "counts",
        "chance_held",
        "chance_within_limits",
        "worst",
        "nearest_failure",
        "influences",
    )

    chance_held: Chance
    chance_within_limits: Chance | None
    counts: dict[str, int]
    influences: tuple[Influence, ...]
    outcomes: Outcomes = field(repr=False)
    blocks: Blocks = field(repr=False)
    placer: Placer = field(repr=False)
    method: Method = field(repr=False)

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
        """(m,) 1 - the larger of all friction used and the largest torque over its limit; NaN where nothing holds."""
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
        return values_at(self.placer.dimensions, self.blocks.points(0, self.samples))

    def sample(self, k: int) -> Sample:
        """Sample k, 0 to `samples` - 1. Raises InputError."""
        k = integer("k", k, 0, self.samples - 1)
        row = values_at(self.placer.dimensions, self.blocks.points(k, k + 1))[0]
        values = dict(zip(self.names, row.tolist(), strict=True))
        word = WORDS[int(self.codes[k])]
        (placed,) = self.placer.placed(row[None])
        return Sample(k, values, word, float(self.margin[k]), placed.grasp, self.method, placed.why_not)

    @cached_property
    def why_not(self) -> dict[int, str]:
        """Why samples are UNDECIDED without a look at their grasp, by number, such as a contact past an edge."""
        some = np.flatnonzero(self.outcomes.unplaced)
        if not some.size:
            return {}
        past = self.placer.arrays(self.values[some]).past
        return {int(k): str(self.placer.why_not(one)) for k, one in zip(some, past, strict=True)}

    @cached_property
    def worst(self) -> Sample:
        """Of the samples that come to the worst word, the one whose values are farthest to the bad side: by their ranks
        in standard deviations, each times its rank correlation with the margin. Where all hold: the least margin.
        """
        failed = self._failed
        if not len(failed):
            return self.sample(int(np.nanargmin(self.margin)))
        by_name = {f.name: np.nan_to_num(f.rank) for f in self.influences}
        helps = np.array([by_name[name] for name in self.names])
        return self.sample(int(failed[np.argmin(self._scores(failed) @ helps)]))

    @cached_property
    def nearest_failure(self) -> Sample | None:
        """Of the samples that come to the worst word, the one whose values are nearest to their medians, all together;
        None where all hold.
        """
        failed = self._failed
        if not len(failed):
            return None
        return self.sample(int(failed[np.argmin((self._scores(failed) ** 2).sum(axis=1))]))

    @property
    def _failed(self) -> Ints:
        """Samples with the worst word of all there are: not held, over a limit, undecided; () where all are held."""
        for code in (NOT_HELD, OVER_LIMIT, UNDECIDED):
            if (self.codes == code).any():
                return np.flatnonzero(self.codes == code)
        return np.zeros(0, np.int64)

    def _scores(self, some: Ints) -> Array:
        """(k, d) how many standard deviations of a normal distribution the values of some samples are off."""
        from scipy.special import ndtri

        u = self.blocks.points(0, self.samples)[some]
        return np.asarray(ndtri(np.clip(u, 1e-9, 1.0 - 1e-9)))

    def to_frame(self) -> Any:
        """A pandas table with a row for each sample: its values, "word", "margin", and "why_not": why it is UNDECIDED
        without a look at its grasp, "" of all others. Raises Unsupported without pandas.
        """
        columns = {name: self.values[:, k] for k, name in enumerate(self.names)}
        said = np.array(WORDS)[self.codes]
        why = [self.why_not.get(k, "") for k in range(self.samples)]
        return data_frame({**columns, "word": said, "margin": self.margin, "why_not": why})

    def plot(self, path: Any = None, *, title: str = "") -> Path | Any:
        """The margins of all samples, and what matters most: a matplotlib figure, or the file. Raises as
        `GraspSolution.plot`.
        """
        return view("reliability_plot")(self, path, title)

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
        some = self.influences[:_ROWS]
        rows = [(f.name, f.said, _share(f.share), _rank(f.rank), _share(f.linear), _points(f.slope)) for f in some]
        return TextTable(heads, tuple(rows), "<>>>>>")

    def __str__(self) -> str:
        lines = [wrapped(line, "  ") for line in self.chances]
        counted = ", ".join([f"{k:,} {word}" for word, k in self.counts.items() if k])
        lines.append(wrapped(f"{self.samples:,} samples: {counted}{self._estimated}", "  "))
        if self.outcomes.far.any():
            lines.append(wrapped(f"Advice: {self._follow}", "  "))
        for what, sample in (("worst", self.worst), ("nearest failure", self.nearest_failure)):
            if sample is not None:
                lines.append(wrapped(f"{what}: {self._told(sample)}", "  "))
        more = len(self.influences) - _ROWS
        left = [f"and {more} that matter less"] if more > 0 else []
        return "\n".join([*lines, "", str(self.table), *left, _MARGIN])

    @property
    def _estimated(self) -> str:
        """What is known of samples that nobody looked at in full."""
        looked, past = self.outcomes.again, int(self.outcomes.unplaced.sum())
        said = f"; {past:,} are no grasp, with a contact past an edge" if past else ""
        if count := int(self.outcomes.far.sum()):
            said += f"; {count:,} move farther than one solve can tell anything of"
        left = ~looked & ~self.outcomes.unplaced & ~self.outcomes.far & (self.codes == UNDECIDED)
        if not looked.any() or not left.any():
            return said
        held = int((looked & (self.codes < NOT_HELD)).sum())
        full, open_ = int(looked.sum()), int((looked & (self.codes == UNDECIDED)).sum())
        stay = f", {open_} stay undecided" if open_ else ""
        told = f"of the undecided ones {full} were solved in full, {held} of them hold{stay}"
        return f"{said}; {told}: the rest counts alike"

    @property
    def _follow(self) -> str:
        """What to ask instead, where samples move too far for one solve."""
        nominal = self.placer.grasp.solve(self.method.faces, throw=False)
        also = "; the grasp itself is one of these" if nominal.held and solution_motions(nominal).too_large else ""
        return f'by="check" follows each sample while it is squeezed and loaded; it is slower, so ask for fewer{also}'

    def _told(self, sample: Sample) -> str:
        """A sample in words, with its values that matter most."""
        units = {d.name: d.unit for d in self.placer.dimensions}
        first = [f.name for f in self.influences[:4]]
        values = ", ".join([f"{name} {value_with(sample.values[name], units[name])}" for name in first])
        return f"sample {sample.number} ({values}): {sample.word}: {sample.cause}"


def _share(x: float) -> str:
    return words.percent(x if not x < 5e-4 else 0.0)


def _points(x: float) -> str:
    """A change of the margin, in percent of the limit."""
    return "–" if not np.isfinite(x) else "0 %" if abs(x) < 5e-6 else f"{100 * x:+.2g} %"


def _rank(x: float) -> str:
    return f"{x:+.2f}" if np.isfinite(x) else "–"
