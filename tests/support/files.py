"""How the package writes files, and smaller limits on what it reads of one, so that tests need no large files."""

from contextlib import contextmanager
from unittest.mock import patch

_WHERE = {
    "arrays": "handlcp.hand.find.postures.MAX_ARRAY_BYTES", "rows": "handlcp.design.sweep.table.MAX_TABLE_BYTES",
    "cells": "handlcp.design.sweep.table.MAX_TABLE_CELLS",
}  # fmt: skip


@contextmanager
def read_limits(**limits):
    """While it lasts. limits : arrays and rows [bytes], cells."""
    patches = [patch(_WHERE[name], limit) for name, limit in limits.items()]
    for one in patches:
        one.start()
    try:
        yield
    finally:
        for one in patches:
            one.stop()
