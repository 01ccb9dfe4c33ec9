"""A door into how libraries that are missing are named."""

from __future__ import annotations

from handlcp.extras import LIBRARIES, missing, pip_install

__all__ = ["LIBRARIES", "missing", "pip_install"]
