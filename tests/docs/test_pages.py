"""Every block of code of every page runs, and prints what the page shows."""

from __future__ import annotations

import pathlib

import pytest

from tests.docs.blocks import Page, blocks_of
from tests.docs.files import write_all
from tests.support.registry import definitions_of_a_test

ROOT = pathlib.Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
WITH_CODE = [page for page in PAGES if blocks_of(page.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("page", WITH_CODE, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    write_all(tmp_path)
    monkeypatch.chdir(tmp_path)
    run = Page(page.name)
    with definitions_of_a_test():
        run.run_all(page.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("```python\nprint(1 / 4)\n```\n```text\n0.2\n```\n", "it prints\n0.25"),
        ("```python\nassert 1 > 2, 'so'\n```\n", "so"),
        ("```console\n$ handlcp --version\nhandlcp 9\n```\n", "it prints"),
        ("```console\n$ handlcp solve nowhere.toml\n```\n", "nowhere"),
        ("```sh\npython -m tests.benchmarks.nowhere\n```\n", "no tests.benchmarks.nowhere"),
        ("```sh\npip install '.[nothing]'\n```\n", "no such extra"),
        ("```toml\ntitle = 1\n```\n", "which file"),
        ("```\nx\n```\n", "nobody knows how"),
    ],
)
def test_a_page_that_is_wrong_fails(text, why, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match=why):
        Page("page.md").run_all(text)


def test_what_is_left_out_may_be_anything():
    run = Page("page.md")
    for block in blocks_of(
        "```python\nfor k in range(9):\n    print(k, 'of 9')\n```\n```text\n0 of …\n…\n8 of 9\n```\n"
    ):
        run.run(block)
    assert run.printed.startswith("0 of")
