"""`HandReport`: what texts and checks ask of a hand: reasons of verdicts, lines of explanations, places of links."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.actuation.joint_stiffness import TRANSMISSION
from handlcp.actuation.motor import Drives
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.errors import URDFError
from handlcp.geometry.link_penetration import LinkPenetration, find_penetrating_links
from handlcp.geometry.object import Object, describe_missing_weight
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.failure.failure_mode import (
    TENSION,
    TORQUE,
    FailureMode,
    StateLimits,
    is_exceeded,
    largest_share_index,
    limit_shares,
)
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.grasp.model.effect import FOLLOWED_LOADINGS
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.force_bounds import find_torque_bounds, is_apart, torque_shares
from handlcp.hand.squeeze import find_unreachable, start_link_depths
from handlcp.hand.torque_check import MAX_TORQUE_SHARE, TorqueCheck, TorqueRow
from handlcp.robot.audit import doubt_reasons
from handlcp.robot.hand_model import HandPosture

ExplanationLine = tuple[str, str, bool, str, str]  # title, equation, whether it is on, why, answers that count it

_MAX_UNMADE_SHARE = 0.01  # of a command's largest torque: more than this that nothing makes decides
_FRICTION_LAW = "against the motion: |τ_f| ≤ f, and τ_f = -f sign(q̇) where a joint moves"


@dataclass(frozen=True, slots=True)
class HandReport:
    """What verdicts, explanations and pictures ask of the hand that holds an object: of its `HandMechanism`."""

    mechanism: Any

    @property
    def links(self) -> dict[str, str]:
        """The link of each fingertip that is a place on a link, by the fingertip's name; {} where tips alone touch."""
        hand = self.mechanism.posture.hand
        return {} if hand.links_of_sites is None else dict(zip(hand.fingertips, hand.links_of_sites, strict=True))

    # ---- reasons of verdicts
    def reasons(self, solution: Any) -> Iterator[Reason]:
        """What its torques, its limits and its posture say of whether a solution of its grasp holds."""
        if solution.held:
            yield from torque_reasons(solution.torque_check)
            yield from self.open_reasons(solution)
            yield from doubt_reasons(self.mechanism.posture.hand.doubts)
        yield from self.command_reasons(solution.spec)
        yield from self.place_reasons(self.mechanism.posture, self.mechanism.target, "in the given posture")

    def open_reasons(self, s: Any) -> Iterator[Reason]:
        """Whether joints are within their limits whatever the forces are that a solution of its grasp leaves open."""
        if s.uniqueness is None or s.uniqueness.forces_determined:
            return
        check, torques = s.torque_check, find_torque_bounds(s)
        open_ = is_apart(torques, s.residuals.force_scale)
        bounds = torque_shares(torques, check.limit)
        joints = [
            {"joint": name, "torque_Nm": both, "utilisation": share}
            for name, both, share, yes in zip(check.joints, torques.tolist(), bounds.tolist(), open_, strict=True)
            if yes
        ]
        if not open_.any():
            yield make_reason("torques_open", "note", {"joints": joints}, "none")
            return
        least, most = bounds.T
        doubtful = np.flatnonzero(is_exceeded(most) & ~is_exceeded(least))
        if len(doubtful):
            k = doubtful[largest_share_index(most[doubtful])]
            both, case = bounds[k].tolist(), "" if np.isfinite(most[k]) else "no end"
            said = {"joint": check.joints[k], "both": both, "least": both[0], "more": len(doubtful) - 1}
            yield make_reason("torques_open", "warning", {"joints": joints}, case, **said)
        elif not is_exceeded(most).any():
            k = largest_share_index(most)
            said = {"joint": check.joints[k], "most": most[k]}
            yield make_reason("torques_open", "note", {"joints": joints}, "within", **said)

    def command_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """What of a squeeze no command of the joints makes; the weight, where the load leaves it out."""
        yield from self.start_inside_reasons(spec)
        for reach in find_unreachable(spec):
            values = {
                "what": reach.what, "unit": reach.unit, "fingers": reach.names, "asked": reach.asked.tolist(),
                "missing": reach.missing.tolist(), "share": reach.share.tolist(),
            }  # fmt: skip
            yield make_reason("out_of_reach", "warning", values, reach=reach)
        if (command := find_command(spec.effects)) is not None and command.keeps:
            yield make_reason("object_kept", "note")
        if command is not None:
            yield from self._unmade_reasons(command.command)
        if text := describe_missing_weight(spec, self.mechanism.weight_of_object(spec.reference)):
            yield make_reason("weight_left_out", "note", text=text)

    def start_inside_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """A warning where the object begins inside links, before the hand closes: how deep in which."""
        if depths := start_link_depths(spec):
            links = [{"link": link, "depth_m": depth} for link, depth in depths.items()]
            yield make_reason("link_inside", "warning", {"links": links})

    def _unmade_reasons(self, command: Array) -> Iterator[Reason]:
        """What no tendons or servos make of a command (nv,) [rad, m]: more than a hundredth of it decides."""
        stiffness = self.mechanism.posture.hand.stiffness
        left = stiffness.unmade_torque(command)
        if not left.any():
            return
        which, asked = np.flatnonzero(left), stiffness.command_torque(command)
        share, case = float(abs(left).max() / abs(asked).max()), ""
        if isinstance(stiffness, TendonStiffness):
            arms = stiffness.arms.T
            missing = abs(arms @ np.linalg.lstsq(arms, asked)[0] - asked).max()  # if tendons could push, too
            case = "tendons" if missing > _MAX_UNMADE_SHARE * abs(asked).max() else "opposite tendons"
        joints, torques = [self.mechanism.names[k] for k in which.tolist()], left[which].tolist()
        values = {"joints": joints, "torques_Nm": torques, "share": share}
        rows = [(name, t, self._unit(name)) for name, t in zip(joints, torques, strict=True)]
        severity = "decides" if share > _MAX_UNMADE_SHARE else "warning"
        yield make_reason("command_not_made", severity, values, case, rows=rows)

    def end_reasons(self, torque: Array, yielded: Array, place: tuple[Any, Any]) -> Iterator[Reason]:
        """What a loading's end says: torques (nv,), how far joints yield (nv,), and `place_at` there."""
        most = self.mechanism.limits
        at_limit = np.where(yielded != 0.0, np.clip(torque, -most, most), torque)  # but for rounding
        yield from torque_reasons(self.mechanism.check_torques(at_limit, yielded))
        yield from doubt_reasons(self.mechanism.posture.hand.doubts)
        yield from self.place_reasons(*place, "at the end of the loading")

    def tension_reasons(self, tension: Array) -> Iterator[Reason]:
        """What tendons pull with at the end, (t,) [N], beside what they bear and their motors hold."""
        if not isinstance(stiffness := self.mechanism.posture.hand.stiffness, TendonStiffness):
            return
        cables, drives, rows = stiffness.cables, stiffness.drives, list[TorqueRow]()
        motors = (None,) * len(tension) if drives is None else drives.motors
        columns = cables.names, tension.tolist(), stiffness.strength.tolist(), cables.limits.tolist(), motors
        for name, t, bears, limit, motor in zip(*columns, strict=True):
            # A motor counts where it holds less for good than the tendon bears, and the tendon bears this tension
            breaks = limit >= bears or bool(is_exceeded(t / bears))
            most = bears if breaks else limit
            rows.append(TorqueRow(name, t, most, t / most, True, "N", None if breaks else motor))
        nearest = None
        if any(np.isfinite(row.limit) for row in rows):
            nearest = rows[largest_share_index(np.array([row.utilisation for row in rows]))]
        yield from _limit_reasons(_TENDON_EFFORT, [row for row in rows if row.over], nearest)

    def closing_reasons(self, beyond: Iterable[FailureMode]) -> Iterator[Reason]:
        """Joints and tendons that closing took more of than their motors give, as reasons."""
        hand, all_of_them = self.mechanism.posture.hand, tuple(beyond)
        if (drives := hand.torques.drives) is not None:
            most = drives.peak_limits(np.full(hand.nv, np.inf))
            yield from self._over_peak_reasons(_JOINT_EFFORT, self.mechanism.names, all_of_them, drives, most)
        if isinstance(hand.stiffness, TendonStiffness) and (drives := hand.stiffness.drives) is not None:
            names, most = hand.stiffness.cables.names, drives.closing_limits
            yield from self._over_peak_reasons(_TENDON_EFFORT, names, all_of_them, drives, most)

    def _over_peak_reasons(
        self, kind: _EffortKind, names: Sequence[str], beyond: Sequence[FailureMode], drives: Drives, most: Array
    ) -> Iterator[Reason]:
        """The same of joints or tendons alone; beyond : of both. most (k,) : what their motors close with."""
        if its := [c for c in beyond if c.kind == kind.code]:
            at = [names.index(c.who) for c in its]
            taken = most[at] * np.array([1.0 - c.margin for c in its])
            both = list(zip([c.who for c in its], taken.tolist(), most[at].tolist(), strict=True))
            is_tendon = kind is _TENDON_EFFORT
            values = {f"{kind.member}s": [kind.reason_values(*each) for each in both]}
            rows = [(*each, "N" if is_tendon else self._unit(each[0])) for each in both]
            rubs = is_tendon and bool(drives.friction[at].any())
            yield make_reason("closing_over_peak", "decides", values, "rubs" if rubs else "", rows=rows)

    def pulling_reasons(self, spec: GraspSpec, torque: Array) -> Iterator[Reason]:
        """Of fingers that pull with less than asked for, at torques (nv,) [N·m] where the hand has closed: they meet
        nothing, or another finger would have to pull harder.
        """
        if (found := self.mechanism.motor_pull(spec, torque)) is None:
            return
        (pulling, shares), joints = found, self.mechanism.names
        asked: Any = abs(pulling.closing_torque)
        short = [(joints[k], float(shares[k] * asked[k]), float(asked[k])) for k in pulling.weakest_joints(shares)]
        if not short:
            return
        beyond = [joints[k] for k in np.flatnonzero(shares > MAX_TORQUE_SHARE).tolist()]
        rows = [(*each, self._unit(each[0])) for each in short]
        values = [dict(zip(("joint", "torque_Nm", "asked_Nm"), each, strict=True)) for each in short]
        case = "drives others" if beyond else "stuck" if spec.asked.closed.stuck else ""
        yield make_reason("closing_torque", "warning", {"joints": values}, case, rows=rows, beyond=beyond)

    # ---- places
    def place_reasons(self, posture: HandPosture | None, obj: Object | None, when: str) -> Iterator[Reason]:
        """What a posture says, with the object where it is: joints past their ranges, links inside the object.

        posture, obj : None where they are not known. when : "at the end of the loading".
        """
        if posture is None:
            return
        yield from _range_reasons(posture, when)
        if obj is None:
            return
        try:
            inside = find_penetrating_links(posture, obj, self.mechanism.tips)
        except URDFError as error:
            yield make_reason("link_inside", "warning", case="unknown", error=error)
            return
        if not posture.hand.link_surfaces:
            yield make_reason("link_inside", "warning", case="no geometry")
        seen = [one for one in inside if one.depth > _GEOMETRY_TOLERANCE]
        for alike in _group_alike(seen):
            yield _penetration_reason(alike, when, posture.hand.links_of_sites is None)

    def place_at(self, q: Array, pose: Any) -> tuple[HandPosture, Object | None]:
        """The posture with joints at q (nv,), and the object in this pose of a moving geometry; None if unknown."""
        placed = None
        if self.mechanism.target is not None:
            R, t = pose
            placed = self.mechanism.target.moved_to(pin.SE3(R, t) * self.mechanism.target.placement)
        return type(self.mechanism.posture)(self.mechanism.posture.hand, q), placed

    def find_links_inside(self, q: Array, pose: Any) -> tuple[set[str], str]:
        """Links so deep in the object, beside their contacts or without any, that the hand cannot be there, and a
        sentence about them; arguments of `place_at`.
        """
        posture, obj = self.place_at(q, pose)
        if obj is None:
            return set(), ""
        deep = [one for one in find_penetrating_links(posture, obj, self.mechanism.tips) if one.is_impossible]
        said = [_penetration_reason(alike, "soon after", False).sentence for alike in _group_alike(deep)]
        return {one.link for one in deep}, "; ".join(said)

    # ---- lines of explanations
    def explanation_lines(self) -> Iterator[ExplanationLine]:
        """What joints, motors and tendons bring to a grasp: transmission, springs, friction, slack."""
        hand = self.mechanism.posture.hand
        stiffness = hand.stiffness
        equation, said = stiffness.law
        yield TRANSMISSION, equation, bool(said), said or "none: the springs are those of the joints", ""
        if (alone := stiffness.joint_springs * (stiffness.springs_with_rest == 0.0)).any():
            largest = words.first_largest_index(alone)
            most = f"{float(alone[largest]):.3g} {words.stiffness_unit(hand.joint_names[largest] in hand.sliding)}"
            yield "springs at joints", "K_p", True, f"{self._list_joints(alone)}, up to {most}: part of K", ""
        if (against := self.mechanism.parallel_spring_torque()) is not None:
            text = f"of the file, against which actuators give up to {self._format_largest_effort(abs(against))}"
            yield "springs beside actuators", "τ += k (q - θ)", True, text, ""
        of_motors = hand.dry_friction - hand.joint_friction
        for title, rubs in (("joint friction", hand.joint_friction), ("motor friction", of_motors)):
            if rubs.any():
                text = f"up to {self._format_largest_effort(rubs)}, {self._list_joints(rubs)}"
                yield title, _FRICTION_LAW, True, text, FOLLOWED_LOADINGS
        if not isinstance(stiffness, TendonStiffness):
            return
        cables, drives = stiffness.cables, stiffness.drives
        if (wraps := cables.wrap_friction > 0.0).any():
            who = words.list_names([cables.names[k] for k in sorted(set(cables.post_tendon[wraps].tolist()))])
            text = f"{who}, μθ up to {float(cables.wrap_friction.max()):.3g} at one place"
            yield "tendon friction", "t e^(-μθ) ≤ t' ≤ t e^(μθ)", True, text, FOLLOWED_LOADINGS
        if (known := np.isfinite(cables.pretension)).any():
            least = words.format_force(float(cables.pretension[known].min()))
            text = f"slack below 0 N; pretension of {least} at least"
            yield "tendons that pull alone", "t ≥ 0", True, text, FOLLOWED_LOADINGS
        if drives is not None and drives.friction.any():
            most = words.format_force(float(drives.friction.max()))
            where = words.list_names(drives.motor_joints(cables.names))
            text = f"up to {most} at {where}: before the cable, so that it changes no force"
            yield "motor friction", "t_m = t ± f", True, f"{text}, but what motors close with and hold", ""

    def _format_largest_effort(self, efforts: Array) -> str:
        """Of efforts (nv,), in the unit of its joint."""
        largest = words.first_largest_index(efforts)
        return words.format_effort(float(efforts[largest]), self._unit(self.mechanism.names[largest]))

    def _list_joints(self, values: Array) -> str:
        """At which joints values (nv,) are not zero."""
        at = [joint for joint, value in zip(self.mechanism.names, values.tolist(), strict=True) if value]
        return "at every joint" if len(at) == len(values) else f"at {words.list_names(at)}"

    def _unit(self, joint: str) -> str:
        return words.effort_unit(joint in self.mechanism.posture.hand.sliding)


# ----------------------------------------------------------------
# What a posture says about holding an object: joints past the ends of their ranges, links inside the object.

_MAX_RANGE_EXCESS = 0.05  # [rad]; past its range by more, the joint cannot be there
_GEOMETRY_TOLERANCE = 2e-4  # [m] collision geometry is no more exact than that


def _group_alike(found: list[LinkPenetration]) -> list[list[LinkPenetration]]:
    """Those that one sentence is about, together."""
    groups = dict[tuple[bool, bool, bool], list[LinkPenetration]]()
    for one in found:
        key = one.tip is not None, not one.is_impossible, one.left_out and one.tip is None
        groups.setdefault(key, []).append(one)
    return [groups[key] for key in sorted(groups)]


def _penetration_reason(links: list[LinkPenetration], when: str, tips_alone: bool) -> Reason:
    """Of links that are alike, the deepest first. tips_alone : whether fingertips are all that may touch."""
    values = {"links": [{"link": one.link, "depth_m": one.depth, "fingertip": one.tip} for one in links]}
    far, left_out = links[0].is_impossible, links[0].left_out
    said = {"when": when, "tips_alone": tips_alone, "left_out": left_out, "far": far}
    return make_reason("link_inside", "decides" if far else "warning", values, "posture", **said)


def _range_reasons(posture: HandPosture, when: str) -> Iterator[Reason]:
    hand, q = posture.hand, posture.q
    past = np.maximum(hand.lower - q, q - hand.upper)
    limits = StateLimits((), hand.joint_names, hand.torque_limits, hand.lower, hand.upper)
    shares = limit_shares(limits, np.zeros(hand.nv), q)[hand.nv :]
    for k in np.flatnonzero(is_exceeded(shares)):
        name, by = hand.joint_names[k], float(past[k])
        much = words.format_length(by) if name in hand.sliding else words.format_angle(by)
        values = {"joint": name, "position": float(q[k]), "lower": float(hand.lower[k]), "upper": float(hand.upper[k])}
        severity, case = ("decides", "far") if by > _MAX_RANGE_EXCESS else ("warning", "")
        yield make_reason("joint_range", severity, values, case, when=when, past=much)


# ----------------------------------------------------------------
# Of joints and of tendons the same: which is over its limit, and for how long it holds, or which is nearest to it.


class _EffortKind(NamedTuple):
    """What efforts are of, joints or tendons, and the words and keys for them.

    member : one of them. code : of a `FailureMode`, and of reasons. effort, limit : keys of numbers.
    """

    member: str
    code: str
    effort: str
    limit: str

    def reason_values(self, name: str, effort: float, limit: float) -> dict[str, Any]:
        """The values of a reason about one joint or tendon."""
        return {self.member: name, self.effort: effort, self.limit: limit}


_JOINT_EFFORT = _EffortKind("joint", TORQUE, "torque_Nm", "limit_Nm")
_TENDON_EFFORT = _EffortKind("tendon", TENSION, "tension_N", "limit_N")


def torque_reasons(check: TorqueCheck) -> Iterator[Reason]:
    """What a check says about holding: joints over their limit, or the nearest to it; those that yield; the unknown."""
    nearest = None if check.binding is None else check[check.binding]
    unlimited = check.unlimited if nearest is not None and np.isinf(nearest.limit) else ""
    yield from _limit_reasons(_JOINT_EFFORT, check.over, nearest, unlimited)
    if check.yielding:
        yield make_reason("torque", "note", {"yielding": check.yielding}, "yields")
    if check.unknown:
        yield make_reason("limit_unknown", "warning", {"joints": check.unknown})


def _limit_reasons(
    kind: _EffortKind, over: Sequence[TorqueRow], nearest: TorqueRow | None, unlimited: str = ""
) -> Iterator[Reason]:
    """Of those over their limits: they hold for a while, where motors hold all of them at their peak, or not at all. Of
    none: the nearest to its limit. unlimited : what is said where none has one.
    """

    def values_of(r: TorqueRow) -> dict[str, Any]:
        return kind.reason_values(r.joint, r.torque, r.limit) | {"utilisation": r.utilisation}

    if not over:
        if (r := nearest) is not None:
            said = {"member": kind.member, "name": r.joint, "limit": (r.limit, r.unit), "held_by": r.held_by}
            case = "no limit" if unlimited else ""
            yield make_reason(kind.code, "note", values_of(r), case, unlimited=unlimited, **said)
        return
    values: dict[str, Any] = {f"{kind.member}s": [values_of(r) for r in over]}
    if any(r.lasts == 0.0 for r in over):
        rows = [(r.joint, abs(r.torque), r.limit, r.unit) for r in over]
        yield make_reason(f"{kind.code}_over_limit", "decides", values, rows=rows)
        return
    known = [r.lasts for r in over if r.lasts is not None]
    values["lasts_s"] = min(known) if len(known) == len(over) else None
    shares = [(r.joint, r.motor.share(r.torque)) for r in over if r.motor]
    yield make_reason("overheats", "decides", values, "" if len(known) == len(over) else "no time", shares=shares)
