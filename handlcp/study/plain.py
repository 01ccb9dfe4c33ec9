"""Results as JSON has them: plain values under the keys that they are known by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

__all__ = ["pick", "plain"]


def pick(source: Any, *names: str, **renamed: str) -> dict[str, Any]:
    """Attributes by name. renamed : key in the result = name of the attribute."""
    return {key: getattr(source, name) for key, name in ({name: name for name in names} | renamed).items()}


def plain(value: Any) -> Any:
    """Arrays become lists, numpy's numbers Python's, numbers that are not finite None."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
