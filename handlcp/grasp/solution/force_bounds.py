"""`ForceBounds`: the least and the largest forces over the equilibria that keep an answer's contact states.

Each is the end of a program over a `StateFamily`: a linear one on pyramids and in a plane, by HiGHS; one with
second-order cones on the exact cone, by Clarabel. Either is believed only as far as its multipliers prove it
(`verify/load_capacity.py`). What the equations determine needs no program.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy

from handlcp import words
from handlcp.check import Array, Bools, check_array, read_only
from handlcp.contact.friction import Cone, Pyramid, limit_set
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.failure.reason import format_span
from handlcp.grasp.model.mechanism import evaluate_joints
from handlcp.grasp.model.status import SEPARATED, SLIDING, contact_statuses
from handlcp.grasp.solution.state_family import (
    FactorRanges,
    KeptStates,
    StateFamily,
    iterate_families,
    keep_states,
    own_flexibility,
)
from handlcp.grasp.verify.load_capacity import ENDED, UNBOUNDED, ConeProduct, ConicPrograms, assess_end, solve_conic
from handlcp.progress import report_progress, track_progress
from handlcp.record import Record
from handlcp.tolerances import ACTIVE_TOLERANCE
from handlcp.words import TextTable, wrap_text

_DETERMINED_SHARE = 1e-9  # of a reading's size: directions that change it by less leave it as it is
_HIGHS_TOLERANCE = 1e-10  # the least that HiGHS can be asked for
_CUT_GAP = 1e-10  # a gap above this: planes around the cones are tried, too
_MAX_CUTS = 4  # how often more of them are added


@dataclass(frozen=True, slots=True, eq=False)
class ReadingExtremes:
    """How much p readings of the forces may differ from those at the answer.

    change (p, 2) : by how much they may be less (≤ 0) and more (≥ 0); -inf and inf where nothing bounds them, or no
        method found what does.
    wider (n,) : as in `StateFamily`, of any of them.
    gap : the largest, relative to the larger of a change and the unit.
    """

    change: Array
    wider: Bools
    gap: float


def find_extremes(kept: KeptStates, readings: Array, ranges: FactorRanges | None) -> ReadingExtremes:
    """Of readings (p, c) of the forces, in the laws' coordinates; changes in natural units of force."""
    change, gap = np.zeros((len(readings), 2)), 0.0
    wider = np.zeros(kept.scene.n, dtype=bool)
    sizes = abs(readings).max(axis=1, initial=0.0)
    for family in iterate_families(kept, ranges):
        along = readings @ family.basis
        moves = abs(along).max(axis=1, initial=0.0) > _DETERMINED_SHARE * sizes
        if moves.any():
            wider |= family.wider
        for k in np.flatnonzero(moves):
            for side, sign in enumerate((-1.0, 1.0)):
                most, off = _largest_reading(family, sign * along[k] / sizes[k])
                change[k, side] = sign * max(sign * change[k, side], most * sizes[k])
                gap = max(gap, off)
            report_progress(f"{k + 1} of {len(readings)}")
    return ReadingExtremes(change, wider, gap)


def _largest_reading(family: StateFamily, along: Array) -> tuple[float, float]:
    """The largest along · y of a family, from outside, with its gap."""
    program = ConicPrograms(
        -along, np.zeros((1, 0, len(along))), np.zeros((1, 0)), family.G, family.h[None], family.cones
    )
    if not family.cones.second_order and (end := _solve_linear(program)) is not None:
        return end[:2]
    found = solve_conic(program)
    if found.status[0] == UNBOUNDED:
        return np.inf, 0.0
    best = np.inf, np.inf
    if found.status[0] == ENDED:
        best = _outer_bound(float(along @ found.x[0]), float(found.gap[0]))
    return best if best[1] <= _CUT_GAP or not family.cones.second_order else _bound_by_cuts(program, found.x[0], best)


def _outer_bound(value: float, gap: float) -> tuple[float, float]:
    """(value, gap) with a value that is no less than what is possible; 0 is."""
    return max(value, 0.0) + gap * max(1.0, value), gap


def _solve_linear(program: ConicPrograms) -> tuple[float, float, Array] | None:
    """(value, gap, y) of a linear program; None: no end was found, and the other method proves that there is none."""
    asked = {"primal_feasibility_tolerance": _HIGHS_TOLERANCE, "dual_feasibility_tolerance": _HIGHS_TOLERANCE}
    G, h = program.G, program.h[0]
    if not len(G):
        return np.inf, 0.0, np.zeros(0)
    found = scipy.optimize.linprog(program.c, G, h, bounds=(None, None), method="highs", options=asked)
    if found.status != 0:
        return None
    status, gap, _ = assess_end(program, 0, found.x, np.zeros(0), -found.ineqlin.marginals, h - G @ found.x)
    return (*_outer_bound(-float(found.fun), gap), found.x) if status == ENDED else None


def _bound_by_cuts(program: ConicPrograms, y: Array, best: tuple[float, float]) -> tuple[float, float]:
    """A better bound than `best` of interior points, where there is one: by planes around the cones. They touch these
    where the forces of y are, then where they are at the largest that these planes allow (Kelley's cutting planes), and
    bound from outside whatever y is.
    """
    first, where, G, h = program.cones.linear, list[tuple[int, int]](), program.G, program.h[0]
    for d, count in program.cones.second_order:
        where += [(first + d * k, d) for k in range(count)]
        first += d * count
    inside = max(best[0] - best[1] * max(1.0, best[0]), 0.0) if np.isfinite(best[0]) else 0.0
    rows, room = [G[: program.cones.linear]], [h[: program.cones.linear]]
    for turn in range(_MAX_CUTS):
        s = h - G @ y
        for first, d in where:
            own, t = slice(first, first + d), s[first + 1 : first + d]
            normals = limit_set(Cone(), d - 1).normals.T if turn == 0 else np.zeros((0, d - 1))
            if (size := float(np.linalg.norm(t))) > 0.0:
                normals = np.concatenate([normals, t[None] / size])
            planes = np.column_stack([-np.ones(len(normals)), normals])
            rows.append(-planes @ G[own])
            room.append(-planes @ h[own])
        flat = np.concatenate(rows)
        lines = ConicPrograms(
            program.c, program.A, program.b, flat, np.concatenate(room)[None], ConeProduct(len(flat), ())
        )
        end = _solve_linear(lines)
        if end is None:
            break
        value, _, y = end
        inside = max(inside, _feasible_share(program, y) * float(-program.c @ y))
        if value < best[0] or inside > best[0]:  # what interior points said is no bound where more is within the cones
            best = value, max(value - inside, 0.0) / max(1.0, value)
        if best[1] <= _CUT_GAP:
            break
    return best


def _feasible_share(program: ConicPrograms, y: Array) -> float:
    """The largest share, at most 1, of the way from the answer, where y is 0, that stays within all cones."""
    cones, change, h = program.cones, program.G @ y, program.h[0]
    share, first = 1.0, cones.linear
    falls = change[:first] > 0.0
    share = min(share, float((h[:first][falls] / change[:first][falls]).min(initial=1.0)))
    for d, count in cones.second_order:
        for _ in range(count):
            a, b = h[first : first + d], -change[first : first + d]
            first += d
            # |a_u + x b_u| = a_t + x b_t: the first x > 0 at which the way leaves the cone
            two, one = float(b[1:] @ b[1:] - b[0] ** 2), 2.0 * float(a[1:] @ b[1:] - a[0] * b[0])
            zero = min(float(a[1:] @ a[1:] - a[0] ** 2), 0.0)
            ends = np.roots([two, one, zero])
            real = ends[np.isreal(ends)].real
            share = min(share, float(real[real > 0.0].min(initial=1.0)))
            if a[0] + share * b[0] < 0.0:
                return 0.0
    return max(share, 0.0)


# ----------------------------------------------------------------
# Between what and what every contact force and joint torque lies where statics leaves forces open.


_EQUAL_BOUNDS_SHARE = 1e-9  # of the scene's force: bounds that are apart by less are the same
_UNCHANGED = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class ForceBounds(Record):
    """Least and largest, in the last axis, over all equilibria that keep the contact states of a solution; n contacts,
    nv joints. The same number twice where the equations determine it; -inf and inf where nothing bounds it.

    names : (n,) contacts. forces : (n, 3, 2) N, on the object in contact axes (x, y tangents, z normal).
    joints : (nv,) names, () without a hand. torques : (nv, 2) N·m, as `HandGraspSolution.torques`. limit : (nv,) N·m,
        inf where there is none or none is known.
    pads, friction : the factors that were asked for; (1, 1): as they are.
    wider : contacts that were allowed more than their laws allow: the direction of their slide may turn, their force
        lies on a face of a pyramid that the slip is not against, they touch without force and slip, or more than four
        touch without force. Where there are any, bounds may be wider than need be, never narrower; so with factors.
    gap : by how much a bound may be off, at most: what separates it from what its program proves, relative to the
        larger of it and the scene's force.
    """

    entries = (
        "names",
        "normal_N (n, 2)",
        "forces_N (n, 3, 2)",
        "joints",
        "torques_Nm (nv, 2)",
        "limit_Nm (nv,)",
        "utilisation (nv, 2)",
        "open",
        "pads",
        "friction",
        "wider",
        "gap",
    )

    names: tuple[str, ...]
    forces: Array
    joints: tuple[str, ...]
    torques: Array
    limit: Array
    pads: tuple[float, float]
    friction: tuple[float, float]
    wider: tuple[str, ...]
    gap: float
    force: float = field(repr=False)

    @property
    def normal(self) -> Array:
        """(n, 2) N, of the normal forces."""
        return self.forces[:, 2]

    @property
    def utilisation(self) -> Array:
        """(nv, 2) least and largest |torque| / limit, 0 where there is no limit or none is known."""
        return torque_shares(self.torques, self.limit)

    @property
    def open(self) -> tuple[str, ...]:
        """The contacts and joints whose force or torque is not determined."""
        which = np.append(is_apart(self.forces, self.force).any(axis=1), is_apart(self.torques, self.force)).tolist()
        return tuple([name for name, yes in zip((*self.names, *self.joints), which, strict=True) if yes])

    def __str__(self) -> str:
        tables = [_table("contact", "normal", "N", self.names, self.normal)]
        if self.joints:
            limited = zip(self.utilisation.tolist(), np.isfinite(self.limit).tolist(), strict=True)
            shares = [format_span(*both) if known else "–" for both, known in limited]
            tables.append(_table("joint", "torque", "N·m", self.joints, self.torques, shares))
        return "\n\n".join([*map(str, tables), wrap_text(self._sentence)])

    @property
    def _sentence(self) -> str:
        text = f"Not determined: {words.join_names(self.open)}" if self.open else "All forces are determined"
        asked = [
            f"{what} from {least:g} to {most:g} times what they are"
            for what, (least, most) in (("pads", self.pads), ("friction", self.friction))
            if (least, most) != _UNCHANGED
        ]
        if asked:
            text += f", with {' and '.join(asked)} where contacts go on doing what they do"
        if self.wider or asked:
            text += "; the bounds may be wider than need be, never narrower"
        return f"{text}."


def _table(
    who: str, what: str, unit: str, names: tuple[str, ...], bounds: Array, shares: list[str] | None = None
) -> TextTable:
    values = bounds.reshape(-1).tolist()
    name, size = words.choose_prefix(unit, values)
    cells = [
        c if np.isfinite(x) else "∞" if x > 0.0 else "-∞"
        for c, x in zip(words.format_column([x / size for x in values]), values, strict=True)
    ]
    heads, columns = [who, f"least {what}\n{name}", f"largest\n{name}"], [list(names), cells[::2], cells[1::2]]
    if shares is not None:
        heads, columns = [*heads, "of limit"], [*columns, shares]
    return TextTable(tuple(heads), tuple(zip(*columns, strict=True)), "<>>>"[: len(heads)])


def is_apart(bounds: Array, force: float) -> Array:
    """(…,) whether the two in the last axis of bounds (…, 2) differ; force : of the scene [N]."""
    return np.asarray(~(bounds[..., 1] - bounds[..., 0] <= _EQUAL_BOUNDS_SHARE * force))


def torque_shares(torques: Array, limit: Array) -> Array:
    """(nv, 2) least and largest |torque| / limit of bounds (nv, 2) and limits (nv,), 0 where that is infinite."""
    low, high = torques.T
    least = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(abs(low), abs(high)))
    both, limited = np.column_stack([least, np.maximum(abs(low), abs(high))]), np.isfinite(limit)[:, None]
    return read_only(np.where(limited, both, 0.0) / np.where(limited, limit[:, None], 1.0))


# ----------------------------------------------------------------


@track_progress("bounding forces")
def find_force_bounds(solution: Any, pads: Any, friction: Any) -> ForceBounds:
    """Of a `GraspSolution`; see there."""
    s = solution
    if not s.held or s.spec is None or s.scene is None:
        raise InputError("solution", "a solution that is held: others have no forces", s.status.name)
    if foreign := [e.title for e in s.spec.effects if not e.only_limits]:
        raise Unsupported(f"force_bounds: nobody knows what is left open beside {words.list_names(foreign)}")
    factors = _check_factors("pads", pads), _check_factors("friction", friction)
    ranges = None if factors == (_UNCHANGED, _UNCHANGED) else FactorRanges(*factors, own_flexibility(s))
    scene, n, mechanism = s.scene, s.scene.n, s.spec.mechanism
    found, torques = ReadingExtremes(np.zeros((3 * n, 2)), np.zeros(n, bool), 0.0), solution_torques(s)
    moved = np.zeros((len(torques), 2))
    if ranges is not None or not _is_determined(s):
        scale = np.ones(scene.components) if scene.scale is None else scene.scale
        found = find_extremes(
            keep_states(s), np.concatenate([np.diag(scale)[: 3 * n], _torque_rows(s) * scale]), ranges
        )
        moved = found.change[3 * n :] * scene.units.force_unit
    forces = s.forces.reshape(-1, 1) + found.change[: 3 * n] * scene.units.force_unit
    return ForceBounds(
        s.names,
        read_only(forces.reshape(n, 3, 2)),
        () if mechanism is None else mechanism.names,
        read_only(torques[:, None] + moved),
        np.zeros(0) if mechanism is None else mechanism.limits,
        *factors,
        tuple([name for name, yes in zip(s.names, found.wider.tolist(), strict=True) if yes]),
        found.gap,
        s.residuals.force_scale,
    )


def find_torque_bounds(s: Any) -> Array:
    """(nv, 2) `ForceBounds.torques` alone, of a solution that leaves forces open."""
    scale = np.ones(s.scene.components) if s.scene.scale is None else s.scene.scale
    found = find_extremes(keep_states(s), _torque_rows(s) * scale, None)
    return np.asarray(solution_torques(s)[:, None] + found.change * s.scene.units.force_unit)


def solution_torques(s: Any) -> Array:
    """(nv,) N·m; none without a hand."""
    return np.asarray(getattr(s, "torques", np.zeros(0)))


def _is_determined(s: Any) -> bool:
    """Whether the solution itself says that forces are determined. It does not look at all that contacts and limits may
    do where they are at rest, nor at forces that may leave one of two faces.
    """
    near = 2.0 * ACTIVE_TOLERANCE * max(s.residuals.motion_scale, s.scene.units.motion_unit)
    states = contact_statuses(s.contact_state)
    rests = [state == SEPARATED and gap <= near for state, gap in zip(states, s.gap.tolist(), strict=True)]
    known = s.uniqueness is not None and s.uniqueness.forces_determined
    faces = isinstance(s.section, Pyramid) and SLIDING in states
    return known and not faces and not any(rests) and not any(e.stamps for e in s.spec.effects)


def _torque_rows(s: Any) -> Array:
    """(nv, c) what one unit of each force component, in contact axes, changes of the torques. Of joints that yield at
    their limits the equations see to it that nothing changes.
    """
    scene, spec = s.scene, s.spec
    mechanism, c, n = spec.mechanism, scene.components, scene.n
    if mechanism is None:
        return np.zeros((0, c))
    effects = tuple([e for e in spec.effects if not isinstance(e, TorqueSaturation)])
    soft = bool(scene.soft)

    def torque(components: Array) -> Array:
        moments = scene.scatter_torsion(components[3 * n :]) if soft else None
        return np.asarray(
            evaluate_joints(mechanism, scene, effects, components[: 3 * n].reshape(n, 3), moments, {}).torque
        )

    still = torque(np.zeros(c))
    return np.array([torque(unit) - still for unit in np.eye(c)]).T


def _check_factors(argument: str, value: Any) -> tuple[float, float]:
    """(least, largest), with one between them."""
    least, most = check_array(argument, value, (2,)).tolist()
    if not 0.0 < least <= 1.0 <= most:
        raise InputError(argument, "the least and the largest factor, 0 < least ≤ 1 ≤ largest", repr(value)[:80])
    return least, most
