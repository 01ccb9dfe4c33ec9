"""The file of what callers rely on, and what differs from it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.public.answers import ANSWERS, COMMANDS, answer_keys, json_keys
from tests.public.commands import commands, file_keys
from tests.public.names import public_names

__all__ = ["FILE", "differences", "kept", "surface", "written"]

FILE = Path(__file__).with_name("surface.json")


def surface() -> dict[str, Any]:
    """All of it, as the package has it now, in about half a minute."""
    return {
        "names": public_names(),
        "answers": {name: answer_keys(name) for name in ANSWERS},
        "json": {name: json_keys(name) for name in COMMANDS},
        "commands": commands(),
        "files": file_keys(),
    }


def kept() -> dict[str, Any]:
    """All of it, as the file has it."""
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def written(surface: dict[str, Any]) -> str:
    """The text of the file."""
    return json.dumps(surface, indent=1, ensure_ascii=False) + "\n"


def differences(before: Any, now: Any) -> list[str]:
    """A line for all that is added, gone or changed, such as "gone: Grasp: solve (faces='cone')"."""
    old, new = lines(before), lines(now)
    changed = [place for place in old if place in new and new[place] != old[place]]
    return [
        *[f"gone: {place} {old[place]}" for place in old if place not in new],
        *[f"added: {place} {new[place]}" for place in new if place not in old],
        *[f"changed: {place} {old[place]} is now {new[place]}" for place in changed],
    ]


def lines(value: Any, place: str = "") -> dict[str, str]:
    """{place: what stands there}, the places joined by colons. The order of a list of columns does not count."""
    if isinstance(value, list):
        value = dict.fromkeys(value, "")
    if not isinstance(value, dict):
        return {place: value}
    if not value and place:
        return {place: "has nothing"}
    found: dict[str, str] = {}
    for name, inner in value.items():
        found |= lines(inner, f"{place}: {name}" if place else name)
    return found
