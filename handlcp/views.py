"""The one step upward: answers offer their pictures, tables and pages, and grasps studies of theirs, which the rooms
above them make.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


def view(name: str) -> Callable[..., Any]:
    """A function of `handlcp.show.doors`, imported when it is called for: no answer pays for a picture nobody draws."""
    return getattr(import_module("handlcp.show.doors"), name)  # type: ignore[no-any-return]
