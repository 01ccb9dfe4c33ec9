"""What a hand's grasp answers: a `GraspSolution`, and what its joints have to do for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import UnknownName
from handlcp.grasp.answer.force_bounds import apart, shares, span, torque_bounds
from handlcp.grasp.answer.printed import printed
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.cause.judge import exceeded, most_used
from handlcp.grasp.cause.wording import needs_more
from handlcp.hand.elasticity.elasticity import Effort
from handlcp.record import Record, columns
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view

# ----------------------------------------------------------------
# Joint by joint: the torque that holds the grasp, the limit, and which joint gives out first.


class TorqueRow(NamedTuple):
    """One joint. torque, limit [N·m] (N for a prismatic joint); utilisation [-]; known: whether the limit is. unit :
    "N·m" or "N".
    """

    joint: str
    torque: float
    limit: float
    utilisation: float
    known: bool
    unit: str = "N·m"

    @property
    def over(self) -> bool:
        """Whether the joint needs more than its limit."""
        return bool(exceeded(self.utilisation))


@dataclass(frozen=True, slots=True)
class TorqueCheck(Record):
    """Torques against limits; iterates over `TorqueRow`s and prints as a table.

    joints : nv names. torque : (nv,) [N·m]. limit : (nv,) [N·m], inf where there is none or none is known.
    utilisation : (nv,) |torque| / limit, a finite number always (NaN if the torque is): 0 where the limit is infinite
        or unknown.
    known : nv booleans.
    yielding : names of the joints at their limit that give way there (`TorqueSaturation`); their utilisation is 1.
    sliding : names of prismatic joints, whose torque, limit and margin are forces [N].
    """

    entries = (
        "joints", "torque_Nm (nv,)", "limit_Nm (nv,)", "utilisation (nv,)", "margin_Nm (nv,)", "known", "yielding",
        "binding", "ok",
    )  # fmt: skip

    joints: tuple[str, ...]
    torque: Array
    limit: Array
    utilisation: Array
    known: tuple[bool, ...]
    yielding: tuple[str, ...] = ()
    sliding: tuple[str, ...] = ()

    @property
    def unknown(self) -> tuple[str, ...]:
        """The joints whose limit is not known."""
        return tuple(name for name, known in zip(self.joints, self.known, strict=True) if not known)

    @property
    def binding(self) -> str | None:
        """The joint with the highest utilisation among the known limits; None when no limit is known."""
        shares = np.where(self.known & np.isfinite(self.utilisation), self.utilisation, -1.0)
        i = most_used(shares)
        return self.joints[i] if shares[i] >= 0 else None

    @property
    def over(self) -> tuple[TorqueRow, ...]:
        """The rows of joints asked for more than their limit."""
        return tuple(row for row in self if row.over)

    @property
    def ok(self) -> bool:
        """All limits known (pass `torque_limits`, numpy.inf for none), and none exceeded."""
        return all(self.known) and not np.isnan(self.utilisation).any() and not self.over

    def __iter__(self) -> Iterator[TorqueRow]:
        columns = (a.tolist() for a in (self.torque, self.limit, self.utilisation))
        units = ["N" if joint in self.sliding else "N·m" for joint in self.joints]
        return map(TorqueRow, self.joints, *columns, self.known, units)

    def __len__(self) -> int:
        return len(self.joints)

    def __getitem__(self, joint: str) -> TorqueRow:
        if joint not in self.joints:
            raise UnknownName("joint", "a joint", [str(joint)], self.joints)
        return next(row for row in self if row.joint == joint)

    @property
    def margin(self) -> Array:
        """(nv,) N·m, how much more torque each joint has: limit - |torque|, below 0 where it would need more than it
        has; inf where there is no limit or none is known.
        """
        return read_only(self.limit - abs(self.torque))

    @property
    def table(self) -> TextTable:
        """Joint by joint, with a remark in the last column."""
        known = [limit for limit in self.limit.tolist() if np.isfinite(limit)]
        units = {row.unit for row in self}
        unit, size = words.prefixed(max(units, key=len), [10.0 * x for x in (*self.torque.tolist(), *known)])
        if len(units) > 1:
            unit, size = "N·m", 1.0
        limits = [_limit(r._replace(limit=r.limit / size)) for r in self]
        torques = _torques(self.torque / size)
        if len(units) > 1:  # those of joints that slide say their own
            torques = [f"{t} N" if r.unit == "N" else t for t, r in zip(torques, self, strict=True)]
        columns = ([r.joint for r in self], torques, limits, [_share(r) for r in self],
                   [self.remark(r) for r in self])  # fmt: skip
        heads = ("joint", f"torque\n{unit}", f"limit\n{unit}", "of limit", "")
        return TextTable(heads, tuple(zip(*columns, strict=True)), "<>>><")

    def remark(self, row: TorqueRow) -> str:
        """What stands beside a row: over its limit, yields at its limit, closest to its limit; "" for all others."""
        if row.over and row.known:
            return "over limit"
        if row.joint in self.yielding:
            return "yields"
        return "closest" if row.joint == self.binding and np.isfinite(row.limit) else ""

    def __str__(self) -> str:
        return f"{self.table}\n{wrapped(self.verdict)}"

    @property
    def verdict(self) -> str:
        """One sentence."""
        if over := self.over:
            return f"{needs_more([r.joint for r in over])}."
        if np.isnan(self.torque).any():
            return "No torques: the grasp was not solved."
        if self.unknown:
            return f"Without a torque limit: {words.listed(self.unknown)}. Pass torque_limits."
        if self.yielding:
            one = len(self.yielding) == 1
            gives = "gives way at its limit" if one else "give way at their limits"
            return f"All joints hold; {words.listed(self.yielding)} {gives}."
        if self.binding is None or not np.isfinite(self[self.binding].limit):
            return "No joint has a torque limit."
        return f"All joints hold; {self.binding} is closest to its limit."

    def __rich__(self) -> Any:
        return view("torque_table")(self)


def torque_check(
    joints: Sequence[str], torque: Array, limit: Array, known: Sequence[bool], yielding: tuple[str, ...] = (),
    sliding: tuple[str, ...] = (),
) -> TorqueCheck:  # fmt: skip
    """Compare torques (nv,) with limits (nv,) [N·m]; an infinite limit is never used up. yielding, sliding : names."""
    return TorqueCheck(tuple(joints), torque, limit, read_only(abs(torque) / limit), tuple(known), yielding, sliding)


def torque_reasons(check: TorqueCheck) -> Iterator[Reason]:
    """What a check says about holding: joints over their limit, or the nearest to it; those that yield; the unknown."""
    if check.over:
        needs = [f"{r.joint} needs {_needs(r)}" for r in check.over]
        text = f"the contacts could hold the object, the motors cannot: {words.listed(needs)}"
        yield Reason("torque_over_limit", "decides", text, {"joints": [_values(r) for r in check.over]})
    elif check.binding is not None:
        r = check[check.binding]
        share = f"{words.percent(r.utilisation)} of {words.effort(r.limit, r.unit)}"
        text = f"the joint closest to its limit is {r.joint} at {share}"
        text = text if np.isfinite(r.limit) else "no joint has a torque limit"
        yield Reason("torque", "note", text, _values(r))
    if check.yielding:
        text = f"{words.listed(check.yielding)} {'yield' if len(check.yielding) > 1 else 'yields'} at the limit"
        yield Reason("torque", "note", text, {"yielding": check.yielding})
    if check.unknown:
        text = f"torque limits not known, torques not judged: {words.listed(check.unknown)}"
        yield Reason("limit_unknown", "warning", text, {"joints": check.unknown})


def open_torque_reasons(s: HandGraspSolution) -> Iterator[Reason]:
    """Of a solution that leaves forces open: whether joints are within their limits whatever these are."""
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
        text = f"whatever the forces that are open are, no joint needs more than {words.percent(most[k])} of its limit"
        yield Reason("torques_open", "note", f"{text} ({check.joints[k]})", values)


def _of_limit(least: float, most: float) -> str:
    if np.isfinite(most):
        return f"{span(least, most)} of its limit"
    return f"{words.percent(least)} of its limit, or any amount more"


def _needs(r: TorqueRow) -> str:
    """Such as "0.21 N·m of 0.2 N·m"."""
    both = (abs(r.torque), r.limit)
    return " of ".join(map(words.force, both) if r.unit == "N" else words.torques(both))


def _values(r: TorqueRow) -> dict[str, Any]:
    return {"joint": r.joint, "torque_Nm": r.torque, "limit_Nm": r.limit, "utilisation": r.utilisation}


def _limit(row: TorqueRow) -> str:
    return f"{row.limit:.4g}" if row.known and np.isfinite(row.limit) else "none" if row.known else "unknown"


def _share(row: TorqueRow) -> str:
    return "–" if not row.known or np.isinf(row.limit) else words.percent(row.utilisation)


def _torques(values: Array) -> list[str]:
    """Four decimals, fewer where the largest torque has more than one digit before them."""
    largest = float(np.nanmax(abs(values), initial=0.0))
    decimals = 4 if largest < 9.99995 else 3 if largest < 99.9995 else 2
    return [f"{round(t, decimals) + 0.0:.{decimals}f}" if np.isfinite(t) else "–" for t in values.tolist()]


# ----------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class HandGraspSolution(GraspSolution):
    """A `GraspSolution` with what the joints have to do; NaN where there is no answer.

    torques : (nv,) τ = Jᵀ f that the actuators hold [N·m], plus g(q) when the fingers' weight was asked for. With
        `GeometricStiffness` those of the deflected posture, to first order: K_g (δq - joint_deflection) more.
    joint_deflection : (nv,) K⁻¹ Jᵀ f [rad], how far the joints give way to the grasp forces, and to the fingers' own
        weight where that is part of the elastic balance, from where they are commanded to be. With
        `GeometricStiffness` (K + K_g)⁻¹ (Jᵀ f + g + K_g δq), δq as commanded.
    joint_yield : (nv,) [rad] how far joints at their limit are driven back beyond that (`TorqueSaturation`): s⁺ - s⁻,
        with the sign of the torque; 0 for all others. Such a joint's torque is its limit.
    torque_check : joint by joint torque, limit, utilisation, and the binding joint.
    effort : what the tendons or synergies of the hand do for these torques, by name; None where it has neither.
    """

    torques: Array
    joint_deflection: Array
    joint_yield: Array
    torque_check: TorqueCheck
    effort: Effort | None

    @cached_property
    def diagnosis(self) -> str:
        """As in `GraspSolution`, and which joints that would ask for more than they have."""
        text, over = super().diagnosis, self.torque_check.over
        if not self.held or not over:
            return text
        most = max(r.utilisation for r in over)
        return f"{text}; but {needs_more([r.joint for r in over])}, up to {most:.3g} ×"

    @property
    def tendon_tension(self) -> Array | None:
        """(t,) k R K⁻¹ τ [N], how much harder each tendon pulls (below 0: less); None without `Tendons`."""
        return self.effort.values if self.effort is not None and self.effort.kind == "tendon tension" else None

    @property
    def actuator_force(self) -> Array | None:
        """(k,) η = Sᵀ τ [N·m where S has no unit] that each synergy's actuator holds; None without `Synergies`."""
        return self.effort.values if self.effort is not None and self.effort.kind == "actuator force" else None

    @property
    def utilisation(self) -> Array:
        """(nv,) |torque| / limit of each joint, 0 where there is no limit or none is known; as in `torque_check`."""
        return self.torque_check.utilisation

    @property
    def torque_margin(self) -> Array:
        """(nv,) N·m, how much more torque each joint has, below 0 where it would need more than it has; inf where there
        is no limit or none is known.
        """
        return self.torque_check.margin

    def _tables(self) -> dict[str, tuple[dict[str, Any], list[str]]]:
        lines = "torque_Nm", "limit_Nm", "utilisation", "margin_Nm"
        joints = columns(self.torque_check, *lines) | {"yield_rad": self.joint_yield}
        return super()._tables() | {"joints": (joints, list(self.torque_check.joints))}

    def __str__(self) -> str:
        return printed(self, [self.torque_check.table, *([] if self.effort is None else [self.effort])])
