"""The rows of a table: what hands hold of objects, and what one asks of that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from handlcp.design.sweep.table import columns_of
from handlcp.design.table.catalogue import TABLE_HANDS, Source, hand_of, object_of
from handlcp.design.table.doubts import FRICTION
from handlcp.design.table.pair import FAILED, GIVEN_UP, HELD, Row
from handlcp.design.table.recipe import Recipe
from handlcp.errors import InputError, shown
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.objects.object import Object
from handlcp.keywords import helped_methods
from handlcp.record import Record, data_frame
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view

_DRAWN = 5  # grasps in the picture of a hand


@helped_methods
class HandTable(Record, Sequence[Row]):
    """Rows of a table; made by `handlcp.table`. Prints a line for each hand; a sequence of dictionaries.

    sources : of the hands: package, licence, whether pictures may be shown. Of each row:

    hand, object, kind : "pinch" or "power". verdict : whether 0.2 kg, or the object's own mass, are held with gravity
    along each axis of the hand's base: "HELD", "OVER LIMIT", "NOT HELD" or "UNDECIDED"; "NOT FOUND", "GIVEN UP" or
    "FAILED" without a grasp, with the reason. payload_kg : held in each of these six directions. payload_low_kg,
    payload_high_kg : the least and the largest with what is doubted, and low_with, high_with : with what. left_out :
    for what there was no time. gives_out : what gives out first. motors_used : the largest share of a torque limit
    under the object's weight, None where no limit is known. grip_N : the largest normal force. moves_m : how far the
    object moves. chance : that it is held while friction, springs, pads and mass vary. doubts : those of the audit that
    can change a verdict. best : whether it is the better of the pair's grasps, which MuJoCo judges: mujoco.
    seconds : of computing. q, object_position_m, object_rotation, closing : the grasp, as `grasp` makes it.
    """

    entries = ("summary", "sources", "rows")

    def __init__(
        self, rows: Sequence[Row], sources: Sequence[Source], hands: Mapping[str, Hand] | None = None,
        objects: Mapping[str, Object] | None = None,
    ) -> None:  # fmt: skip
        self.rows, self.sources = tuple(rows), tuple(sources)
        self._hands, self._objects = hands or {}, objects or {}

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, at: Any) -> Any:
        return self.rows[at]

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def of(self, hand: str, object: str | None = None) -> tuple[Row, ...]:
        """The rows of a hand, or of a pair."""
        return tuple([row for row in self if row["hand"] == hand and object in (None, row["object"])])

    @property
    def summary(self) -> dict[str, Any]:
        """How many pairs there are, have a grasp or a reason, and how many of the best grasps MuJoCo holds."""
        pairs = {(row["hand"], row["object"]) for row in self}
        grasped = {(row["hand"], row["object"]) for row in self if row.get("q") is not None}
        open_ = {(row["hand"], row["object"]) for row in self if row["verdict"] in (GIVEN_UP, FAILED)}
        judged = _judged(self)
        return {
            "pairs": len(pairs), "with_a_grasp": len(grasped), "given_up": len(open_ - grasped),
            "mujoco_judged": len(judged), "mujoco_holds": judged.count(HELD),
            "seconds": _seconds(self),
        }  # fmt: skip

    def grasp(self, row: Row) -> HandGrasp:
        """The grasp of a row, made again: to check, to draw, to load otherwise. Raises InputError for one without."""
        if not any(row is one or row == one for one in self.rows):
            raise InputError("row", "a row of this table", shown(row))
        recipe = Recipe.from_row(row)
        if recipe is None:
            raise InputError("row", "a row with a grasp", f"{row['verdict']}: {row.get('reason')}"[:80])
        return recipe.grasp(self.hand(row["hand"]), self.object(row["object"]), FRICTION)

    def hand(self, name: str) -> Hand:
        """By name. Raises InputError for one that was given to another call; what `example_hand` raises."""
        if name not in self._hands and name not in TABLE_HANDS:
            raise InputError("hand", "a hand of this call", f"{name!r}, which another one was given")
        return self._hands[name] if name in self._hands else hand_of(name)

    def object(self, name: str) -> Object:
        """By name. Raises UnknownName."""
        return self._objects[name] if name in self._objects else object_of(name)

    def drawn(self, hand: str) -> list[Row]:
        """Some best grasps of a hand: those of different objects that hold most."""
        best = [row for row in self.of(hand) if row.get("best") and row["payload_kg"]]
        return sorted(best, key=lambda row: -row["payload_kg"])[:_DRAWN]

    def to_frame(self) -> Any:
        """A pandas table. Raises Unsupported without pandas."""
        return data_frame(columns_of(self.rows))

    def page(self, path: Any) -> Path:
        """Write one page (html) that sorts and filters, with a picture of each hand whose licence allows that. Raises
        InputError for a file that cannot be written; Unsupported without matplotlib.
        """
        made: Path = view("table_page")(self, path)
        return made

    def __str__(self) -> str:
        s = self.summary
        said = f"{s['pairs']} pairs of {len(self.sources)} hands, {s['with_a_grasp']} with a grasp"
        if s["given_up"]:
            said += f", {s['given_up']} given up"
        if s["mujoco_judged"]:
            said += f"; MuJoCo holds {s['mujoco_holds']} of {s['mujoco_judged']} best grasps"
        rows = [self._line(one.hand) for one in self.sources]
        heads = "hand", "pairs", "pinch\nholds", "power\nholds", "no\ngrasp", "MuJoCo\nholds", "most\nkg", "s a\npair"
        return f"{wrapped(f'{said}.')}\n\n{TextTable(heads, tuple(rows), '<>>>>>>>')}"

    def _line(self, hand: str) -> tuple[str, ...]:
        rows = self.of(hand)
        pairs = {row["object"] for row in rows}
        held = Counter(row["kind"] for row in rows if row["verdict"] == HELD)
        none = pairs - {row["object"] for row in rows if row.get("q") is not None}
        judged = _judged(rows)
        most = max([row.get("payload_kg") or 0.0 for row in rows], default=0.0)
        return (
            hand, str(len(pairs)), str(held["pinch"]), str(held["power"]), str(len(none)),
            f"{judged.count(HELD)} of {len(judged)}" if judged else "", f"{most:.3g}" if most else "",
            f"{_seconds(rows) / max(len(pairs), 1):.0f}",
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"HandTable({len(self)} rows of {len(self.sources)} hands)"


def _judged(rows: Iterable[Row]) -> list[str]:
    """MuJoCo's verdicts, where it has one."""
    return [row["mujoco"] for row in rows if row.get("mujoco") and not row["mujoco"].startswith("not asked")]


def _seconds(rows: Iterable[Row]) -> float:
    """Of computing, all that they took."""
    return sum([float(row.get("seconds", 0.0)) + float(row.get("mujoco_seconds", 0.0)) for row in rows])
