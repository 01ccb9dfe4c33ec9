"""The largest load without compliance: what friction, effects and torque limits alone allow, whatever the springs.

    max λ ≥ 0    w₀ + G r + λ w = 0,    r within friction,    A r ≤ b,    |Jᵀ r + g| ≤ τ_max

No grasp holds more than this bound, however it is squeezed and loaded (the static theorem of limit analysis). A linear
program on friction pyramids and in a plane, a second-order cone program on the cone; many directions are solved
together (`conic`). Every factor comes with the gap between it and what the multipliers prove.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.assembly.build import build
from handlcp.grasp.cause.cause import OPENS, SLIPS, TORQUE
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import cross_rows
from handlcp.grasp.verify.bound_program import Factors, depth, largest
from handlcp.grasp.verify.capacity import Capacity, capacity_of
from handlcp.tolerances import CERTIFY

_BINDS = 1e-6  # share of the largest multiplier, from which a row binds
_LIGHT = 1e-6  # of the largest force: a contact that presses with less is open


@dataclass(frozen=True, eq=False)
class Bounds:
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
        every = ((SLIPS, self.slips, self.names), (OPENS, self.opens, self.names),
                 (TORQUE, self.torque, self.joints), ("force", self.limited, self.effects))  # fmt: skip
        return tuple([(kind, names[j]) for kind, mask, names in every for j in np.flatnonzero(mask[k])])


def bound_of(
    spec: GraspSpec, section: Section, wrenches: Array, base: Array | None = None, torques: bool = True
) -> Bounds:
    """The bounds of wrenches (k, 6) about the grasp's reference [N, N·m], in place of the grasp's own load.

    base (6,) : the wrench that is there beside them; None: the object's weight, where it is known apart from
    the load. torques : whether joints' torque limits count, whether joints yield there or not.
    In a plane only what acts in it counts.
    """
    scene = build(spec)
    if base is None:
        base = np.zeros(6) if spec.mechanism is None else spec.mechanism.weight_of_object(spec.reference)
    capacity = capacity_of(scene, section, spec.effects, torques)
    own, given = _natural(spec, scene, np.array([spec.wrench, base]))
    there = scene.natural.w - own + given  # prescribed forces are part of it
    balanced = depth(capacity, there) >= -CERTIFY
    k, m = len(wrenches), capacity.G.shape[1]
    if balanced:
        found = largest(capacity, there, _natural(spec, scene, wrenches))
    else:
        found = Factors(np.zeros(k), np.zeros(k), np.full((k, m), np.nan), np.zeros((k, len(capacity.h))))
    return _told(spec, scene, capacity, found, balanced)


def _natural(spec: GraspSpec, scene: Scene, wrenches: Array) -> Array:
    """(k, dof) of wrenches (k, 6) about the grasp's reference."""
    u, force = scene.units, wrenches[:, :3]
    moment = wrenches[:, 3:] + cross_rows(np.broadcast_to(spec.reference - u.centre, force.shape), force)
    return np.asarray(np.concatenate([force, moment / u.length], axis=1) @ scene.freedom.T / u.force)


def _told(spec: GraspSpec, scene: Scene, capacity: Capacity, found: Factors, balanced: bool) -> Bounds:
    """In SI, with what binds."""
    k, n = len(found.factors), scene.n
    joints = () if spec.mechanism is None else spec.mechanism.names
    c = np.zeros((k, scene.components))
    c[:, scene.kind.index] = found.forces
    if scene.prescribed is not None:
        c += scene.prescribed / scene.units.force
    normal = c[:, 2 : 3 * n : 3]
    forces = scene.physical(c)[:, : 3 * n].reshape(k, n, 3) * scene.units.force
    heavy = abs(found.multipliers).max(axis=1, initial=0.0, keepdims=True)
    binding = (abs(found.multipliers) > _BINDS * heavy) & np.isfinite(found.factors)[:, None]
    contact = _by(binding, capacity.contact, n)
    light = normal < _LIGHT * np.nanmax(abs(normal), axis=1, initial=0.0, keepdims=True)
    rough = np.array(scene.kind.tangents) > 0
    return Bounds(
        read_only(found.factors), read_only(found.gaps), balanced, read_only(forces), contact & ~light & rough,
        contact & (light | ~rough), _by(binding, capacity.joint, len(joints)),
        _by(binding, capacity.effect, len(capacity.effects)), spec.names, joints,
        tuple([e.called for e in capacity.effects]),
    )  # fmt: skip


def _by(binding: Bools, owner: Ints, count: int) -> Bools:
    """(k, count) whether any row of each owner binds."""
    out = np.zeros((len(binding), count), dtype=bool)
    for j in np.unique(owner[owner >= 0]):
        out[:, j] = binding[:, owner == j].any(axis=1)
    return out
