"""MuJoCo without its log: where nobody takes its warnings, it appends them to MUJOCO_LOG.TXT in the working folder."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_lock = threading.Lock()
_blocks = 0  # how many are open, in all threads
_before: Any = None  # who took the warnings before the first of them


@contextmanager
def without_mujoco_log() -> Iterator[None]:
    """Around calls of MuJoCo, or a decorator of them: its warnings are dropped, and no file is written. Whoever took
    them before takes them again afterwards. What goes wrong is found by looking at what MuJoCo computes.
    """
    from mujoco import get_mju_user_warning, set_mju_user_warning

    global _blocks, _before
    with _lock:
        if _blocks == 0:
            _before = get_mju_user_warning()
            set_mju_user_warning(_drop)
        _blocks += 1
    try:
        yield
    finally:
        with _lock:
            _blocks -= 1
            if _blocks == 0:
                set_mju_user_warning(_before)


def _drop(_: str) -> None:
    """Take a warning, and do nothing with it."""
