"""What effects cost a scene that asks for them, and one that doesn't.

    python -m tests.benchmarks.effects [--hand five] [--faces 8] [--rounds 400] [--json FILE]

One hand with an object, and the same with each effect alone and with all that go together: unknowns of the assembled
problem, time from the grasp's numbers to a certified answer (placed anew every time, so that nothing is kept; medians,
in turns), and by how much the forces differ. Then what a scene pays for the effects that it doesn't name: its own
solve against itself, which is the noise, and its assembly against that of the four effects it needs, listed by hand.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

import handlcp as hl
from tests.benchmarks.clock import median_times
from tests.benchmarks.report import conditions, opened, plain_table
from tests.hand.composition import EFFECTS, HANDS, made
from tests.support.grasp import anew, changed
from tests.support.steps import assembly, assembly_by_hand

__all__ = ["main"]

ALL = "all that go together"
APART = {"geometric stiffness", "tendons"}  # refused beside saturation and soft fingers; one transmission a hand


def unknowns(grasp: hl.Grasp, faces: Any) -> int:
    """Of the assembled problem, before anything is eliminated."""
    return sum(u.count for u in grasp.problem(faces).groups)


def asked(name: str) -> dict[str, hl.HandGrasp]:
    """The grasp without effects, with each, and with all."""
    scenes = {"none": made(name).grasp} | {effect: made(name, [effect]).grasp for effect in EFFECTS}
    return scenes | {ALL: made(name, set(EFFECTS) - APART).grasp}


def measure(console: Console, name: str, faces: Any, rounds: int) -> list[dict[str, Any]]:
    """Print and return one row for each scene."""
    scenes = asked(name)
    answers = {effect: grasp.solve(faces) for effect, grasp in scenes.items()}

    def solves(grasp: hl.HandGrasp) -> Callable[[], Any]:
        return lambda: anew(grasp).solve(faces)

    times = median_times({effect: solves(grasp) for effect, grasp in scenes.items()}, rounds)
    bare, n = answers["none"], len(answers["none"].forces)
    at_all = unknowns(scenes["none"], faces)
    table = plain_table(
        f"{name}: {n} contacts, {faces if faces == 'cone' else f'{faces} faces'}", "effect", "unknowns", "added", "µs",
        "× none", "forces differ\nby, of the largest", "joints or contacts\nbeyond sticking",
    )  # fmt: skip
    rows = []
    for effect, grasp in scenes.items():
        s, size = answers[effect], unknowns(grasp, faces)
        difference = float(abs(s.forces[:n] - bare.forces).max() / abs(bare.forces).max())
        moving = sum(state != "sticking" for state in s.contact_state) + int((s.joint_yield != 0.0).sum())
        rows.append({
            "effect": effect, "unknowns": size, "added": size - at_all, "us": times[effect],
            "ratio": times[effect] / times["none"], "difference": difference,
        })  # fmt: skip
        if effect in ("soft fingers", ALL):
            table.add_section()
        table.add_row(
            effect, str(size), f"{size - at_all:+d}".replace("+0", "0"), f"{times[effect]:.0f}",
            f"{times[effect] / times['none']:.2f}", f"{difference:.2g}", str(moving),
        )  # fmt: skip
    console.print(table)
    return rows


def absent(console: Console, name: str, rounds: int) -> dict[str, float]:
    """Print and return what effects cost that are not named, and what those do that say nothing; 8 faces."""
    grasp, twin, still = made(name).grasp, made(name).grasp, neutral(name)
    times = median_times(
        {
            "solve": lambda: anew(grasp).solve(),
            "solve, once more": lambda: anew(twin).solve(),
            "neutral": lambda: anew(still).solve(),
            "assembly": lambda: assembly(grasp, 8),
            "assembly by hand": lambda: assembly_by_hand(grasp, 8),
        },
        10 * rounds,
    )
    ratios = {
        "its solve against itself: the noise": times["solve, once more"] / times["solve"],
        "its assembly against the four effects that it needs": times["assembly"] / times["assembly by hand"],
        "its solve, were two compliances and a command of zero named": times["neutral"] / times["solve"],
    }
    p, q = assembly(grasp, 8).scaled, assembly_by_hand(grasp, 8).scaled
    same = np.array_equal(p.M, q.M) and np.array_equal(p.q, q.q)
    table = plain_table("A scene that names no effect", "", "ratio", "µs")
    pairs = (("solve, once more", "solve"), ("assembly", "assembly by hand"), ("neutral", "solve"))
    for (what, ratio), (one, other) in zip(ratios.items(), pairs, strict=True):
        table.add_row(what, f"{ratio:.2f}", f"{times[one]:.1f} / {times[other]:.1f}")
    table.add_row("its problem, and that of the four effects", "same bits" if same else "DIFFERENT", "")
    console.print(table)
    return ratios


def neutral(name: str) -> hl.HandGrasp:
    """The bare grasp with effects named that change nothing."""
    g = made(name).grasp
    zero = [hl.ContactCompliance(0.0), hl.SoftWrist(np.zeros(6))]
    return changed(g.replace(joint_offset=np.zeros(g.state.hand.nv)), effects=tuple(zero))


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hand", choices=HANDS, default="five")
    parser.add_argument("--faces", default="8", help='a number, or "cone"')
    parser.add_argument("--rounds", type=int, default=400, help="calls of each")
    parser.add_argument("--json", type=Path, help="write everything measured to this file")
    o = parser.parse_args()
    console = opened(120)
    console.print(conditions(), highlight=False)
    faces = "cone" if o.faces == "cone" else int(o.faces)
    rows = measure(console, o.hand, faces, o.rounds)
    ratios = absent(console, o.hand, o.rounds)
    if o.json:
        o.json.write_text(json.dumps({"conditions": conditions(), "effects": rows, "absent": ratios}, indent=1))


if __name__ == "__main__":
    main()
