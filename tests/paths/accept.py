"""Which numbers of seed 0 are grasps that hold their squeeze and weight, as far as they were tried."""

from __future__ import annotations

import json
from pathlib import Path

from tests.paths.clock import TookTooLong, at_most
from tests.paths.corpus import ACCEPTED, case_of, held

__all__ = ["ACCEPTED", "accept"]

LONGEST = 10.0  # a case that takes longer is left out [s]


def accept(numbers: int, out: Path) -> int:
    """Try the numbers below this that were not tried yet, and write those that hold."""
    known = json.loads(out.read_text(encoding="utf-8")) if out.is_file() else {"tried": 0, "0": []}
    for number in range(known["tried"], numbers):
        if _holds(number):
            known["0"].append(number)
        known["tried"] = number + 1
        if number % 50 == 49 or number == numbers - 1:
            out.write_text(json.dumps(known, separators=(",", ":")) + "\n", encoding="utf-8")
            print(f"{number + 1} tried, {len(known['0'])} hold", flush=True)
    return 0


def _holds(number: int) -> bool:
    try:
        with at_most(LONGEST):
            return held(case_of(0, number))
    except TookTooLong:
        return False
