"""The architecture page and the page for contributors name folders, files and names that exist."""

from __future__ import annotations

import ast
import pathlib
import pkgutil
import re

import pytest

ROOT = pathlib.Path(__file__).parents[2]
PACKAGE = ROOT / "handlcp"
PAGES = ("handlcp/README.md", "CONTRIBUTING.md")
OTHERS = {"text", "name", "h"}  # a fence of Markdown, a row of a docstring, what a block of the page calls a result


def page_text(page: str) -> str:
    """A page without its blocks of code, which are run by a test of their own."""
    return re.sub(r"^```(?!\n).*?^```$", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.M | re.S)


def quoted(text: str) -> list[str]:
    return re.findall(r"(?<!`)`([^`]+)`(?!`)", text)


def exists(path: str) -> bool:
    """Whether a path stands at the top of the checkout, in the package or among the tests."""
    return any((folder / path).exists() for folder in (ROOT, PACKAGE, ROOT / "tests"))


def package_names() -> set[str]:
    """Everything that the package calls something: folders, files, classes, functions, arguments and attributes."""
    names: set[str] = set()
    for file in PACKAGE.rglob("*.py"):
        names |= {file.stem, file.parent.name}
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            match node:
                case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                    names.add(name)
                case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                    names.add(name)
    return names


def rooms() -> list[tuple[list[str], list[str]]]:
    """Rows of the table of rooms: the folders, and the files to read first."""
    rows = re.findall(r"^\|(.*?)\|.*\|(.*?)\|$", page_text(PAGES[0]).partition("\n## What they")[0], re.M)
    return [(quoted(first), quoted(last)) for first, last in rows if quoted(first)]


def test_every_room_is_a_folder_and_has_the_files_that_one_reads_first():
    assert len(rooms()) > 25
    for folders, files in rooms():
        assert [name for name in folders if not (PACKAGE / name).exists()] == []
        missing = [f for f in files if not any((PACKAGE / room / f).is_file() for room in folders)]
        assert missing == [], f"{missing} of {folders}"


def test_every_folder_of_the_package_stands_in_a_row_of_the_table():
    named = {room for folders, _ in rooms() for room in folders}
    top = {f.parent.name for f in PACKAGE.glob("*/__init__.py")}
    assert {t for t in top if not any(n == t or n.startswith(f"{t}/") for n in named)} == set()


@pytest.mark.parametrize("page", PAGES)
def test_every_path_that_a_page_names_exists(page):
    text = page_text(page).partition("\n## What they")[2] or page_text(page)
    paths = [q for q in quoted(text) if re.fullmatch(r"[\w.]+(/[\w.]+)+|\w+\.(py|cff)", q)]
    assert len(paths) > 10
    assert [path for path in paths if not exists(path)] == []


@pytest.mark.parametrize("page", PAGES)
def test_every_name_that_a_page_names_is_one_of_the_package(page):
    known = package_names() | OTHERS
    names = [q for q in quoted(page_text(page)) if re.fullmatch(r"@?[A-Za-z_]\w*(\.[a-z_]+)*(\(.*\))?", q)]
    names = [q for q in names if not re.search(r"\.(py|cff)$", q) and not exists(q)]
    assert len(names) > 2
    parts = {part for name in names for part in name.lstrip("@").partition("(")[0].split(".")}
    assert sorted(parts - known) == []


def test_every_function_that_the_drawing_of_one_solve_names_is_one_of_the_package():
    text = (ROOT / PAGES[0]).read_text(encoding="utf-8").partition("\n## One solve")[2].partition("\n## ")[0]
    drawn = text.partition("```\n")[2].partition("```")[0]
    names = set(re.findall(r"\b\w+_\w+\b", drawn)) - {"NOT_HOLDABLE", "NO_EQUILIBRIUM"}
    assert len(names) > 20
    assert sorted(names - package_names()) == []


def test_every_file_of_the_package_that_the_documentation_names_exists():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    named = {path for page in pages for path in re.findall(r"\bhandlcp/[\w/.]*\w", page.read_text(encoding="utf-8"))}
    assert len(named) > 3
    assert sorted(path for path in named if not (ROOT / path).exists()) == []


def test_every_dotted_name_of_the_package_that_the_documentation_names_exists():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    named = {n for page in pages for n in re.findall(r"\bhandlcp(?:\.\w+)+", page.read_text(encoding="utf-8"))}
    assert len(named) > 10
    assert sorted(name for name in named if not resolves(name)) == []


def resolves(name: str) -> bool:
    """Whether a dotted name leads to a module, a class or a function."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True
