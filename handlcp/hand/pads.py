"""Fingertip pads: flexibility in the tip frames' own axes, added to the flexibility of the joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, psd, read_only
from handlcp.errors import InputError
from handlcp.hand.stiffness import per_name

__all__ = ["Pads", "read_pads"]


class Pads:
    """Flexibility of n pads: `blocks` (n, 3, 3) [m/N], symmetric positive semidefinite, in tip axes. `isotropic`: each
    is the same in all directions.
    """

    __slots__ = ("_every", "_repeated", "blocks", "isotropic")

    def __init__(self, blocks: Array) -> None:
        self.blocks = read_only(blocks)
        first = blocks[:, 0, 0]
        self.isotropic = bool((blocks == first[:, None, None] * np.eye(3)).all())
        self._repeated, self._every = first.repeat(3), tuple(range(len(blocks)))

    def add_to(self, E: Array, rotations: Array, tips: Sequence[int]) -> None:
        """Add the pads numbered `tips` (m of them) to the diagonal blocks of E (3m, 3m); rotations (m, 3, 3) turn tip
        axes into those of E. Pads that are the same in all directions need no turning.
        """
        m = len(tips)
        if self.isotropic:
            pads = (
                self._repeated
                if m == len(self.blocks) and tips == self._every
                else self.blocks[list(tips), 0, 0].repeat(3)
            )
            E.reshape(-1)[:: 3 * m + 1] += pads
            return
        turned = rotations @ self.blocks[list(tips)] @ rotations.transpose(0, 2, 1)
        E.reshape(m, 3, m, 3)[range(m), :, range(m), :] += (turned + turned.transpose(0, 2, 1)) / 2


def read_pads(value: Any, tips: Sequence[str]) -> Pads:
    """From a number, (3,), (3, 3), (n, 3, 3), or a mapping by tip name of one of these [m/N]; tips left out are
    rigid.

    Raises InputError for anything that is not positive semidefinite; UnknownName.
    """
    argument, n = "pad_flexibility", len(tips)
    if isinstance(value, Mapping):
        values = per_name(argument, value, tips, "a fingertip")
        return Pads(np.array([_pad(f"{argument}[{tip!r}]", values.get(tip, 0.0)) for tip in tips]))
    if isinstance(value, (Sequence, np.ndarray)) and dimensions(value) == 3:
        stack = array(argument, value, (n, 3, 3))
        return Pads(np.array([psd(f"{argument}[{i}]", block) for i, block in enumerate(stack)]))
    return Pads(np.tile(_pad(argument, value), (n, 1, 1)))


def _pad(argument: str, value: Any) -> Array:
    if isinstance(value, (str, bytes, bool)) or value is None:
        raise InputError(argument, "a flexibility [m/N]: a number, (3,) or (3, 3)", repr(value))
    a = array(argument, value, (), (3,), (3, 3))
    return psd(argument, np.eye(3) * a if a.ndim < 2 else a)
