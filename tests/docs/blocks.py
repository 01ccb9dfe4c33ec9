"""Blocks of code of a Markdown page, run in their order: one namespace a page, in a folder of its own.

    ```python     run; a ```text block after it is what it prints
    ```console    `$ handlcp …` is run, after && too, and what stands below is what it prints
    ```sh         commands without what they print; those of other programs have to name what exists
    ```yaml       steps of a workflow, whose `- run: …` are as of sh
    ```toml       written to the file that its first line names: `# my_scene.toml`

What is shown may leave out anything with "…": a line of its own stands for any lines. Blank lines and blanks at the end
of a line do not count. What is shown in full and is no longer what is printed is written anew into the pages by

    HANDLCP_WRITE_TEXTS=1 python -m pytest tests/docs && git diff
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
import pathlib
import re
import shlex
import tomllib
from typing import NamedTuple

from typer.testing import CliRunner

from handlcp.cli import app
from tests.support.texts import WRITE

__all__ = ["Block", "Page", "blocks_of"]

ROOT = pathlib.Path(__file__).parents[2]
_FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1[ ]*$", re.M | re.S)
PROGRAMS = {"pip", "pytest", "ruff", "mypy", "bash", "git", "sphinx-build", "source"}


class Block(NamedTuple):
    """What stands between two fences, and the line of the first."""

    language: str
    text: str
    line: int


def blocks_of(text: str) -> list[Block]:
    """All blocks of a page, directives such as {toctree} left out."""
    found = [Block(m[2].strip(), m[3], text.count("\n", 0, m.start()) + 1) for m in _FENCE.finditer(text)]
    return [b for b in found if not b.language.startswith("{")]


class Page:
    """One page being run in the working directory."""

    def __init__(self, name: str) -> None:
        self.name, self.namespace, self.printed = name, {"__name__": "__main__"}, ""
        self.ran: set[str] = set()  # commands of consoles
        self.written: list[tuple[str, str]] = []  # what was shown, and what is to be shown in its place

    def run_all(self, text: str) -> str:
        """Every block of a page, in order; the page as it should be."""
        for block in blocks_of(text):
            self.run(block)
        for shown, printed in self.written:
            text = text.replace(f"\n{shown}```", f"\n{printed}```", 1)
        return text

    def run(self, block: Block) -> None:
        """Run it, or compare it with what the block before it printed. Raises AssertionError, or what it raises."""
        where = f"{self.name}:{block.line}"
        if block.language == "python":
            self.printed = self._python(block, where)
        elif block.language == "text":
            self._compare(block.text, where)
        elif block.language == "toml":
            first = re.match(r"# (\w+\.toml)\n", block.text)
            assert first, f"{where}: which file is it?"
            pathlib.Path(first[1]).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            self._console(block, where)
        elif block.language in ("sh", "yaml"):
            for line in commands(block):
                for command in line.partition("  #")[0].split("&&"):
                    if command.strip() not in self.ran:  # it has been shown with what it prints
                        shell(command.strip(), where)
        else:
            raise AssertionError(f"{where}: nobody knows how to run {block.language!r}")

    def _python(self, block: Block, where: str) -> str:
        code = compile("\n" * block.line + block.text, self.name, "exec")
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(code, self.namespace)
        return out.getvalue()

    def _console(self, block: Block, where: str) -> None:
        parts = re.split(r"^\$ (.*)\n?", block.text, flags=re.M)
        assert not parts[0].strip(), f"{where}: output before the first command"
        for command, shown in zip(parts[1::2], parts[2::2], strict=True):
            for part in command.split("&&"):
                self.printed = shell(part.strip(), where)
                self.ran.add(part.strip())
            if shown.strip():
                self._compare(shown, where)

    def _compare(self, shown: str, where: str) -> None:
        """What is shown is what is printed."""
        kept = [r"(?:.*\n)*?" if s.strip() == "…" else re.escape(s).replace("…", ".*?") + r"\n" for s in lines(shown)]
        printed = "".join(f"{line}\n" for line in lines(self.printed))
        same = re.fullmatch("".join(kept), printed)
        if not same and os.environ.get(WRITE) == "1" and "…" not in shown:
            self.written.append((shown, printed))
        else:
            assert same, f"{where}: it prints\n{printed}"


def lines(text: str) -> list[str]:
    """Those that are not blank, without blanks at their ends."""
    return [line.rstrip() for line in text.splitlines() if line.strip()]


def commands(block: Block) -> list[str]:
    """Those of a block of sh, or of the steps of a workflow."""
    if block.language == "sh":
        return block.text.splitlines()
    return re.findall(r"^ *- run: (.*)$", block.text, re.M)


def shell(command: str, where: str) -> str:
    """Run a command of ours and return what it prints; of others, ask whether what they name is there."""
    words = shlex.split(command, comments=True)
    if not words:
        return ""
    if words == ["handlcp", "warm"] and os.environ.get("HANDLCP_KERNELS") == "interpreted":
        return ""  # which forbids it
    if words[0] == "handlcp":
        done = CliRunner().invoke(app, words[1:], env={"COLUMNS": "80", "NO_COLOR": "1"})
        assert done.exit_code in (0, 1), f"{where}: {command}: {done.output}"
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return done.stdout
    if words[0] == "python" and words[1] == "-m":
        assert importlib.util.find_spec(words[2]), f"{where}: no {words[2]}"
    elif words[0] == "python":
        assert (ROOT / words[1]).exists(), f"{where}: no {words[1]}"
    else:
        assert words[0] in PROGRAMS or "=" in words[0], f"{where}: {words[0]}?"
    extras = re.findall(r"\[([\w,]+)\]", command) if words[0] == "pip" else []
    known = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    assert {name for found in extras for name in found.split(",")} <= set(known), f"{where}: no such extra: {command}"
    return ""
