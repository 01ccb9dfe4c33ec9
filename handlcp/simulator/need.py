"""MuJoCo is an extra: imported when it is needed."""

from __future__ import annotations

from types import ModuleType

from handlcp.errors import Unsupported


def need_mujoco() -> ModuleType:
    """The package mujoco. Raises Unsupported where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise Unsupported("no simulation without MuJoCo: pip install handlcp[mujoco]") from None
    module: ModuleType = mujoco
    return module
