"""What accuracy costs, on a path too: figures and the numbers behind them.

Run it: `python examples/accuracy_cost.py` takes about two minutes and writes its pictures beside itself. It
needs matplotlib: `pip install '.[plot]'`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console

import handlcp as hl
from handlcp import scene
from handlcp.studies import paper
from handlcp.viz.accuracy import all_tables, save
from handlcp.viz.output_file import check_picture_path

HERE = Path(__file__).parent


def what_accuracy_costs(seconds: float = 40.0, **fewer: Any) -> list[tuple[str, hl.AccuracyCost]]:
    """Time against error for a hand and for the paper's three fingers; `fewer` goes to `hl.accuracy_cost`."""
    hand = scene.load(HERE / "ball_five_fingers.toml").build()
    three = paper.example(3).grasp
    return [
        ("A ball in a hand with five fingers", hl.accuracy_cost(hand, seconds=seconds, **fewer)),
        ("A cube on three fingers, the paper's Example 3", hl.accuracy_cost(three, seconds=seconds, **fewer)),
    ]


def what_a_path_costs(**fewer: Any) -> hl.PathCost:
    """Time against error of a path: a can in five soft fingers, pulled aside; `fewer` goes to `hl.path_cost`."""
    can = hl.Cylinder(0.027, 0.068, placement=(0, 0, 0.069), mass=0.5)
    hand = hl.example_hand("five_finger", joint_stiffness=12.0, pad_flexibility=5e-5)
    grasp = hand.at(hand.close_on(can)).grasp(can, hl.SoftFinger(0.9, 0.004), squeeze=0.004)
    return hl.path_cost(grasp, (0, 1, 0, 0, 0, 0), **fewer)


def write(costs: list[tuple[str, hl.AccuracyCost]], path: hl.PathCost, folder: Path, out: Console) -> list[Path]:
    """Tables to the terminal, pictures into the folder."""
    for title, cost in costs:
        out.print(title, style="bold", end="\n\n")
        for table in all_tables(cost):
            out.print(table)
        out.print(f"{cost.summary}.", end="\n\n", highlight=False)
    out.print("A path: a can in five soft fingers, pulled along y", style="bold", end="\n\n")
    out.print(str(path), end="\n\n", highlight=False)
    return [
        save(costs, folder / "accuracy_cost.png"),
        path.plot(folder / "path_cost.png", title="What accuracy costs on a path: a can pulled aside"),
    ]


def main(folder: Path = HERE) -> None:
    """Both studies, the tables, the pictures."""
    check_picture_path(folder / "accuracy_cost.png")  # before two minutes are spent
    for path in write(what_accuracy_costs(), what_a_path_costs(), folder, Console()):
        print(f"Written: {path}")


if __name__ == "__main__":
    main()
