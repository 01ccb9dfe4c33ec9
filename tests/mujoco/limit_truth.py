"""What MuJoCo says of a load that grows, as rows of a file: the engine is compared with them in seconds.

`limits.json` has the versions and settings with which its rows were computed, and a row for each case.
"""

from __future__ import annotations

import pathlib
from dataclasses import asdict, dataclass
from typing import Any

import mujoco
import numpy as np

from handlcp.simulator import SimulatorSettings
from tests.mujoco.case import read_rows, write_rows

FILE = pathlib.Path(__file__).with_name("limits.json")
SHARES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)  # of the load, where motion is kept
DIGITS = 5
LENGTH = 0.03  # [m] of contacts from the reference: a turn moves them by it


@dataclass(frozen=True, eq=False)
class Truth:
    """factor, jump, hops, first_at, joint, slides, gone, squeezed : as in `SimulatedLimit`. most : how far its load
    grew. factors (m,), motion (m, 6) : of the track, at some factors, before and after the jump among them.
    """

    factor: float
    jump: float
    hops: Any
    first_at: float
    joint: str
    slides: tuple[str, ...]
    gone: tuple[str, ...]
    squeezed: Any
    most: float
    factors: Any
    motion: Any
    seconds: float

    @classmethod
    def of(cls, limit, most):
        """What of a simulation is kept."""
        track = limit.track
        end = min(limit.factor, most)
        kept = [*(share * end for share in SHARES), *track.factors[-1:]]
        if np.isfinite(limit.jump):
            before = track.factors < limit.jump
            kept += [*track.factors[before][-1:], *track.factors[~before][:1]]
        factors = np.array(sorted({float(f) for f in kept if len(track.factors) and f <= track.factors[-1]}))
        motion = np.array([track.motion_at(f) for f in factors]).reshape(-1, 6)
        return cls(
            limit.factor, limit.jump, limit.hops, limit.first_at, limit.joint, limit.slides, limit.gone,
            limit.squeezed, most, factors, motion, limit.seconds,
        )  # fmt: skip

    def at(self, factor):
        """(6,) how far the object had moved since the load began to grow [m, rad]."""
        if not (len(self.factors) and factor <= self.factors[-1]):
            return np.full(6, np.nan)
        return np.array([np.interp(factor, self.factors, column) for column in self.motion.T])

    def hop_at(self, factor, near):
        """The factor of the largest hop about this factor, if none before was half as large; inf: there is none."""
        sizes = self.hops[:, 1] + LENGTH * self.hops[:, 2]
        about, before = abs(self.hops[:, 0] - factor) <= near * factor, self.hops[:, 0] < (1.0 - near) * factor
        if not about.any() or max(sizes[before], default=0.0) > 0.5 * sizes[about].max():
            return np.inf
        return float(self.hops[about, 0][np.argmax(sizes[about])])

    def row(self):
        """As JSON; null for what never happened."""
        return {
            "factor": _number(self.factor), "jump": _number(self.jump), "hops_m_rad": _numbers(self.hops),
            "first_at": _number(self.first_at), "most": _number(self.most), "joint": self.joint,
            "slides": list(self.slides), "gone": list(self.gone), "squeezed_N": _numbers(self.squeezed),
            "factors": _numbers(self.factors, 8), "motion_m_rad": _numbers(self.motion),
            "seconds": round(self.seconds, 1),
        }  # fmt: skip

    @classmethod
    def read(cls, row):
        """The opposite of `row`."""
        factor, jump, first_at = (np.inf if row[k] is None else row[k] for k in ("factor", "jump", "first_at"))
        hops = np.array(row.get("hops_m_rad", [])).reshape(-1, 3)  # rows from before hops were noted have none
        return cls(
            factor, jump, hops, first_at, row["joint"], tuple(row["slides"]), tuple(row["gone"]),
            np.array(row["squeezed_N"]), row["most"], np.array(row["factors"]),
            np.array(row["motion_m_rad"]).reshape(-1, 6), row["seconds"],
        )  # fmt: skip


def stored():
    """By the titles of the cases; nothing without the file."""
    return {title: Truth.read(row) for title, row in read_rows(FILE).items()}


def store(title, truth):
    """Put one row into the file."""
    rows = dict(sorted((read_rows(FILE) | {title: truth.row()}).items()))
    write_rows(FILE, rows, {"mujoco": mujoco.__version__, "settings": asdict(SimulatorSettings())})


def _number(value, digits=8):
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


def _numbers(values, digits=DIGITS):
    return [_numbers(v, digits) for v in values] if np.ndim(values) else _number(float(values), digits)
