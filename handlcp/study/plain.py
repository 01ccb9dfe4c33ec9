"""Results for JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


def pick(source: Any, *names: str, **renamed: str) -> dict[str, Any]:
    """Attributes of `source` by name. renamed : key in the result = name of the attribute."""
    return {key: getattr(source, name) for key, name in ({name: name for name in names} | renamed).items()}


def plain(value: Any) -> Any:
    """The value with arrays as lists, numpy's numbers as Python's, and None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(value: Any, ascii_only: bool = False) -> str:
    """The value as JSON; numbers that are not finite are null."""
    return json.dumps(plain(value), indent=2, ensure_ascii=ascii_only, allow_nan=False)
