"""`static_load_bounds`: the largest load that friction, effects and torque limits allow, whatever the springs.

    max λ ≥ 0    w₀ + G r + λ w = 0,    r within friction,    A r ≤ b,    |Jᵀ r + g| ≤ τ_max

No grasp holds more than this bound, however it is squeezed and loaded (the static theorem of limit analysis). A linear
program on friction pyramids and in a plane, a second-order cone program on the cone (`solve_conic`). Every factor comes
with the gap between it and what the multipliers prove.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.failure.failure_mode import OPENS, SLIPS, TORQUE
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.load_capacity import (
    ENDED,
    NOTHING_FITS,
    UNBOUNDED,
    Capacity,
    ConeProduct,
    ConicPrograms,
    build_capacity,
    solve_conic,
)
from handlcp.tolerances import CERTIFY_TOLERANCE, RANK_TOLERANCE

# ----------------------------------------------------------------
# The conic programs of the largest loads: their equations, their units, and which loads need no program.
#
# max λ    W r + λ w = -w₀,  E r = e,  h - G r ∈ K
#
# A factor far from one, in units of what the grasp bears, is computed again in units of its own, so that all are
# accurate to the same share of themselves.

_MIN_FACTOR, _MAX_FACTOR = 1e-2, 1e3  # factors that are accurate as they are, in units of what the grasp bears
_MAX_UNIT_CHANGES = 3  # changes of units
_DECIDED_GAP = 1e-3  # a gap that tells nothing from everything
_ZERO_FACTOR = 1e-9  # of what the grasp bears: what it holds of less is nothing


@dataclass(frozen=True, slots=True, eq=False)
class LoadFactors:
    """Of k wrenches, natural units: factors (k,), gaps (k,) relative, forces (k, m), multipliers (k, rows) of the rows
    of the capacity. NaN as in `StaticLoadBounds`.
    """

    factors: Array
    gaps: Array
    forces: Array
    multipliers: Array


class DeepestBalance(NamedTuple):
    """Forces (m,) that balance a load with as much room to every limit as there is, natural units, NaN where none are
    known; and that room, depth ≤ 1, in units of what the grasp bears: < 0 where none balance it at all.
    """

    depth: float
    forces: Array


def find_deepest_balance(capacity: Capacity, base: Array) -> DeepestBalance:
    """The largest t ≤ 1 such that forces with t of room to every limit balance base (dof,), and these forces."""
    A, b = _equality_rows(capacity, base)
    size, kept = _bearing_size(capacity, base), _row_space(A)
    nothing = DeepestBalance(-1.0, np.full(capacity.G.shape[1], np.nan))
    if (abs(b - kept.T @ (kept @ b)) > RANK_TOLERANCE * max(size, float(abs(b).max(initial=0.0)))).any():
        return nothing
    G, cones = capacity.G, capacity.cones
    room = np.column_stack([G, cones.unit])
    lid = np.append(np.zeros(G.shape[1]), 1.0)[None]
    program = ConicPrograms(
        -lid[0],
        np.column_stack([kept @ A, np.zeros(len(kept))])[None],
        (kept @ b / size)[None],
        np.concatenate([lid, room]),
        np.append(1.0, capacity.h / size)[None],
        ConeProduct(cones.linear + 1, cones.second_order),  # with the lid in front
    )
    found = solve_conic(program)
    return DeepestBalance(float(found.x[0, -1]), found.x[0, :-1] * size) if found.status[0] == ENDED else nothing


def largest_factors(capacity: Capacity, base: Array, wrenches: Array) -> LoadFactors:
    """The factors of wrenches (k, dof) beside a base (dof,) that is balanced."""
    k, m, rows = len(wrenches), capacity.G.shape[1], len(capacity.h)
    out = LoadFactors(np.zeros(k), np.zeros(k), np.full((k, m), np.nan), np.zeros((k, rows)))
    length = np.sqrt((wrenches**2).sum(axis=1))
    A, _ = _equality_rows(capacity, base)
    kept = _row_space(A)
    column = np.concatenate([wrenches, np.zeros((k, len(capacity.values)))], axis=1)
    outside = abs(column - column @ kept.T @ kept).max(axis=1, initial=0.0) > RANK_TOLERANCE * length
    out.factors[length == 0.0] = np.inf
    todo = np.flatnonzero((length > 0.0) & ~outside)
    units = np.full(k, _bearing_size(capacity, base))
    for _ in range(_MAX_UNIT_CHANGES):
        if not len(todo):
            break
        found = _solve_programs(capacity, base, wrenches[todo], units[todo], kept, length[todo])
        out.factors[todo], out.gaps[todo] = found.factors, found.gaps
        out.forces[todo], out.multipliers[todo] = found.forces, found.multipliers
        share = out.factors[todo] * length[todo] / units[todo]
        far = np.isfinite(share) & ((share < _MIN_FACTOR) | (share > _MAX_FACTOR)) & (share > _ZERO_FACTOR)
        units[todo] *= np.where(far, share, 1.0)
        todo = todo[far]
    if not (base.any() or capacity.h.any() or capacity.values.any()):  # a cone bears all of a load, or nothing
        decided = (out.gaps < _DECIDED_GAP) & ~np.isinf(out.factors)
        out.factors[decided], out.gaps[decided] = 0.0, 0.0
    nothing = out.factors * length < _ZERO_FACTOR * _bearing_size(capacity, base)
    out.factors[nothing], out.gaps[nothing] = 0.0, 0.0
    return out


def _solve_programs(
    capacity: Capacity, base: Array, wrenches: Array, units: Array, kept: Array, length: Array
) -> LoadFactors:
    """The programs of wrenches (p, dof) in units (p,) of force."""
    p, m, (A, b), cones = len(wrenches), capacity.G.shape[1], _equality_rows(capacity, base), capacity.cones
    column = np.concatenate([wrenches / length[:, None], np.zeros((p, len(capacity.values)))], axis=1)
    whole = np.concatenate([np.tile(kept @ A, (p, 1, 1)), (column @ kept.T)[:, :, None]], axis=2)
    up = np.append(np.zeros(m), 1.0)
    G = np.concatenate([-up[None], np.column_stack([capacity.G, np.zeros(len(capacity.h))])])
    h = np.column_stack([np.zeros(p), np.outer(1.0 / units, capacity.h)])
    more = ConeProduct(cones.linear + 1, cones.second_order)  # with λ ≥ 0 in front
    found = solve_conic(ConicPrograms(-up, whole, np.outer(1.0 / units, kept @ b), G, h, more))
    factors = np.where(found.status == ENDED, found.x[:, -1] * units / length, np.nan)
    factors[found.status == UNBOUNDED] = np.inf
    factors[found.status == NOTHING_FITS] = 0.0
    with np.errstate(divide="ignore"):
        gaps = found.gap * np.maximum(1.0, units / (factors * length))  # relative to the factor
    gaps[~(factors > 0.0)] = found.gap[~(factors > 0.0)]
    ended = (found.status == ENDED)[:, None]
    forces, z = np.where(ended, found.x[:, :m] * units[:, None], np.nan), np.where(ended, found.z[:, 1:], 0.0)
    return LoadFactors(np.maximum(factors, 0.0), gaps, forces, z)


def _equality_rows(capacity: Capacity, base: Array) -> tuple[Array, Array]:
    """The equations of balance and of forces that are known: rows (e, m) and right-hand sides (e,)."""
    return np.concatenate([capacity.wrenches, capacity.equations]), np.concatenate([-base, capacity.values])


def _row_space(A: Array) -> Array:
    """(r, e) an orthonormal basis, in rows, of what the columns of A span."""
    u, s, _ = np.linalg.svd(A, full_matrices=False)
    return np.ascontiguousarray(u[:, s > RANK_TOLERANCE * s.max(initial=0.0)].T)


def _bearing_size(capacity: Capacity, base: Array) -> float:
    """Of what the grasp bears: the geometric mean of its limits and of the load that is there."""
    numbers = np.concatenate([abs(capacity.h), abs(capacity.values), [np.sqrt(base @ base)]])
    numbers = numbers[numbers > 0.0]
    return float(np.exp(np.log(numbers).mean())) if len(numbers) else 1.0


# ----------------------------------------------------------------

_BINDING_SHARE = 1e-6  # share of the largest multiplier, from which a row binds
_OPEN_FORCE_SHARE = 1e-6  # of the largest force: a contact that presses with less is open


@dataclass(frozen=True, eq=False)
class StaticLoadBounds:
    """The largest factors of k wrenches, without compliance, and what binds there.

    factors (k,) : inf where nothing ever binds; 0 where the wrench cannot be balanced at all, or where even what is
    there beside it cannot (`balanced` is False then); NaN where the method stopped short of an answer.
    gaps (k,) : how far each may be from the optimum, relative: between the factor and what the multipliers prove, with
    what rounding leaves of the equations. forces (k, n, 3) : contact axes [N], at the bound; NaN where it is not
    finite. slips, opens (k, n) : contacts whose friction binds, or that would have to pull. torque (k, nv) : joints
    whose torque binds. limited (k, e) : effects whose limits do. names, joints, effects : what these columns stand for.
    """

    factors: Array
    gaps: Array
    balanced: bool
    forces: Array
    slips: Bools
    opens: Bools
    torque: Bools
    limited: Bools
    names: tuple[str, ...]
    joints: tuple[str, ...]
    effects: tuple[str, ...]

    def binds(self, k: int) -> tuple[tuple[str, str], ...]:
        """(kind, who) of all that binds at the factor of wrench number k; kind: "slips", "opens", "torque", "force"
        (a limit of an effect). Empty where the factor is not finite.
        """
        every = (
            (SLIPS, self.slips, self.names),
            (OPENS, self.opens, self.names),
            (TORQUE, self.torque, self.joints),
            ("force", self.limited, self.effects),
        )
        return tuple([(kind, names[j]) for kind, mask, names in every for j in np.flatnonzero(mask[k])])


def static_load_bounds(
    spec: GraspSpec, section: Section, wrenches: Array, base: Array | None = None, torques: bool = True
) -> StaticLoadBounds:
    """The bounds of wrenches (k, 6) about the grasp's reference [N, N·m], in place of the grasp's own load.

    base (6,) : the wrench that is there beside them; None: what rests on the object, as `GraspSpec.resting_wrench`.
    torques : whether joints' torque limits count, whether joints yield there or not. In a plane only what acts in it
    counts.
    """
    scene = build_scene(spec)
    base = spec.resting_wrench if base is None else base
    capacity = build_capacity(scene, section, spec.effects, torques)
    own, given = _natural_wrenches(spec, scene, np.array([spec.wrench, base]))
    there = scene.natural.w - own + given  # prescribed forces are part of it
    balanced = find_deepest_balance(capacity, there).depth >= -CERTIFY_TOLERANCE
    k, m = len(wrenches), capacity.G.shape[1]
    if balanced:
        found = largest_factors(capacity, there, _natural_wrenches(spec, scene, wrenches))
    else:
        found = LoadFactors(np.zeros(k), np.zeros(k), np.full((k, m), np.nan), np.zeros((k, len(capacity.h))))

    joints, n = () if spec.mechanism is None else spec.mechanism.names, scene.n
    c = np.zeros((k, scene.components))
    c[:, scene.kind.index] = found.forces
    if scene.prescribed is not None:
        c += scene.prescribed / scene.units.force_unit
    normal = c[:, 2 : 3 * n : 3]
    forces = scene.forces_to_contact_axes(c)[:, : 3 * n].reshape(k, n, 3) * scene.units.force_unit
    heavy = abs(found.multipliers).max(axis=1, initial=0.0, keepdims=True)
    binding = (abs(found.multipliers) > _BINDING_SHARE * heavy) & np.isfinite(found.factors)[:, None]
    contact = _any_by_owner(binding, capacity.contact, n)
    light = normal < _OPEN_FORCE_SHARE * np.nanmax(abs(normal), axis=1, initial=0.0, keepdims=True)
    rough = np.array(scene.kind.tangent_count) > 0
    return StaticLoadBounds(
        read_only(found.factors),
        read_only(found.gaps),
        balanced,
        read_only(forces),
        contact & ~light & rough,
        contact & (light | ~rough),
        _any_by_owner(binding, capacity.joint, len(joints)),
        _any_by_owner(binding, capacity.effect, len(capacity.effects)),
        spec.names,
        joints,
        tuple([e.called for e in capacity.effects]),
    )


def _natural_wrenches(spec: GraspSpec, scene: Scene, wrenches: Array) -> Array:
    """(k, dof) of wrenches (k, 6) about the grasp's reference."""
    u, force = scene.units, wrenches[:, :3]
    moment = wrenches[:, 3:] + cross_rows(np.broadcast_to(spec.reference - u.centre, force.shape), force)
    return np.asarray(np.concatenate([force, moment / u.length_unit], axis=1) @ scene.freedom.T / u.force_unit)


def _any_by_owner(binding: Bools, owner: Ints, count: int) -> Bools:
    """(k, count) whether any row of each owner binds."""
    out = np.zeros((len(binding), count), dtype=bool)
    for j in np.unique(owner[owner >= 0]):
        out[:, j] = binding[:, owner == j].any(axis=1)
    return out
