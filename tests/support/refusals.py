"""Calls that are refused, and which argument the error names."""

import pytest

from handlcp.errors import InputError


def refused(argument, call, *given, error=InputError, match=None, **named):
    """The error of a call with these arguments that is refused because of one of them."""
    with pytest.raises(error, match=match) as caught:
        call(*given, **named)
    assert caught.value.argument == argument
    return caught.value
