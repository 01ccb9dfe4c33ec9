"""`JointOffset`: squeeze as motors make it: joints commanded beyond where they stand preload the contacts.

    d -= J δq

The motors pull towards q + δq while the hand stands at q. Left alone the tips would move by J δq; the object's motion
relative to them falls short by as much. It is data, like any preload. δq is given as it is, or made from a depth or a
force at the fingertips; what of that the joints cannot make is a `CommandReach`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.model.contact import Placement
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.scene import Scene
from handlcp.words import format_force, format_length, format_percent, list_names

_MENTIONED_SHARE = 1e-3  # shares below this are not worth a word
OVERLAP_TOLERANCE = 1e-6  # [m] overlaps of a hand's fingertips up to this are what is left of touching


@dataclass(frozen=True, slots=True, eq=False)
class CommandReach:
    """What was asked of k fingertips, and what of it is out of the joints' reach.

    what : "squeeze", "grip force", "preload" or "overlap" (of fingertip and object, in the posture). names : (k,).
    asked : (k,) depth along the normal of a squeeze or an overlap, length of a preload's motion [m]; normal force [N].
    missing : (k,) how much of it no command of the joints makes, same unit.
    sideways : (k,) what comes with the rest along the surface, same unit: how far a squeeze moves the tip, the force of
        a grip. 0 for a preload and an overlap.
    carried : whether the grasp is solved with the missing part all the same, as a preload that only the pads can take
    up (preload, overlap), or without it (squeeze, grip force).
    """

    what: str
    names: tuple[str, ...]
    asked: Array
    missing: Array
    sideways: Array
    carried: bool

    @property
    def unit(self) -> str:
        """The unit of the arrays, "m" or "N"."""
        return "N" if self.what == "grip force" else "m"

    @property
    def share(self) -> Array:
        """The missing part of what was asked, (k,) from 0 to 1; 1 where nothing was asked and the finger is moved."""
        whole = np.maximum(self.asked, self.missing)
        return read_only(np.divide(self.missing, whole, out=np.zeros(len(whole)), where=whole > 0.0))

    @property
    def complete(self) -> bool:
        """Whether nothing worth a word is out of reach."""
        return bool(self.missing.max(initial=0.0) <= _MENTIONED_SHARE * self.asked.max(initial=0.0))

    def __str__(self) -> str:
        """Say in one sentence how much of the command is reached."""
        say = format_force if self.unit == "N" else format_length
        whole = f"{'an' if self.what == 'overlap' else 'a'} {self.what}"
        if self.complete:
            text = f"{whole} of {_format_range(self.asked, say)}"
            k = int(np.argmax(self.sideways >= (1 - 1e-9) * self.sideways.max()))  # the first of equals
            if self.sideways[k] > _MENTIONED_SHARE * self.asked.max():
                how = "presses" if self.unit == "N" else "moves"
                text += f"; {self.names[k]} {how} sideways, too, by {say(float(self.sideways[k]))}"
            return text
        parts = [
            f"{say(part)} at {name} ({format_percent(share)})"
            for name, part, share in zip(self.names, self.missing.tolist(), self.share.tolist(), strict=True)
            if part > _MENTIONED_SHARE * self.asked.max()
        ]
        end = ": a preload that only the pads give way to" if self.carried else ""
        return f"of {whole} of {_format_range(self.asked, say)} the motors cannot make {list_names(parts)}{end}"


def _format_range(values: Array, say: Callable[[float], str]) -> str:
    """One number where all are alike."""
    least, most = float(values.min()), float(values.max())
    return say(most) if most - least <= _MENTIONED_SHARE * most else f"{say(least)} to {say(most)}"


def find_command(effects: Iterable[Effect]) -> JointOffset | None:
    """The command among these effects; None: there is none."""
    return next((e for e in effects if isinstance(e, JointOffset)), None)


def describe_missing_squeeze(spec: Any) -> str:
    """Of the `GraspSpec` of a hand that was told nothing that squeezes the object: that, and what to pass, in words; ""
    of others. Overlaps that are left of touching squeeze nothing.
    """
    apart = spec.offset[: spec.of_hand] * (1.0, 1.0, -1.0)
    pressed = (apart[:, 2] > OVERLAP_TOLERANCE).any() or (abs(apart[:, :2]) > OVERLAP_TOLERANCE).any()
    if spec.mechanism is None or pressed or find_command(spec.effects) or any(e.prescribed() for e in spec.effects):
        return ""
    return "no squeeze was given: pass grip_force=, or squeeze=, joint_offset= or closing_torque="


def commanded_offset(effects: Iterable[Effect], nv: int) -> Array:
    """(nv,) how far they command the joints beyond the posture [rad, m]; 0 without a command."""
    found = find_command(effects)
    return np.zeros(nv) if found is None else found.command


def replace_command(effects: Iterable[Effect], command: Array) -> tuple[Effect, ...]:
    """The effects with another command (nv,), which says no more what it was made from; how the hand closes stays."""
    old = find_command(effects)
    others = tuple([e for e in effects if not isinstance(e, JointOffset)])
    if not command.any() and (old is None or old.opened is None):
        return others
    new = JointOffset(read_only(command)) if old is None else replace(old, command=read_only(command), reach=None)
    return (*others, new)


@dataclass(frozen=True, eq=False)
class JointOffset(Effect):
    """Asked for with `squeeze=`, `grip_force=` or `joint_offset=` of `state.grasp`.

    command : (nv,) δq [rad, m], beyond the posture. reach : what it was made from, and what of that is out of reach;
    None: it was given itself. opened : (nv,) where the joints are when the hand begins to close, if not in the grasp's
    posture. keeps : whether the object is kept in place until the hand has closed. friction_offset : (nv,) how much
    further motors turn because dry friction takes its part of what their springs pull with [rad, m]; None: not at all.
    All of these matter to a loading that is followed, and to nothing else. tension : (t,) with which tendons pull where
    such a loading has come to [N]; None: as springs that are all taut.
    """

    command: Array
    reach: CommandReach | None = None
    opened: Array | None = None
    keeps: bool = False
    friction_offset: Array | None = None
    tension: Array | None = None

    @property
    def motor_offset(self) -> Array:
        """(nv,) how far motors turn beyond the posture [rad, m]."""
        return self.command if self.friction_offset is None else self.command + self.friction_offset

    title = "commanded joint offset"
    equation = "d -= J δq"
    when = "The hand squeezes because its joints are told to close further than they can: by a depth, a force or δq."
    in_python = "squeeze=0.003"
    in_file = "grasp.squeeze_m = 0.003"
    brings = "none: data"
    source = "Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989): joints under position control are springs"
    order = 120
    needs_joints = True
    by_name = False

    @classmethod
    def absent(cls, scene: Scene, section: Section) -> str | None:
        """Only a hand has joints to command."""
        return None if scene.mechanism is None else "none given"

    def why(self, scene: Scene) -> str:
        assert scene.mechanism is not None  # `needs_joints` saw to it
        moved = [f"{name} {x:+.3g}" for name, x in zip(scene.mechanism.names, self.command.tolist(), strict=True) if x]
        given = "" if self.reach is None else f"{self.reach}; "
        return f"{given}{list_names(moved) or 'no joint moved, 0'} rad, part of the offsets"

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """-J δq, and the turns of soft fingertips likewise."""
        assert at.mechanism is not None
        return np.asarray(-(at.mechanism.jacobian_rows(soft) @ self.command))
