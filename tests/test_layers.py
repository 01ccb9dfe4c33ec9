"""Imports run one way: cli → show → study → scene → hand → grasp → lcp → check → lazy, errors, tolerances, version."""

from __future__ import annotations

import ast
import pathlib

import pytest

import handlcp

ROOT = pathlib.Path(handlcp.__file__).parent
ORDER = ["version", "tolerances", "errors", "lazy", "check", "lcp", "grasp", "hand", "scene", "study", "show", "cli"]
FILES = sorted(p for p in ROOT.rglob("*.py") if p.parent != ROOT or p.stem in ORDER)


def dotted(file):
    parts = ("handlcp", *file.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(p) for p in ROOT.rglob("*.py")}


def imports(nodes):
    """Names of handlcp modules that statements import; `from package import module` is an import of the module."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.startswith("handlcp"))
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("handlcp"):
            whole = [f"{node.module}.{a.name}" for a in node.names]
            yield from (name if name in MODULES else node.module for name in whole)


@pytest.mark.parametrize("file", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_room_imports_only_rooms_below_it(file):
    mine = dotted(file).split(".")[1]
    for name in imports(ast.walk(ast.parse(file.read_text()))):
        assert name != "handlcp", f"{file} imports the top level"
        assert ORDER.index(name.split(".")[1]) <= ORDER.index(mine), f"{file} imports {name}"


@pytest.mark.parametrize("file", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_only_show_imports_matplotlib(file):
    source = file.read_text()
    if file.relative_to(ROOT).parts[0] != "show":
        assert "import matplotlib" not in source
        assert "from matplotlib" not in source


def test_no_import_goes_in_a_circle():
    graph = {dotted(p): set(imports(ast.parse(p.read_text()).body)) - {dotted(p)} for p in ROOT.rglob("*.py")}
    done = set()

    def visit(name, path):
        assert name not in path, " → ".join([*path, name])
        if name not in done:
            for other in graph.get(name, ()):
                visit(other, [*path, name])
            done.add(name)

    for name in graph:
        visit(name, [])
