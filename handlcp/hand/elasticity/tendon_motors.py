"""Motors that draw tendons in: which of them each tendon has, and what cannot be.

A spool of radius r behind a gear n makes n / r newtons of tension of each newton metre of its motor. With that as
reduction, a `Motor` says in newtons at the tendon what it says of a joint in newton metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.hand.elasticity.motor import Drives, read_motors

_ARGUMENT = "Tendons.motors"


def read_tendon_motors(value: Any, tendons: Sequence[str], pretension: Array) -> Drives | None:
    """From a `Motor` for every tendon, a mapping of tendon names to motors (others: none), or None. pretension (t,) :
    which a motor has to make and to hold [N]. Raises InputError, UnknownName.
    """
    drives = read_motors(value, tendons, _ARGUMENT, "tendon")
    if drives is None:
        return None
    for name, motor, begun in zip(tendons, drives.of, pretension.tolist(), strict=True):
        if motor is None:
            continue
        if motor.stiffness is not None:
            expected = "a Motor without stiffness: Tendons.stiffness says it"
            raise InputError(f"{_ARGUMENT}[{name!r}]", expected, f"Motor(stiffness={motor.stiffness:g})")
        if min(motor.closes, motor.holds) < begun < np.inf:
            came = f"one that closes with {motor.closes:g} N and holds {motor.holds:g} N for good"
            raise InputError(
                f"{_ARGUMENT}[{name!r}]", f"a motor that makes and holds the pretension, {begun:g} N", came
            )
    return drives


def check_driven_once(arms: Array, tendons: Drives | None, drives: Drives | None, joints: Sequence[str]) -> None:
    """Raises InputError for motors of joints that tendons with motors move. arms (t, nv) : R. tendons, drives : the
    motors of tendons and joints.
    """
    if tendons is None or drives is None:
        return
    own = np.array([motor is not None for motor in tendons.of])
    moved = arms[own].any(axis=0)
    both = [j for j, motor, twice in zip(joints, drives.of, moved.tolist(), strict=True) if twice and motor is not None]
    if both:
        raise InputError("motors", "no motor of a joint that a tendon with a motor moves", ", ".join(both))
