"""What every hand holds of every object: `handlcp.table`."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from handlcp.check import number, yes_or_no
from handlcp.design.sweep.journal import Journal, read
from handlcp.design.sweep.run import rows_of
from handlcp.design.sweep.same import digest
from handlcp.design.sweep.table import write_table
from handlcp.design.sweep.work import DESIGN, Row, packed
from handlcp.design.table import SECONDS
from handlcp.design.table.catalogue import TABLE_HANDS, Source, object_of, source, table_objects
from handlcp.design.table.pair import KINDS, Asked, flat, work
from handlcp.design.table.result import HandTable
from handlcp.errors import HandLCPError, InputError, UnknownName, as_path, writing
from handlcp.hand.hand import Hand
from handlcp.hand.objects.object import Object
from handlcp.keywords import helped
from handlcp.progress import Progress, told
from handlcp.version import VERSION

ROWS, PARQUET, JSON = "table.rows", "table.parquet", "table.json"  # in the folder of a table


@helped()
def table(
    hands: Any = None, objects: Any = None, out: Any = "table", executor: Any = None, *,
    kinds: Sequence[str] = KINDS, seconds: float = SECONDS, simulated: bool = True, progress: Progress = None,
) -> HandTable:  # fmt: skip
    """What hands hold of objects: a pinch and a power grasp of each pair, its payload with gravity along six axes, how
    far that is sure, what gives out first, and MuJoCo's verdict on the better of the two.

    hands : names of `handlcp hands`, or a mapping of names to hands; None: all that are installed. objects : names, or
        a mapping of names to objects with a mass; None: a ball, a cylinder and the YCB set, one of each kind.
    out : a folder. Rows are kept there as they come: the same call, killed and made again, goes on with what is
        missing, and other hands and objects join those that are there. `table.parquet` and `table.json` are for others;
        `HandTable.page` writes a page.
    executor : as of `sweep`: None: processes, one a core; any `concurrent.futures` executor; a Dask client; "serial".
    kinds : of grasps. seconds : of computing that finding a power grasp may take, half of that for pinches, and three
        quarters each for judging and for the interval: what takes longer is left out, and the row says so.
    simulated : whether MuJoCo is asked; without it installed rows say that it was not. progress : as of `sweep`.

    Raises InputError, also for a folder with a table of another version or other settings; UnknownName. A pair that
    fails is a row with its reason.
    """
    given_hands, sources = _hands(hands)
    given_objects, names = _objects(objects)
    asked = Asked(given_hands, given_objects, _kinds(kinds), number("seconds", seconds, above=0.0),
                  yes_or_no("simulated", simulated))  # fmt: skip
    folder = _folder(out)
    same = {"handlcp": VERSION, "kinds": list(asked.kinds), "seconds": asked.seconds, "simulated": asked.simulated}
    pairs = {_number(asked, one, thing): {"hand": one.hand, "object": thing} for one in sources for thing in names}
    with Journal(folder / ROWS, same) as journal:
        if unlike := [key for key in same if journal.sweep.get(key) != same[key]]:
            differs = ", ".join(f"{key} ({journal.sweep.get(key)!r}, now {same[key]!r})" for key in unlike)
            raise InputError("out", "a new folder, or that of the same table", f"{str(folder)!r}: {differs}")
        _run(asked, pairs, journal, executor, progress)
        rows = [row for row in journal.rows if row[DESIGN] in pairs]
    made = HandTable(list(flat(_in_order(rows, list(pairs)), asked.kinds)), sources, given_hands, given_objects)
    made.to_json(folder / JSON)
    write_table(folder / PARQUET, same, [_columns(row) for row in made])
    return made


def loaded(out: Any) -> HandTable:
    """The table of a folder, as far as it has come. Raises InputError."""
    file = as_path("out", out, "the name of a folder") / ROWS
    if not file.is_file():
        raise InputError("out", "the folder of a table", repr(str(out)))
    said, rows, _ = read(file)
    try:
        kinds = tuple(KINDS if said is None else said["kinds"])
        names = dict.fromkeys(row["hand"] for row in rows)
        sources = [source(name) if name in TABLE_HANDS else Source(name, "given", "yours") for name in names]
        return HandTable(list(flat(rows, kinds)), sources)
    except (KeyError, TypeError, AttributeError, IndexError):
        raise InputError("out", "the folder of a table", f"{str(file)!r}, whose rows are none of a table") from None


def _run(asked: Asked, pairs: Mapping[int, Any], journal: Journal, executor: Any, progress: Progress) -> None:
    """Append the rows that are not there yet, as they come."""
    there = frozenset(row[DESIGN] for row in journal.rows)
    found = rows_of(packed(asked), [[number] for number in pairs], pairs, there, executor, work)
    with told("pairs", len(pairs), progress, len(there & pairs.keys())) as say, closing(found):
        for rows in found:
            journal.append(rows)
            say(len(rows))


def _in_order(rows: Sequence[Row], numbers: list[int]) -> list[Row]:
    place = {number: k for k, number in enumerate(numbers)}
    return sorted(rows, key=lambda row: place[row[DESIGN]])


def _columns(row: Row) -> Row:
    """As a table of columns has it: nothing where there is nothing to say."""
    return {name: None if value == "" else value for name, value in row.items()}


# ----------------------------------------------------------------


def _hands(given: Any) -> tuple[dict[str, Hand], list[Source]]:
    """Those that are given, and where all come from. Of None those that are not installed are left out."""
    if isinstance(given, Mapping):
        for name, hand in given.items():
            if not isinstance(hand, Hand):
                raise InputError(f"hands[{name!r}]", "a Hand", repr(hand)[:80])
        return {str(name): hand for name, hand in given.items()}, [Source(str(n), "given", "yours") for n in given]
    if given is not None:
        return {}, [source(name) for name in _names("hands", given)]
    found = list[Source]()
    for name in TABLE_HANDS:
        try:
            found.append(source(name))
        except HandLCPError:  # its package is not installed
            continue
    return {}, found


def _objects(given: Any) -> tuple[dict[str, Object], tuple[str, ...]]:
    if isinstance(given, Mapping):
        for name, obj in given.items():
            if not isinstance(obj, Object) or not obj.mass > 0.0:
                raise InputError(f"objects[{name!r}]", "an object with a mass", repr(obj)[:80])
        return {str(name): obj for name, obj in given.items()}, tuple(map(str, given))
    if given is None:
        return {}, table_objects()
    names = _names("objects", given)
    for name in names:
        object_of(name)  # whether there is one
    return {}, names


def _names(argument: str, given: Any) -> tuple[str, ...]:
    names = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Sequence) else ()
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError(argument, "names, or a mapping of names to them", repr(given)[:80])
    return names


def _kinds(given: Any) -> tuple[str, ...]:
    names = _names("kinds", given)
    if unknown := [name for name in names if name not in KINDS]:
        raise UnknownName("kinds", "a kind of grasp", unknown, KINDS)
    return names


def _folder(out: Any) -> Path:
    folder = as_path("out", out, "the name of a folder")
    with writing("out", folder):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def _number(asked: Asked, one: Source, thing: str) -> int:
    """Of a pair, the same whichever others are in the table: a hand by its name and package, or by what it is."""
    hand, obj = asked.hands.get(one.hand), asked.objects.get(thing)
    said = [one.hand, one.package, "" if hand is None else digest(hand), thing, "" if obj is None else digest(obj)]
    return int.from_bytes(hashlib.sha256("\n".join(said).encode()).digest()[:6])
