"""Doors into the table of hands, and into what makers state of them."""

from handlcp.design.hardware.computed import computed
from handlcp.design.hardware.stated import Stated, stated
from handlcp.design.sweep.work import Done
from handlcp.design.table import make
from handlcp.design.table.catalogue import TABLE_HANDS, object_of, source, table_objects
from handlcp.design.table.pair import Asked, pair
from handlcp.design.table.result import HandTable

__all__ = [
    "TABLE_HANDS", "Asked", "Done", "HandTable", "Stated", "computed", "make", "object_of", "pair", "source", "stated",
    "table_objects",
]  # fmt: skip
