"""What somebody sees who looks at the package first: its help, its names, how to get what is missing."""

import pathlib
import re

import pytest

import handlcp as hl
from handlcp.errors import LIBRARY_REQUIREMENTS, missing_library, pip_command
from tests.docs.blocks import Page, blocks_of
from tests.support.registry import definitions_of_a_test

ROOT = pathlib.Path(__file__).parents[1]
SAYS, QUOTES = (".py", ".md", ".ipynb", ".yml", ".toml"), ("CHANGELOG.md", "test_front_door.py")
TEXTS = [p for p in sorted(ROOT.rglob("*")) if p.suffix in SAYS and p.name not in QUOTES]
TEXTS += [ROOT / ".ci" / "run", ROOT / ".ci" / "suite"]


def test_dir_is_the_public_names_and_those_of_every_module():
    shown = dir(hl)
    assert set(hl.__all__) <= set(shown)
    assert [name for name in set(shown) - set(hl.__all__) if not re.fullmatch("__[a-z]+__", name)] == []
    assert not [name for name in shown if name.startswith("_") and not name.startswith("__")]


def test_the_help_opens_with_a_hand_that_holds_as_the_readme_does(capsys):
    code = re.search(r"^import handlcp as hl$.*?^print\(grasp\.check\(\)\).*?$", hl.__doc__, re.M | re.S)[0]
    exec(code, {})
    assert capsys.readouterr().out.startswith("HELD: ")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [line for line in code.splitlines() if line and line.partition("  #")[0] not in readme] == []


def test_the_block_of_the_readme_about_your_own_hand_runs_alone_in_an_empty_folder(tmp_path, monkeypatch):
    (block,) = [b for b in blocks_of((ROOT / "README.md").read_text(encoding="utf-8")) if "Hand.from_urdf(" in b.text]
    monkeypatch.chdir(tmp_path)
    asked = []
    monkeypatch.setattr(hl, "evaluate", lambda *what: asked.append(what) or "evaluated", raising=False)  # half a minute
    page = Page("README.md")
    with definitions_of_a_test():
        page.run(block)
    assert "finger_1_proximal" in page.printed
    assert page.printed.endswith("evaluated\n")
    assert len(asked) == 1
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------- how to get what is missing
def test_what_is_said_to_be_installed_is_what_the_extras_have():
    import tomllib

    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    every = {one for requirements in extras.values() for one in requirements}
    assert set(LIBRARY_REQUIREMENTS.values()) <= every


@pytest.mark.parametrize("library", LIBRARY_REQUIREMENTS)
def test_the_command_names_the_library_in_quotes(library):
    assert re.fullmatch(r"pip install '[\w-]+>=[\d.]+'", pip_command(library))
    error = missing_library("this needs it", library)
    assert isinstance(error, hl.Unsupported)
    assert str(error) == f"this needs it: {pip_command(library)}"


def test_nothing_says_to_install_this_package_from_an_index_or_without_quotes():
    index, unquoted = (r"pip install(?: -\S+)* ['\"]?handlcp(?![-\w./])", r"pip install(?: -\S+)* \S*(?<!['\"])\.\[")
    assert re.findall(index, "pip install -e 'handlcp[plot]'")
    assert re.findall(unquoted, "pip install .[plot]")
    said = {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in TEXTS}
    assert [name for name, text in said.items() if re.search(index, text)] == []
    assert [name for name, text in said.items() if re.search(unquoted, text)] == []
