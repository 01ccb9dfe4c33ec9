"""Tests reach inside the package through `tests.support` alone, so that the house may move without them.

The public doors are the packages listed here and the names that they export. Behind them nothing is promised: no module
is imported, named in a text or reached as an attribute, and no name with an underscore is used.
"""

import ast
import importlib
import pathlib
import re

import pytest

TESTS = pathlib.Path(__file__).parent
PACKAGE = pathlib.Path(importlib.import_module("handlcp").__file__).parent
DOORS = {
    "handlcp",
    "handlcp.errors",
    "handlcp.scene",
    "handlcp.cli",
    "handlcp.lcp",
    "handlcp.grasp",
    "handlcp.hand",
    "handlcp.actuation",
    "handlcp.robot",
    "handlcp.geometry",
    "handlcp.simulator",
    "handlcp.viz",
    "handlcp.studies",
    "handlcp.studies.accuracy",
    "handlcp.studies.paper",
    "handlcp.studies.effect_catalogue",
}
SUPPORT = TESTS / "support"
FILES = [p for p in sorted(TESTS.rglob("*.py")) if p.parent != SUPPORT and p != pathlib.Path(__file__)]
# The second opinion on answers knows of the package no more than anyone does, and of its support only itself and how
# fingertips move
OPINION = ("friction_sets", "laws", "escapes", "hand_laws")


def dotted(file):
    parts = ("handlcp", *file.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(p) for p in PACKAGE.rglob("*.py")}


def is_inside(name):
    """Whether a dotted name is that of a module behind the doors, or of something in one."""
    parts = name.split(".")
    heads = {".".join(parts[:k]) for k in range(1, len(parts) + 1)}
    return bool(heads & (MODULES - DOORS))


def imported(node):
    """(dotted name, "") of modules that a statement imports; (module, name) of names out of one."""
    if isinstance(node, ast.Import):
        return [(a.name, "") for a in node.names]
    if isinstance(node, ast.ImportFrom) and not node.level:
        return [(node.module or "", a.name) for a in node.names]
    return []


def wrong_import(module, name):
    """Whether it opens no door: a module inside, a module where a door has no such name, a name that is private."""
    if module.partition(".")[0] != "handlcp":
        return False
    if module not in DOORS or name.startswith("_"):
        return True
    is_module = f"{module}.{name}" in MODULES - DOORS
    return is_module and name not in getattr(importlib.import_module(module), "__all__", ())


def chain(node):
    """["hl", "grasp", "pyramid"] of the expression hl.grasp.pyramid; None for anything that is no such chain."""
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return [node.id, *reversed(parts)] if isinstance(node, ast.Name) else None


def names_of_modules(tree):
    """What the file calls the package and its doors: {"hl": "handlcp"}."""
    called = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            called |= {a.asname or "handlcp": a.name if a.asname else "handlcp" for a in node.names
                       if a.name.partition(".")[0] == "handlcp"}  # fmt: skip
        elif isinstance(node, ast.ImportFrom) and node.module in DOORS:
            called |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names
                       if f"{node.module}.{a.name}" in DOORS}  # fmt: skip
    return called


def findings(source):
    """What a file does that only `tests.support` may do: lines with the words for it."""
    tree, found = ast.parse(source), []
    called = names_of_modules(tree)
    for node in ast.walk(tree):
        found += [(node.lineno, f"imports {m} {n}".strip()) for m, n in imported(node) if wrong_import(m, n)]
        if isinstance(node, ast.Attribute):
            parts = chain(node)
            if parts and parts[0] in called and is_inside(".".join([called[parts[0]], *parts[1:]])):
                found.append((node.lineno, f"reaches {'.'.join(parts)}"))
            owner = node.value.id if isinstance(node.value, ast.Name) else ""
            if re.match(r"_[a-z]", node.attr, re.IGNORECASE) and owner not in ("self", "cls"):
                found.append((node.lineno, f"uses .{node.attr}"))
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found += [
                (node.lineno, f"names {n}") for n in re.findall(r"\bhandlcp(?:\.\w+)+", node.value) if is_inside(n)
            ]
    return sorted(found)


def test_a_test_reaches_inside_through_support_alone():
    found = [(file, *f) for file in FILES for f in findings(file.read_text(encoding="utf-8"))]
    assert not found, "\n".join(f"{file.relative_to(TESTS)}:{line} {what}" for file, line, what in found)


@pytest.mark.parametrize("name", OPINION)
def test_the_second_opinion_shares_nothing_with_what_it_judges(name):
    source = (SUPPORT / f"{name}.py").read_text(encoding="utf-8")
    assert not findings(source)
    asked = {m for node in ast.walk(ast.parse(source)) for m, _ in imported(node) if m.startswith("tests")}
    assert asked <= {f"tests.support.{other}" for other in (*OPINION, "differences")}


@pytest.mark.parametrize(
    ("source", "what"),
    [
        (
            "from handlcp.grasp.verify.certifier import certify_candidate",
            "imports handlcp.grasp.verify.certifier certify_candidate",
        ),
        ("def test():\n    from handlcp.grasp import verify", "imports handlcp.grasp verify"),
        ("import handlcp.hand.robot", "imports handlcp.hand.robot"),
        ("from handlcp.hand import _needed", "imports handlcp.hand _needed"),
        ("import handlcp as hl\nhl.contact.friction.Cone()", "reaches hl.contact.friction"),
        ("grasp._placed()", "uses ._placed"),
        (
            "patch('handlcp.grasp.batch.first_stage._GRASPS_PER_TASK')",
            "names handlcp.grasp.batch.first_stage._GRASPS_PER_TASK",
        ),
    ],
)
def test_each_way_inside_is_seen(source, what):
    assert what in [words for _, words in findings(source)]


@pytest.mark.parametrize(
    "source",
    [
        "import handlcp as hl\nhl.grasp.Pyramid(8)\nhl.lcp.Proposal",
        "from handlcp.grasp import Verdict",
        "from handlcp.studies.accuracy import METHODS",
        "import sys\ncommand = [sys.executable, '-m', 'handlcp.cli']",
        "class A:\n    def go(self):\n        return self._x",
    ],
)
def test_public_doors_are_open(source):
    assert not findings(source)
