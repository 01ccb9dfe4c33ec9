"""Before the first test: throw away compiled kernels that are older than any kernel's source.

numba's cache looks at the file of the caller only; a kernel called from another file would go on running as it was.
"""

from __future__ import annotations

import pathlib

PACKAGE = pathlib.Path(__file__).parent.parent / "handlcp"


def pytest_configure(config):
    if hasattr(config, "workerinput"):  # the workers of a parallel run leave it to their controller
        return
    newest = max((p.stat().st_mtime for p in PACKAGE.rglob("*.py")), default=0.0)
    for compiled in PACKAGE.rglob("__pycache__/*.nb[ic]"):
        if compiled.stat().st_mtime < newest:
            compiled.unlink(missing_ok=True)
