"""Every block of code of every page runs, and prints what the page shows."""

import pathlib

import pytest

from tests.docs.blocks import Page, blocks_of
from tests.docs.files import write_all
from tests.support.registry import definitions_of_a_test
from tests.support.texts import WRITE

ROOT = pathlib.Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
WITH_CODE = [page for page in PAGES if blocks_of(page.read_text(encoding="utf-8"))]


LONG = (  # seconds each, most of them many; hardware.md needs hands that are installed apart
    "envelope.md", "accuracy.md", "which_motors.md", "sweep.md", "optimise.md", "payload.md", "grip_strength.md",
    "published_tests.md", "complaints.md", "hardware.md", "brief.md", "find_a_grasp.md", "hand_in_ci.md",
    "whole_hand.md", "my_hand.md", "many_grasps.md", "to_share.md", "how_sure.md", "beside_mujoco.md",
)  # fmt: skip


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.long) if page.name in LONG else page for page in WITH_CODE],
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    if page != ROOT / "README.md":  # which is read, and pasted, where there is nothing
        write_all(tmp_path)
    monkeypatch.chdir(tmp_path)
    run = Page(page.name)
    with definitions_of_a_test():
        text = page.read_text(encoding="utf-8")
        if (new := run.run_all(text)) != text:  # only where pages are being written
            page.write_text(new, encoding="utf-8")


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
    monkeypatch.delenv(WRITE, raising=False)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match=why):
        Page("page.md").run_all(text)


def test_what_is_left_out_may_be_anything():
    page = "```python\nfor k in range(9):\n    print(k, 'of')\n```\n```text\n0 …\n…\n8 of\n```\n"
    assert Page("page.md").run_all(page) == page


def test_what_is_shown_in_full_is_written_anew(monkeypatch):
    page = "```python\nprint(1 / 4, end='  ')\n```\n\n```text\n0.3\n```\n"
    monkeypatch.setenv(WRITE, "1")
    assert Page("page.md").run_all(page) == page.replace("0.3", "0.25")
