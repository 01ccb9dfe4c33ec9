"""A door into how libraries that are missing are named."""

from __future__ import annotations

from handlcp.errors import LIBRARY_REQUIREMENTS, missing_library, pip_command

__all__ = ["LIBRARY_REQUIREMENTS", "missing_library", "pip_command"]
