"""The page that follows numbers through the code says what the code does."""

from __future__ import annotations

import doctest
import os
import pathlib

import pytest

ROOT = pathlib.Path(__file__).parents[2]
PAGE = ROOT / "handlcp" / "README.md"


def test_every_number_on_the_page_is_what_the_package_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    failed, tried = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert tried > 15
    assert not failed
