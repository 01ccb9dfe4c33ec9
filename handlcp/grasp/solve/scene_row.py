"""A scene as a row of numbers: the arrays of `Given`, one after the other, then the limits (n,) of its contacts.

The layout is known here alone; rows are written and read by the names of these arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from inspect import unwrap

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.friction import Section
from handlcp.grasp.model.grasp_matrix import Given
from handlcp.grasp.model.scene import Scene
from handlcp.lcp.kernels.dense import kernel


@kernel
def read_scene(scene: Array, n: int, soft: int, dof: int) -> tuple[Given, Array]:
    """The arrays of a scene with n contacts, some of them soft, and its limits (n,), as views of its row."""
    c = 3 * n + soft
    a = 12 * n
    b = a + c * c
    d = b + 2 * c
    e = d + 3 * soft + 6
    f = e + 6 * dof
    return Given(
        scene[: 3 * n].reshape(n, 3), scene[3 * n : a].reshape(n, 3, 3), scene[a:b].reshape(c, c), scene[b : b + c],
        scene[b + c : d], scene[d : e - 6].reshape(3, soft), scene[e - 6 : e - 3], scene[e - 3 : e],
        scene[e:f].reshape(dof, 6),
    ), scene[f:]  # fmt: skip


def views(row: Array, n: int, soft: int, dof: int) -> tuple[Given, Array]:
    """As `read_scene`, of a row that is written to."""
    found: tuple[Given, Array] = unwrap(read_scene)(row, n, soft, dof)
    return found


def width(scene: Scene) -> int:
    """How many numbers a scene is."""
    return sum([a.size for a in scene.given]) + scene.n


def write_row(scene: Scene, section: Section, row: Array) -> None:
    """Write a scene's numbers into a row."""
    np.concatenate((*scene.given, scene.limits(section)), axis=None, out=row)


def write_rows(count: int, width: int, **fields: Sequence[Array] | Array) -> Array:
    """(m, width) read-only: rows of m scenes, field by field. Each field of `Given`, and `limits`, is an array (m, …),
    or one for each scene; where all of these are one and the same, as after `replace`, it is copied once.
    """
    out, at = np.empty((count, width)), 0
    for own in [fields[name] for name in (*Given._fields, "limits")]:
        first = own[0]
        if isinstance(own, np.ndarray):
            whole = own.reshape(count, -1)
        elif all([a is first for a in own]):
            whole = first.reshape(1, -1)
        else:
            whole = np.concatenate(own).reshape(count, -1)
        out[:, at : at + first.size] = whole
        at += first.size
    return read_only(out)
