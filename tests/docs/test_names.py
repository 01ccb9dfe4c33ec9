"""The documentation has every public name and every effect, and its links lead somewhere."""

import importlib
import json
import pathlib
import re
import tomllib

import handlcp as hl
from handlcp.cli import app
from handlcp.grasp import effect_kinds
from handlcp.studies.effect_catalogue import entries
from tests.docs.front import lines

ROOT = pathlib.Path(__file__).parents[2]
DOCS = ROOT / "docs"
LINKED = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "handlcp" / "README.md",
          ROOT / "handlcp" / "grasp" / "effects" / "README.md", *sorted(DOCS.rglob("*.md"))]  # fmt: skip
SHORT = 160  # lines of the README


def text(page):
    return page.read_text(encoding="utf-8")


def test_the_readme_is_short():
    assert len(text(ROOT / "README.md").splitlines()) <= SHORT


def test_the_front_page_has_two_commands_which_install_and_solve_and_install_and_test_and_ci_runs_them():
    printed = re.findall(r"^\$ pip install \S+ && (\w+)", text(ROOT / "README.md"), re.M)
    assert printed == ["handlcp", "pytest"]
    ci = text(ROOT / ".ci" / "run")
    assert "install=${commands[1]%% && *} run=${commands[1]#* && }\n" in ci, "what needs no kernels stands between them"
    for command in ('"${commands[0]}"', '"$install"', '"$run"'):
        assert re.search(rf"^ *eval {re.escape(command)}$", ci, re.M)


def test_the_reference_has_every_public_name_once_and_no_other():
    pages = "\n".join(text(p) for p in sorted((DOCS / "api").glob("*.md")) if p.name != "own_parts.md")
    named = re.findall(r"^\.\. auto(?:class|function|exception):: (\w+)$", pages, re.M)
    assert sorted(named) == sorted(hl.__all__)


def test_the_page_of_own_parts_names_what_is_there():
    named = re.findall(r"^\.\. auto\w+:: handlcp\.(\w+)\.(\w+)$", text(DOCS / "api" / "own_parts.md"), re.M)
    assert len(named) > 5
    for room, name in named:
        assert hasattr(importlib.import_module(f"handlcp.{room}"), name)


def test_every_effect_that_is_asked_for_by_name_has_a_place_in_how_to_choose_or_in_the_reference():
    page = text(DOCS / "how_to_choose.md")
    asked = {kind.__name__ for kind in effect_kinds() if kind.file_key is not None}
    assert len(asked) > 6
    assert {name for name in asked if f"hl.{name}(" not in page} == set()
    assert len(entries()) == text(DOCS.parent / "handlcp" / "grasp" / "effects" / "README.md").count("\n### ")


def test_the_front_page_has_the_row_of_each_hand_in_the_table_that_is_kept():
    kept = json.loads(text(DOCS / "static" / "hands.json"))
    assert len(kept["packages"]) > 10
    assert "\n".join(lines(kept)) in text(DOCS / "index.md")


def test_every_extra_is_on_the_front_page():
    known = tomllib.loads(text(ROOT / "pyproject.toml"))["project"]["optional-dependencies"]
    rows = "".join(re.findall(r"^\| `.*?\|", text(DOCS / "index.md"), re.M))
    assert set(re.findall(r"`(\w+)`", rows)) == set(known)


def test_every_command_is_on_the_page_of_commands():
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert set(re.findall(r"^\| `handlcp (\w+)", text(DOCS / "command_line.md"), re.M)) == commands


def test_every_task_of_the_examples_is_named_on_a_page_of_the_tour():
    pages = "".join(text(p) for p in (DOCS / "tour").glob("*.md"))
    tasks = [p.name for p in (ROOT / "examples" / "tasks").glob("*.py")]
    assert len(tasks) > 5
    assert [name for name in tasks if f"`examples/tasks/{name}`" not in pages] == []


def test_every_page_is_in_the_contents():
    listed = {"index"}
    for index in (DOCS / "index.md", DOCS / "api" / "index.md"):
        home = index.parent.relative_to(DOCS).as_posix().removeprefix(".")
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", text(index), re.S):
            names = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed |= {f"{home}/{name}".lstrip("/") for name in names}
    pages = {p.relative_to(DOCS).with_suffix("").as_posix() for p in DOCS.rglob("*.md")}
    assert listed == pages


def test_links_lead_to_files_that_are_there():
    links = [(page, link) for page in LINKED for link in re.findall(r"\]\((?!https?:|#|mailto:)([^)#\s]+)", text(page))]
    assert links
    assert not [f"{page}: {link}" for page, link in links if not (page.parent / link).exists()]
