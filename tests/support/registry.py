"""Effects, friction laws and parameters that a test defines, and that nobody else should meet."""

from contextlib import contextmanager

from handlcp.contact.friction import law as _law
from handlcp.grasp.derivatives.parameter import parameter as _parameter
from handlcp.grasp.model import effect as _effect


@contextmanager
def definitions_of_a_test():
    """What is defined inside is forgotten behind."""
    kept = [(known, dict(known)) for known in (_effect._KINDS, _law._LAWS, _parameter._KINDS)]
    try:
        yield
    finally:
        for known, before in kept:
            known.clear()
            known.update(before)
