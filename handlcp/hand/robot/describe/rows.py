"""The rows of a description of a hand, as plain data."""

from __future__ import annotations

from typing import NamedTuple


class JointRow(NamedTuple):
    """One independent joint. kind : "revolute", "continuous", "prismatic". lower, upper [rad, m], ±inf: no end.

    torque_limit [N·m, N] : None where none is known. stiffness [N·m/rad] : its own, the diagonal of a matrix; None
    where none was said, or a transmission gives way in its place. fingertips : that it moves.
    """

    name: str
    kind: str
    lower: float
    upper: float
    torque_limit: float | None
    stiffness: float | None
    fingertips: tuple[str, ...]


class TipRow(NamedTuple):
    """One fingertip, or what could be one. link : that carries it. point : on the link, in its frame [m]; None: at its
    origin. taken : whether it is a fingertip of the hand. reason : why.
    """

    name: str
    link: str
    point: tuple[float, float, float] | None
    taken: bool
    reason: str


class CouplingRow(NamedTuple):
    """joint moves by factor × that of follows, plus offset [rad, m]."""

    joint: str
    follows: str
    factor: float
    offset: float


class LinkRow(NamedTuple):
    """One link. mass [kg] : 0 where the file says none. joint : that carries it, "" for the base. geometry :
    "collision", "visual" or "" for none; collision where it has both.
    """

    name: str
    mass: float
    joint: str
    geometry: str
