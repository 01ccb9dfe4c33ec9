"""What the package says about compiling."""

from __future__ import annotations

from handlcp.lcp.compiler.messages import silent

__all__ = ["silent"]
