"""The rows of hands on the front page, as the table of hands that is kept beside it says them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

OBJECTS = "65 mm ball", "50 mm cylinder"
_LONG = 50  # characters
_NO = {"GIVEN UP": "given up", "NOT FOUND": "no grasp"}


def lines(table: Mapping[str, Any]) -> list[str]:
    """A line of Markdown for each hand, by name."""
    found = []
    for hand, package in sorted(table["packages"].items()):
        own = [[r for r in table["rows"] if (r["hand"], r["object"]) == (hand, name)] for name in OBJECTS]
        ends = next((r["gives_out"] for rows in own for r in rows if r["best"]), "–")
        ends = "several links slip" if len(ends) > _LONG and ends.endswith(" slip") else ends
        found.append(f"| {hand} | {package} | {' | '.join(map(_cell, own))} | {ends} |")
    return found


def _cell(rows: Sequence[Mapping[str, Any]]) -> str:
    best = next((r for r in rows if r["best"]), None)
    if best is None:
        return _NO["GIVEN UP" if any(r["verdict"] == "GIVEN UP" for r in rows) else "NOT FOUND"]
    high = best["payload_high_kg"]
    ends = f", {best['payload_low_kg']:g} to {high:g}" if high is not None else f", from {best['payload_low_kg']:g}"
    lost = "" if best["mujoco"] == "HELD" else "; MuJoCo loses it"
    return f"{best['payload_kg']:g} kg{ends} ({best['kind']}{lost})"
