"""What torques and tensions beside their limits say of a grasp, as reasons of a verdict: joints and tendons alike."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.answer.force_bounds import apart, shares, span, torque_bounds
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.cause.judge import TENSION, TORQUE, Cause, exceeded, most_used
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.torque_check import TorqueCheck, TorqueRow

_LEFT = 0.01  # of a command's largest torque: more than this that nothing makes decides

# ----------------------------------------------------------------
# Of joints and of tendons the same: which is over its limit, and for how long it holds; which is nearest to it; and
# which takes more to close than its motor gives.


class Kind(NamedTuple):
    """Joints or tendons. who : one of them. code : of a `Cause`, and of reasons. weak : what cannot. effort, limit :
    keys of numbers.
    """

    who: str
    code: str
    weak: str
    effort: str
    limit: str

    def values(self, name: str, effort: float, limit: float) -> dict[str, Any]:
        """For a reason."""
        return {self.who: name, self.effort: effort, self.limit: limit}


JOINT = Kind("joint", TORQUE, "motors", "torque_Nm", "limit_Nm")
TENDON = Kind("tendon", TENSION, "tendons", "tension_N", "limit_N")


def torque_reasons(check: TorqueCheck) -> Iterator[Reason]:
    """What a check says about holding: joints over their limit, or the nearest to it; those that yield; the unknown."""
    if check.over:
        yield _over(JOINT, check.over)
    elif check.binding is not None:
        nearest = check[check.binding]
        yield _nearest(JOINT, nearest, "" if np.isfinite(nearest.limit) else check.unlimited)
    if check.yielding:
        text = f"{words.listed(check.yielding)} {'yield' if len(check.yielding) > 1 else 'yields'} at the limit"
        yield Reason("torque", "note", text, {"yielding": check.yielding})
    if check.unknown:
        text = f"torque limits not known, torques not judged: {words.listed(check.unknown)}"
        yield Reason("limit_unknown", "warning", text, {"joints": check.unknown})


def tension_reasons(stiffness: TendonStiffness, tension: Array) -> Iterator[Reason]:
    """What tendons say that pull with tension (t,) [N]: those over their limit, or the nearest to it."""
    rows = _tendons(stiffness, tension)
    if over := tuple([row for row in rows if row.over]):
        yield _over(TENDON, over)
    elif any(np.isfinite(row.limit) for row in rows):
        yield _nearest(TENDON, rows[most_used(np.array([row.utilisation for row in rows]))])


def _tendons(stiffness: TendonStiffness, tension: Array) -> tuple[TorqueRow, ...]:
    """Tendon by tendon; with a motor where that holds less for good than the tendon bears, and the tendon bears it."""
    cables, drives, rows = stiffness.cables, stiffness.drives, list[TorqueRow]()
    motors = (None,) * len(tension) if drives is None else drives.of
    each = zip(cables.names, tension.tolist(), stiffness.bears.tolist(), cables.limits.tolist(), motors, strict=True)
    for name, t, bears, limit, motor in each:
        breaks = limit >= bears or bool(exceeded(t / bears))
        most = bears if breaks else limit
        rows.append(TorqueRow(name, t, most, t / most, True, "N", None if breaks else motor))
    return tuple(rows)


def _over(kind: Kind, rows: Sequence[TorqueRow]) -> Reason:
    """Of those over their limits: for a while, where motors hold all of them at their peak, or not at all."""
    values = {f"{kind.who}s": [_values(kind, r) for r in rows]}
    if any(r.lasts == 0.0 for r in rows):
        needs = [f"{r.joint} needs {_of(kind, r.unit, abs(r.torque), r.limit)}" for r in rows]
        text = f"the contacts could hold the object, the {kind.weak} cannot: {words.listed(needs)}"
        return Reason(f"{kind.code}_over_limit", "decides", text, values)
    needs = [f"{r.joint} gives {words.percent(r.motor.share(r.torque))} of continuous" for r in rows if r.motor]
    known = [r.lasts for r in rows if r.lasts is not None]
    least = "not for longer than the motor's thermal time"
    if len(known) == len(rows):
        least = f"begun cold, the first motor overheats after {words.duration(min(known))}"
    text = f"the hand holds the object, but not for good: {words.listed(needs)}; {least}"
    return Reason("overheats", "decides", text, values | {"lasts_s": min(known) if len(known) == len(rows) else None})


def _nearest(kind: Kind, r: TorqueRow, unlimited: str = "") -> Reason:
    of = f"{words.effort(r.limit, r.unit)}{f' {r.held_by}' if r.held_by else ''}"
    text = f"the {kind.who} closest to its limit is {r.joint} at {words.percent(r.utilisation)} of {of}"
    return Reason(kind.code, "note", unlimited or text, _values(kind, r))


def unmade_reasons(
    names: Sequence[str], stiffness: Elasticity, command: Array, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of a command (nv,) of the joints [rad, m] that tendons, or servos, make only in part: what nothing makes of it
    decides, where it is more than a hundredth. sliding : names of joints that slide.
    """
    left = stiffness.beyond(command)
    if not left.any():
        return
    needs = [(name, t) for name, t in zip(names, left.tolist(), strict=True) if t]
    asked = stiffness.asked(command)
    share = float(abs(left).max() / abs(asked).max())
    text = "no actuators make this command: it takes others"
    if isinstance(stiffness, TendonStiffness):
        arms = stiffness.arms.T
        missing = abs(arms @ np.linalg.lstsq(arms, asked)[0] - asked).max()  # if tendons could push, too
        which = "more tendons" if missing > _LEFT * abs(asked).max() else "tendons that pull the other way"
        text = f"no tendons make this command by pulling: it takes {which}"
    listed = words.listed([f"{name} with {words.effort(t, words.effort_unit(name in sliding))}" for name, t in needs])
    values = {"joints": [name for name, _ in needs], "torques_Nm": [t for _, t in needs], "share": share}
    yield Reason("command_not_made", "decides" if share > _LEFT else "warning", f"{text} to turn {listed}", values)


def closing_reasons(
    kind: Kind, names: Sequence[str], beyond: Sequence[Cause], drives: Drives, sliding: Sequence[str] = ()
) -> Iterator[Reason]:
    """Of joints or tendons that closing took more of than their motors give; beyond : of other kinds, too. sliding :
    names of joints that slide.
    """
    if its := [c for c in beyond if c.kind == kind.code]:
        at = [names.index(c.who) for c in its]
        closes = (drives.closes if kind is TENDON else drives.pulls(np.full(len(names), np.inf)))[at]
        taken = closes * np.array([1.0 - c.margin for c in its])
        both = list(zip([c.who for c in its], taken.tolist(), closes.tolist(), strict=True))
        needs = [f"{name} needs {_of(kind, words.effort_unit(name in sliding), *each)}" for name, *each in both]
        rubs = " less dry friction" if kind is TENDON and drives.friction[at].any() else ""
        text = f"closing takes more than the motors give (peak{rubs}): {words.listed(needs)}"
        values = {f"{kind.who}s": [kind.values(*each) for each in both]}
        yield Reason("closing_over_peak", "decides", text, values)


def _of(kind: Kind, unit: str, effort: float, limit: float) -> str:
    """Such as "0.21 N·m of 0.2 N·m"."""
    return " of ".join(words.efforts((effort, limit), "N" if kind is TENDON else unit))


def _values(kind: Kind, r: TorqueRow) -> dict[str, Any]:
    return kind.values(r.joint, r.torque, r.limit) | {"utilisation": r.utilisation}


# ----------------------------------------------------------------
# Of torques that forces leave open.


def open_torque_reasons(s: Any) -> Iterator[Reason]:
    """Of a hand's solution that leaves forces open: whether joints are within their limits whatever these are."""
    if s.uniqueness is None or s.uniqueness.forces_determined:
        return
    check, torques = s.torque_check, torque_bounds(s)
    open_ = apart(torques, s.residuals.force_scale)
    bounds = shares(torques, check.limit)
    values = {"joints": [{"joint": name, "torque_Nm": both, "utilisation": share} for name, both, share, yes in
                         zip(check.joints, torques.tolist(), bounds.tolist(), open_, strict=True) if yes]}  # fmt: skip
    if not open_.any():
        yield Reason("torques_open", "note", "the forces that are open change no joint's torque", values)
        return
    least, most = bounds.T
    doubtful = np.flatnonzero(exceeded(most) & ~exceeded(least))
    if len(doubtful):
        k = doubtful[most_used(most[doubtful])]
        text = f"{check.joints[k]} may carry {_of_limit(*bounds[k].tolist())}"
        if more := len(doubtful) - 1:
            others = "1 more joint may need more than its" if more == 1 else f"{more} more may need more than their"
            text = f"{text}, and {others} limit{'s' if more > 1 else ''}"
        yield Reason("torques_open", "warning", f"{text}: no statics can tell", values)
    elif not exceeded(most).any():
        k = most_used(most)
        share = words.percent(most[k])
        text = f"whatever the forces that are open are, no joint needs more than {share} of its limit"
        yield Reason("torques_open", "note", f"{text} ({check.joints[k]})", values)


def _of_limit(least: float, most: float) -> str:
    if np.isfinite(most):
        return f"{span(least, most)} of its limit"
    return f"{words.percent(least)} of its limit, or any amount more"
