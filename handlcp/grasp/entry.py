"""What the catalogue says of an effect: the same record for effects, for what is data, and for what a hand adds."""

from __future__ import annotations

import re
from dataclasses import dataclass

from handlcp.grasp.effects.base import Effect

__all__ = ["Entry", "entry_of"]


@dataclass(frozen=True, slots=True)
class Entry:
    """An effect in words; the page of effects is made of these.

    title, equation : as in `Effect`. when : who wants it, in one sentence. in_python : keyword arguments that ask for
    it, as Python; "": every grasp has it. in_file : the same as lines of a scene file (TOML); "": no scene file can.
    brings : its unknowns. source : where its law is from. module : dotted name of the module that holds it.
    """

    title: str
    equation: str
    when: str
    in_python: str
    in_file: str
    brings: str
    source: str
    module: str

    @property
    def in_short(self) -> str:
        """In Python, without what a mapping holds."""
        return re.sub(r"{.*}", "{…}", self.in_python)

    @property
    def file_keys(self) -> tuple[str, ...]:
        """What a scene file has for it: dotted keys, or a table with brackets about its name."""
        if self.in_file.startswith("["):
            return (self.in_file.partition("\n")[0],)
        return tuple(line.partition(" = ")[0] for line in self.in_file.splitlines())


def entry_of(kind: type[Effect]) -> Entry:
    """That of an effect, read off its class."""
    return Entry(
        kind.title, kind.equation, kind.when, kind.in_python, kind.in_file, kind.brings, kind.source, kind.__module__
    )
