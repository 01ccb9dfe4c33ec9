"""Frozen dataclasses whose fields are made when first asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Self

Maker = Callable[[str], dict[str, Any]]


class Deferred:
    """Base of a dataclass without slots, most fields of which nobody reads. A default is an attribute of the class and
    found before anything is made, so that a field that is made later has none.

    Equality, repr, replace, copies and pickles ask for all fields, and find them.
    """

    @classmethod
    def deferred(cls, make: Maker, **known: Any) -> Self:
        """One with these fields; make(name) returns fields that are missing, `name` and what comes with it."""
        made = object.__new__(cls)
        made.__dict__.update(known, _make=make)
        return made

    if not TYPE_CHECKING:  # where any attribute would do, no checker would find a wrong one

        def __getattr__(self, name: str) -> Any:
            """A field that is not made yet. Two threads may both make it; either is right."""
            state, own = self.__dict__, type(self)
            if "_make" not in state or name not in own.__dataclass_fields__:
                raise AttributeError(f"{own.__name__!r} object has no attribute {name!r}", name=name, obj=self)
            state.update(state["_make"](name))
            return state[name]

    def __getstate__(self) -> dict[str, Any]:
        """All fields, and what was computed from them, but not what makes them."""
        state = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return state | {name: value for name, value in self.__dict__.items() if name != "_make"}
