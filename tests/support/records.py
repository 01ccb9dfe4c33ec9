"""Doors into records: what they say of themselves, and every class of them."""

import inspect
import pkgutil
from collections.abc import Iterable, Sequence
from dataclasses import is_dataclass
from functools import cached_property
from importlib import import_module

import handlcp
from handlcp.lazy_property import lazy_property
from handlcp.record import Record, parse_entry


def kinds():
    """The names of all classes of records, but for those that others are made of."""
    names = set[str]()
    for module in pkgutil.walk_packages(handlcp.__path__, "handlcp."):
        if not module.name.endswith("__main__"):
            found = vars(import_module(module.name)).values()
            own = [v for v in found if isinstance(v, type) and v.__module__ == module.name]
            names |= {v.__name__ for v in own if issubclass(v, Record)}
    return names - {"Record"}


def described(record):
    """Each of its entries, and what that is; () where it makes its dictionary itself."""
    told = record.entries is not None or is_dataclass(record)
    return [(one, one.value_in(record)) for one in map(parse_entry, record._entry_lines() if told else ())]


def doc_of(record, name):
    """What the property says, or of a field what its class says."""
    found = inspect.getattr_static(type(record), name, None)
    own = found if isinstance(found, (property, lazy_property, cached_property)) else type(record)
    return str(own.__doc__)


def within(value):
    """The record, and all that it tells of."""
    if isinstance(value, Record):
        yield value
        told = [v for _, v in described(value)]
        value = list(value) if isinstance(value, Sequence) and not told else told
    elif isinstance(value, dict):
        value = value.values()
    if isinstance(value, Iterable) and not isinstance(value, str) and not hasattr(value, "tolist"):
        for v in value:
            yield from within(v)
