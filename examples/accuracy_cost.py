"""What accuracy costs, on a path too, and how NSNGRK converges: figures and the numbers behind them.

Run it: `python examples/accuracy_cost.py` takes about two minutes and writes its pictures beside itself. It
needs matplotlib: `pip install '.[plot]'`.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rich.console import Console

import handlcp as hl
from handlcp import scene
from handlcp.method import paper, work_precision
from handlcp.method.accuracy import table as accuracy_table
from handlcp.method.convergence import Convergence, convergence, picture as picture
from handlcp.show.file import checked

HERE = Path(__file__).parent
FACES = 8  # of Example 3's pyramids in the paper's Tables 6 and 7


def what_accuracy_costs(seconds: float = 40.0, **fewer: Any) -> list[tuple[str, hl.AccuracyCost]]:
    """Time against error for a hand and for the paper's three fingers; `fewer` goes to `hl.accuracy_cost`."""
    hand = scene.load(HERE / "ball_five_fingers.toml").build()
    three = paper.example(3).grasp
    return [
        ("A ball in a hand with five fingers", hl.accuracy_cost(hand, seconds=seconds, **fewer)),
        ("A cube on three fingers, the paper's Example 3", hl.accuracy_cost(three, seconds=seconds, **fewer)),
    ]


def how_it_converges(seeds: Iterable[int] = range(6)) -> Convergence:
    """Example 3, in natural units and as the paper ran it."""
    found = convergence(paper.example(3).grasp, FACES, seeds=seeds)
    # In natural units every seed finds what the paper's exact method found (Table 6) …
    exact = paper.table(6).forces(3)[:, 2]
    for run in found.select("natural"):
        assert abs(run.values[-1] - exact).max() < 1e-5
    # … and as the paper ran it, in metres and newtons, all end well below its stop rule, most far from there.
    assert all(run.stop is not None for run in found.select("given"))
    assert max(found.error(run)[-1] for run in found.select("given")) > 0.005
    return found


def table_10(seeds: Iterable[int] = range(6)) -> Convergence:
    """Example 5 with 6 faces, whose printed forces are no solution either."""
    found = convergence(paper.example(5).grasp, 6, seeds=seeds)
    assert all(run.stop is not None for run in found.select("given"))
    return found


def what_a_path_costs(**fewer: Any) -> hl.PathCost:
    """Time against error of a path: a cube in three fingers, pulled aside; `fewer` goes to `hl.path_cost`."""
    cube = scene.load(HERE / "cube_three_fingers.toml").build()
    return hl.path_cost(cube, (0.3, 0.9, 0.3, 0, 0, 0), **fewer)


def write(
    costs: list[tuple[str, hl.AccuracyCost]], path: hl.PathCost, found: Convergence, other: Convergence, folder: Path,
    out: Console,
) -> list[Path]:  # fmt: skip
    """Tables to the terminal, pictures into the folder."""
    for title, cost in costs:
        out.print(title, style="bold", end="\n\n")
        for table in accuracy_table.all_tables(cost):
            out.print(table)
        out.print(f"{cost.summary}.", end="\n\n", highlight=False)
    out.print("A path: the cube in three fingers, pulled along (0.3, 0.9, 0.3)", style="bold", end="\n\n")
    out.print(str(path), end="\n\n", highlight=False)
    i = found.disputed
    out.print(
        f"Example 3, {FACES} faces: in metres and newtons seeds disagree about the normal force of {found.names[i]} by "
        f"{100 * found.spread('given'):.0f} %, in natural units by {100 * found.spread('natural'):.0e} %.\n"
        f"A greedy step gains as much as {found.gain:.1f} uniform ones.",
        highlight=False,
    )
    printed = ("Table 7", float(paper.table(7).forces(3)[i, 2]))
    also = ("Table 10", float(paper.table(10).forces(5)[other.disputed, 2]))
    return [
        work_precision.save(costs, folder / "accuracy_cost.png"),
        path.plot(folder / "path_cost.png", title="What accuracy costs on a path: a cube pulled aside"),
        picture.save(found, folder / "convergence.png", f"How NSNGRK converges: Example 3, {FACES} faces", printed),
        picture.save(other, folder / "convergence_table_10.png", "How NSNGRK converges: Example 5, 6 faces", also),
    ]


def main(folder: Path = HERE) -> None:
    """Both studies, the tables, the pictures."""
    checked(folder / "accuracy_cost.png")  # before two minutes are spent
    for path in write(what_accuracy_costs(), what_a_path_costs(), how_it_converges(), table_10(), folder, Console()):
        print(f"Written: {path}")


if __name__ == "__main__":
    main()
