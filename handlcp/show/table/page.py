"""The page of a table: a picture of each hand, and rows to sort and to filter. It needs no network."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from handlcp.design.table.catalogue import MASS, about_objects
from handlcp.design.table.result import HandTable
from handlcp.errors import HandLCPError
from handlcp.hand.find.candidate import Candidate, candidate_of
from handlcp.progress import told
from handlcp.show.file import checked_page, new_figure
from handlcp.show.page.written import data_of, image, web_files, write

# Of each row, in the order of the page's columns: key, digits
_SHOWN = {
    "hand": 0, "object": 0, "kind": 0, "verdict": 0, "payload_kg": 3, "payload_low_kg": 3, "payload_high_kg": 3,
    "gives_out": 0, "motors_used": 3, "grip_N": 3, "chance": 4, "mujoco": 0, "seconds": 3, "reason": 0, "low_with": 0,
    "high_with": 0, "left_out": 0, "best": 0,
}  # fmt: skip


def save(table: HandTable, path: Any) -> Path:
    """Write the page. Raises InputError for a file that cannot be written; Unsupported without matplotlib."""
    target = checked_page(path)
    new_figure()  # whether matplotlib is there
    cards = list[str]()
    with told("pictures", len(table.sources)) as say:
        for one in table.sources:
            png = picture(table, one.hand) if one.may_be_shown else b""
            cards.append(_card(table, one.hand, one.package, one.licence, one.may_be_shown, png))
            say(1)
    rows = [[_short(row.get(key), digits) for key, digits in _SHOWN.items()] for row in table]
    frame, style, script = web_files("table.html", "table.css", "table.js", package="handlcp.show.table")
    parts = {
        "cards": "".join(cards), "said": escape(str(table).partition("\n\n")[0]), "about": escape(about_objects()),
        "mass": f"{MASS:g}", "data": data_of({"keys": list(_SHOWN), "rows": rows}), "script": script,
    }  # fmt: skip
    return write(target, frame, "What hands hold", style, parts)


def picture(table: HandTable, hand: str) -> bytes:
    """A png of a hand with some of the objects that it holds best; b"" for one that holds none."""
    from handlcp.show.picture.figure import contact_sheet  # pictures alone need matplotlib

    grasps = [(row["object"], found) for row in table.drawn(hand) if (found := _candidate(table, row)) is not None]
    if not grasps:
        return b""
    return contact_sheet([(name.partition("_")[2].replace("_", " ") or name, one) for name, one in grasps])


def _candidate(table: HandTable, row: dict[str, Any]) -> Candidate | None:
    """The grasp of a row, with one solve; None where it cannot be made, such as by another version."""
    try:
        grasp = table.grasp(row)
        solution = grasp.solve(throw=False, proof=False)
        found = candidate_of(row["kind"], grasp, solution)
    except HandLCPError:
        return None
    found.__dict__["verdict"] = solution.verdict  # the row has the one of its path
    return found


def _card(table: HandTable, hand: str, package: str, licence: str, shown: bool, png: bytes) -> str:
    """Of one hand: picture, where it comes from, and how much it holds."""
    drawn = f'<p class="none">{"nothing held" if shown else "no picture: the licence of its meshes"}</p>'
    if png:
        drawn = image(png, f"{hand} with objects")
    rows = table.of(hand)
    pairs = {row["object"] for row in rows}
    held = {row["object"] for row in rows if row["verdict"] == "HELD"}
    doubts = next((row["doubts"] for row in rows if row.get("doubts")), "")
    said = f"holds {len(held)} of {len(pairs)} objects" + (f". Doubts: {doubts}" if doubts else "")
    name = escape(hand, quote=True)
    return (
        f'<figure><button type="button" data-hand="{name}"><b>{name}</b> <span>{escape(package)}, licence: '
        f"{escape(licence)}</span></button>{drawn}<figcaption>{escape(said)}.</figcaption></figure>"
    )


def _short(value: Any, digits: int) -> Any:
    """A number with so many digits."""
    return float(f"{value:.{digits}g}") if digits and isinstance(value, float) else value
