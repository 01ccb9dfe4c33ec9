"""A page in a real browser without a window: what its scripts made of it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import pytest

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_OPTIONS = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--virtual-time-budget=8000"]


class Opened(HTMLParser):
    """A page after its scripts ran. told : what they noted on the root. words : text by the id of what it stands in."""

    def __init__(self, source):
        super().__init__()
        self.source, self.told, self.words = source, dict[str, str](), dict[str, str]()
        self._open: list[tuple[str, str]] = []
        self.feed(source)

    def handle_starttag(self, tag, attrs):
        known = {name: value or "" for name, value in attrs}
        if tag == "html":
            self.told = {name.removeprefix("data-"): value for name, value in known.items()}
        if tag not in ("meta", "input", "img", "br", "wbr", "link"):
            self._open.append((tag, known.get("id", "")))

    def handle_endtag(self, tag):
        while self._open and self._open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        for _, name in self._open:
            if name:
                self.words[name] = self.words.get(name, "") + data

    def hidden(self, name):
        """Whether the element with this id is not shown."""
        found = re.search(rf'<[^>]*\bid="{name}"[^>]*>', self.source)
        assert found, name
        return bool(re.search(r"\bhidden\b", found.group()))


def data_of(page):
    """What the viewer of a page reads."""
    source = page.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', source, re.S)[1])


def opened(page, folder, at=""):
    """The page as a browser shows it; the test is skipped where there is no browser. at : behind the #."""
    browser = next((found for name in _BROWSERS if (found := shutil.which(name))), None)
    if browser is None:
        pytest.skip("no browser is installed: apt-get install chromium")
    address = page.resolve().as_uri() + (f"#{at}" if at else "")
    command = [browser, *_OPTIONS, f"--user-data-dir={folder / 'browser'}", "--dump-dom", address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=180, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return Opened(done.stdout)
