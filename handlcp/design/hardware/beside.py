"""Numbers that makers and papers state, beside the same computed from the hands' files: `handlcp.beside_hardware`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from handlcp.check import several
from handlcp.design.hardware.computed import COMPUTED, Computed, computed
from handlcp.design.hardware.stated import Stated, stated
from handlcp.errors import HandLCPError, InputError, UnknownName, brief
from handlcp.hand.hand import Hand
from handlcp.hand.library import example_hand
from handlcp.keywords import helped, helped_methods
from handlcp.progress import told
from handlcp.record import Record, columns_of, data_frame
from handlcp.text_table import TextTable, wrapped

STIFFNESS = 5.0  # [N·m/rad] of each joint, assumed, as in the table of hands
INSIDE, OUTSIDE, OPEN = "inside", "outside", "not computed"


@dataclass(frozen=True)
class BesideRow(Record):
    """One number. stated : who says what. low, nominal, high : the same computed, in its unit; None where it is not.
    over : what that is an interval over. word : "inside", "outside" or "not computed". why : in words, where it is not
    inside.
    """

    entries = ("hand = stated.hand", "test = stated.what", "stated", "low", "nominal", "high", "over", "word", "why")

    stated: Stated
    low: float | None
    nominal: float | None
    high: float | None
    over: str
    word: str
    why: str


@helped_methods
class Beside(Record, Sequence[BesideRow]):
    """What is stated beside what is computed; made by `beside_hardware`. Prints as a table and the reasons below it."""

    entries = ("rows",)

    def __init__(self, rows: Sequence[BesideRow]) -> None:
        self.rows = tuple(rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, at: Any) -> Any:
        return self.rows[at]

    def __iter__(self) -> Iterator[BesideRow]:
        return iter(self.rows)

    def to_frame(self) -> Any:
        """A pandas table. Raises Unsupported without pandas."""
        names = "hand", "test", "low", "nominal", "high", "word", "why"
        return data_frame(columns_of(self.rows, *names[2:]) | {
            "hand": [row.stated.hand for row in self], "test": [row.stated.what for row in self],
            "stated": [row.stated.number for row in self], "by": [row.stated.by for row in self],
            "source": [row.stated.source for row in self],
        })  # fmt: skip

    def __str__(self) -> str:
        rows, reasons = list[tuple[str, ...]](), dict[str, None]()
        for row in self:
            one = row.stated
            span = "" if row.low is None else f"{row.low:.3g} to {row.high:.3g}"
            rows.append((f"{one.hand}, {one.what}", one.by, one.number, span, row.word))
            if row.why:
                reasons[f"{one.hand}, {one.what}, {one.number}: {row.why}"] = None
        heads = ("hand and test", "by", "stated", "computed", "")
        return "\n".join([str(TextTable(heads, tuple(rows), "<<>><")), "", *[wrapped(f"{x}.", "  ") for x in reasons]])

    def __repr__(self) -> str:
        words = [row.word for row in self]
        return f"Beside({', '.join(f'{words.count(word)} {word}' for word in (INSIDE, OUTSIDE, OPEN))})"


@helped()
def beside_hardware(hands: Mapping[str, Hand] | None = None, tests: Sequence[str] | None = None) -> Beside:
    """Numbers that makers and papers state of hands, beside the same computed from the hands' files with an interval
    over what is not stated (posture, friction) and what the audit doubts (torque limits). Nothing is tuned.

    hands : by the name that a stated number has, such as "Unitree Dex5-1", for hands whose files pip does not bring;
        they replace others, too. tests : "fingertip", "pinch", "power", "payload"; None: all. Raises InputError,
        UnknownName.
    """
    given, names = dict(hands or {}), {one.hand for one in stated()}
    chosen = () if tests is None else several("tests", tests, f"tests, of {', '.join(COMPUTED)}")
    if unknown := [str(name) for name in given if name not in names]:
        raise UnknownName("hands", "a hand of which something is stated", unknown, sorted(names))
    if wrong := [name for name, hand in given.items() if not isinstance(hand, Hand)]:
        raise InputError(f"hands[{wrong[0]!r}]", "a Hand", repr(given[wrong[0]])[:80])
    if unknown := [test for test in chosen if not isinstance(test, str) or test not in COMPUTED]:
        raise UnknownName("tests", "a test", map(str, unknown), COMPUTED)
    asked = [one for one in stated() if tests is None or one.test in chosen]
    with told("stated numbers", len(asked)) as done:
        rows = []
        for one in asked:
            rows.append(_row(one, given))
            done(1)
    return Beside(rows)


def _row(one: Stated, given: Mapping[str, Hand]) -> BesideRow:
    def not_computed(why: str) -> BesideRow:
        return BesideRow(one, None, None, None, "", OPEN, why)

    if one.test not in COMPUTED:
        return not_computed("a test that the package does not have")
    if one.hand not in given and not one.example:
        how = f'beside_hardware({{"{one.hand}": Hand.from_urdf(…)}})'
        return not_computed(f"its file is not installed ({one.file}): {how}")
    try:
        hand = given[one.hand] if one.hand in given else example_hand(one.example, joint_stiffness=STIFFNESS)
        found = computed(hand, one)
    except HandLCPError as error:
        return not_computed(brief(error))
    inside = found.low <= one.most and one.least <= found.high
    return BesideRow(
        one, found.low, found.nominal, found.high, found.over, INSIDE if inside else OUTSIDE,
        "" if inside else _why(one, found),
    )  # fmt: skip


def _why(one: Stated, found: Computed) -> str:
    """What would have to be otherwise."""
    if found.high == 0.0:
        return "the hand holds nothing in this test"
    low, high = found.limits
    share = low * one.most / found.low if one.most < found.low else high * one.least / found.high
    return (
        f"torque limits {share:.2g} times those of the file would give it, in the posture that needs least: the hand "
        "has other motors than its file says, or was measured in another way"
    )
