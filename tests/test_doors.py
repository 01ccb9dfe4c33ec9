"""Tests use no name that the package calls private, and the second opinion shares nothing with what it judges.

A test imports what it needs from where that is in the package; `tests.support` holds builders of scenes and hands,
oracles, and what tests put in the place of something inside.
"""

import ast
import pathlib
import re

import pytest

TESTS = pathlib.Path(__file__).parent
SUPPORT = TESTS / "support"
FILES = [p for p in sorted(TESTS.rglob("*.py")) if p.parent != SUPPORT and p != pathlib.Path(__file__)]
# Of the package these know no more than anyone does, and of the support themselves and how fingertips move
OPINION = ("friction_sets", "laws", "escapes", "hand_laws")


def imported(tree):
    """(line, module, name) of each name that is imported from a module; "" for the module itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, a.name, "") for a in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield from ((node.lineno, node.module or "", a.name) for a in node.names)


def private_uses(source):
    """Lines that name something private of the package: imported, read of an object, or written in a text."""
    tree = ast.parse(source)
    found = [(line, f"{m}.{n}") for line, m, n in imported(tree) if re.search(r"^handlcp(\..*)?\._", f"{m}.{n}")]
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and re.match(r"_[a-z]", node.attr, re.IGNORECASE):
            owner = node.value.id if isinstance(node.value, ast.Name) else ""
            found += [(node.lineno, f".{node.attr}")] if owner not in ("self", "cls") else []
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found += [(node.lineno, name) for name in re.findall(r"\bhandlcp(?:\.\w+)*\._\w+", node.value)]
    return sorted(found)


def test_no_test_uses_what_is_private():
    found = [(file, *use) for file in FILES for use in private_uses(file.read_text(encoding="utf-8"))]
    assert not found, "\n".join(f"{file.relative_to(TESTS)}:{line} uses {what}" for file, line, what in found)


@pytest.mark.parametrize("name", OPINION)
def test_the_second_opinion_shares_nothing_with_what_it_judges(name):
    source = (SUPPORT / f"{name}.py").read_text(encoding="utf-8")
    modules = {m for _, m, _ in imported(ast.parse(source))}
    assert {m for m in modules if m.startswith("handlcp")} <= {"handlcp"}
    others = (*OPINION, "differences")
    assert {m for m in modules if m.startswith("tests")} <= {f"tests.support.{other}" for other in others}
    assert not private_uses(source)


@pytest.mark.parametrize(
    "source",
    ["from handlcp.hand import _needed", "import handlcp as hl\nhl.grasp._placed()", "grasp._placed()",
     "patch('handlcp.grasp.batch.grasp_batch._GRASPS_PER_TASK')"],
)  # fmt: skip
def test_each_private_use_is_seen(source):
    assert private_uses(source)
    assert not private_uses("class A:\n    def go(self):\n        return self._x")
