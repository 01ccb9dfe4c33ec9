"""Fingertip pads: their flexibility, in the axes of the tip frames, adds to that of the joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, per_name, psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.lcp.kernels.dense import kernel


class Pads:
    """Flexibility of n pads: blocks (n, 3, 3) [m/N], PSD, tip axes. isotropic : each is the same in all directions."""

    __slots__ = ("_every", "blocks", "isotropic")

    def __init__(self, blocks: Array) -> None:
        self.blocks, self._every = read_only(blocks), tuple(range(len(blocks)))
        self.isotropic = bool((blocks == blocks[:, :1, :1] * np.eye(3)).all())

    def in_axes(self, rotations: Callable[[], Array], tips: tuple[int, ...]) -> Array:
        """(m, 3, 3) of the m tips numbered `tips`; rotations makes what turns tip axes into those of the result, (m, 3,
        3), and is asked only where a pad is not the same in all axes.
        """
        pads = self.blocks if tips == self._every else read_only(self.blocks[list(tips)])
        if self.isotropic:
            return pads
        R = rotations()
        turned = R @ pads @ R.transpose(0, 2, 1)
        return read_only((turned + turned.transpose(0, 2, 1)) / 2)


@kernel
def tip_flexibility(jacobian: Array, root: Array, pads: Array) -> Array:
    """E = J K⁻¹ Jᵀ + pads (3m, 3m) [m/N]; jacobian (3m, nv), root as in `joint_flexibility`, pads (m, 3, 3)."""
    E = joint_flexibility(jacobian, root)
    for i in range(len(pads)):
        for a in range(3):
            for b in range(3):
                E[3 * i + a, 3 * i + b] += pads[i, a, b]
    return E


def read_pads(value: Any, tips: Sequence[str]) -> Pads:
    """From a number, (3,), (3, 3), (n, 3, 3) [m/N], or a mapping by tip name of the first three (others: rigid).

    Raises InputError for anything that is not positive semidefinite; UnknownName.
    """
    argument, n = "pad_flexibility", len(tips)
    if isinstance(value, Mapping):
        values = per_name(argument, value, tips, "a fingertip")
        return Pads(np.array([_pad(f"{argument}[{tip!r}]", values.get(tip, 0.0)) for tip in tips]))
    if dimensions(value) == 3:
        stack = array(argument, value, (n, 3, 3))
        return Pads(np.array([psd(f"{argument}[{i}]", block) for i, block in enumerate(stack)]))
    return Pads(np.tile(_pad(argument, value), (n, 1, 1)))


def _pad(argument: str, value: Any) -> Array:
    if isinstance(value, (str, bytes, bool)) or value is None:
        raise InputError(argument, "a flexibility [m/N]: a number, (3,) or (3, 3)", repr(value))
    a = array(argument, value, (), (3,), (3, 3))
    return psd(argument, np.eye(3) * a if a.ndim < 2 else a)
