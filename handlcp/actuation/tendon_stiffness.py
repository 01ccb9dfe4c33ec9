"""`TendonStiffness`: the stiffness of joints that tendons move, by given arms or along routes; and what tendons do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np

from handlcp.actuation.cable_routing import CableRouting
from handlcp.actuation.joint_stiffness import TENDON_TENSION, Effort, JointStiffness, orthonormal_basis
from handlcp.actuation.motor import Drives, check_driven_once, read_tendon_motors
from handlcp.actuation.route import BoundRoutes, Route
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import Cables
from handlcp.kinematics.cable_kinematics import RoutedTendons
from handlcp.lcp.kernels.dense import inverse_root
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

TENDON_EQUATION = "K = K_p + Rᵀ k R,  t = k R δq"
CablesAtPosture = Callable[[Array], tuple[Cables, Array]]
TendonStiffnessT = TypeVar("TendonStiffnessT", bound="TendonStiffness")
_TORQUE_ROUNDING = 1e-6  # of the largest torque of a command: less is rounding
_MAX_CACHED_POSTURES = 8  # postures, which steps ask for again
_MIN_LOOSE_SHARE = 0.1  # of the largest motion: joints that move less are not named as loose


@dataclass(frozen=True, eq=False)
class TendonModel:
    """Tendons over joints as they were given, before they lie in a posture.

    names (t,), joints (nv,) : of the tendons and of the joints.
    springs (t, t), passive (nv, nv) : stiffness of the tendons and of the joints beside them, inf of rigid joints.
    pretension (t,) : tensions before the hand closes [N].
    strength (t,) : tensions that tendons bear, whatever their motors hold [N].
    routing : where the tendons run.
    drives : their motors.
    is_from_file : whether a file says all of it.
    """

    names: tuple[str, ...]
    joints: Sequence[str]
    springs: Array
    passive: Array
    pretension: Array
    strength: Array
    routing: CableRouting
    drives: Drives | None
    is_from_file: bool = False

    def elasticity_at(
        self,
        kind: type[TendonStiffnessT],
        bound_routes: BoundRoutes | None,
        q: Array,
        cables_at: CablesAtPosture | None,
    ) -> TendonStiffnessT:
        """The elasticity of the joints with the tendons in a posture q (nv,), of this kind; bound_routes : the tendons'
        routes on the links of the hand, None without. cables_at : `elasticity_at` of its `Cables`.
        """
        elastic = self._is_elastic
        cables, arms = self.routing.lay_out(bound_routes, q, self._given_cables, elastic)
        cables = cables._replace(elasticity_at=cables_at)
        through = cables.arms.T @ self.springs @ cables.arms
        K, (least, total) = self.passive + (through + through.T) / 2, self._passive_size
        # No less than SEMIDEFINITE_TOLERANCE times its largest eigenvalue
        if not least > SEMIDEFINITE_TOLERANCE * float(through.trace() + total):
            check_no_loose_motion(K, ~elastic, self.joints)
        root = np.zeros_like(K) if self.routing.routes and elastic.all() else None
        if root is not None and not inverse_root(K, root):
            root = None
        made = kind(K, arms, cables, root)
        return made if self.drives is None else made.with_motors(self.drives, self.strength)

    def bind(self, bound_routes: BoundRoutes) -> RoutedTendons:
        """The tendons as compiled code reads them, with their routes on the links of the hand."""
        return self.routing.bind(bound_routes, self._given_cables, self._is_elastic)

    @cached_property
    def _is_elastic(self) -> Bools:
        """(nv,) joints that are not rigid."""
        return np.asarray(np.isfinite(np.diagonal(self.passive)))

    @cached_property
    def _passive_size(self) -> tuple[float, float]:
        """Least and summed stiffness of the joints' own springs [N·m/rad]; where the least counts, no arm matters."""
        own = self.passive[np.ix_(self._is_elastic, self._is_elastic)]
        return float(np.linalg.eigvalsh(own)[0]) if len(own) else np.inf, float(own.trace())

    @cached_property
    def _given_cables(self) -> Cables:
        """With the arms that were given: what is the same in every posture, and in all of them without routes. No load
        reaches tendons through a rigid joint: its arms are 0.
        """
        none, posts, elastic = np.zeros(len(self.joints)), self.routing.posts, self._is_elastic
        own = read_only(np.where(np.isinf(self.passive), 0.0, self.passive))
        most, still = tension_limits(self.drives, self.strength), read_only(np.zeros(len(self.names)))
        arms, beyond = (read_only(np.where(elastic, rows, 0.0)) for rows in (self.routing.arms, posts.arms_beyond))
        cables = Cables(
            self.names, arms, self.springs, own, none, self.pretension, most, posts.post_tendon, posts.friction, beyond,
            still,
        )  # fmt: skip
        return cables._replace(wrapped_bodies=self.routing.describe_bodies(self.names))


class TendonStiffness(JointStiffness):
    """K = K_p + Rᵀ k R, and the tendons behind it; arms (t, nv) : R as it was given. drives : motors of tendons, None
    without. strength (t,) : what tendons bear, whatever their motors hold [N]. `cables.limits` are the smaller of both.
    """

    drives: Drives | None = None

    def __init__(self, matrix: Array, arms: Array, cables: Cables, root: Array | None = None) -> None:
        super().__init__(matrix, root=root)
        self.arms, self.cables, self.strength = arms, cables, cables.limits

    def with_motors(self, drives: Drives | None, strength: Array) -> Self:
        """The same with these motors, of tendons that bear so much, strength (t,) [N]."""
        made = copy(self)
        made.drives, made.strength = drives, strength
        made.cables = self.cables._replace(limits=tension_limits(drives, strength))
        return made

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the t tendons, in their order."""
        return self.cables.names

    def motored(self, motors: Mapping[str, Any] | None) -> TendonStiffness:
        """The same with motors by tendon, None: without. Raises InputError, UnknownName."""
        return self.with_motors(read_tendon_motors(motors, self.names, self.cables.pretension), self.strength)

    @property
    def closing_tensions(self) -> Array:
        """(t,) with which motors can draw tendons in [N]; inf where no motor says it."""
        return np.full(len(self.strength), np.inf) if self.drives is None else self.drives.closing_limits

    def check_driven_once(self, drives: Drives | None, joints: Sequence[str]) -> None:
        """No joint has a motor of its own that a tendon with a motor moves."""
        check_driven_once(self.arms, self.drives, drives, joints)

    @property
    def routes(self) -> dict[str, Route]:
        """Of the tendons that have one, by name."""
        return {}

    @property
    def joint_springs(self) -> Array:
        """The springs of the joints themselves (nv,), without the tendons [N·m/rad, N/m]."""
        return np.asarray(self.cables.passive.diagonal())

    @property
    def command_directions(self) -> Array:
        """An orthonormal basis of K⁻¹ Rᵀ, where the springs let the joints go when a tendon is drawn in."""
        return orthonormal_basis(self.compliance_factor @ (self.arms @ self.compliance_factor).T)

    def scale_stiffness(self, factor: float) -> TendonStiffness:
        """The same with every spring so many times as stiff."""
        c = self.cables
        springs, passive = read_only(factor * c.springs), read_only(factor * c.passive)
        made = TendonStiffness(self.stiffness_matrix * factor, self.arms, c._replace(springs=springs, passive=passive))
        return made.with_motors(self.drives, self.strength)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The tension t = k R K⁻¹ τ + t_c [N]: how much harder each tendon pulls; below 0 it pulls less. t_c is what it
        takes to turn the joints to where they are commanded against their own springs, Rᵀ t_c = K_p δq_c.
        """
        c = self.cables
        tension = c.springs @ (self.arms @ self.deflection(torque))
        if command.any():
            tension = tension + np.linalg.lstsq(self.arms.T, c.passive @ command)[0]
        return self._make_effort(tension, tension + c.initial_tension)

    def tension_effort(self, values: Array) -> Effort:
        """With which tendons pull, (t,) [N]."""
        return self._make_effort(values, values)

    def _make_effort(self, values: Array, whole: Array) -> Effort:
        """Tensions beside their limits: values (t,) are shown, whole (t,), pretension included, are compared [N]."""
        limits = self.cables.limits
        used = read_only(np.maximum(whole, 0.0) / limits)
        return Effort(TENDON_TENSION, "N", self.names, read_only(values), limits, used)

    def actuator_torque(self, torque: Array, command: Array) -> Array:
        """The torques (nv,) that the tendons' tensions t make at the joints, Rᵀ t [N·m, N]."""
        return np.asarray(self.arms.T @ self.effort(torque, command).values)

    def unmade_torque(self, command: Array) -> Array:
        """Tendons that pull make torques Rᵀ (t - T₀), none of them below 0; what else K δq_c asks for, springs at the
        joints would have to be commanded to, or tendons would have to push.
        """
        asked = self.command_torque(command)
        left = self.cables.unmade_torque(asked)
        return np.where(abs(left) > _TORQUE_ROUNDING * abs(asked).max(initial=0.0), left, 0.0)

    @property
    def law(self) -> tuple[str, str]:
        """The equation of the tendons and what there is of them, for `explain()`."""
        t, nv = self.arms.shape
        return TENDON_EQUATION, f"{t} tendon{'s' if t > 1 else ''} over {nv} joints"


class RoutedStiffness(TendonStiffness):
    """Of tendons that run along routes, in one posture."""

    _cache: TendonPostureCache
    _q: Array

    @property
    def is_from_file(self) -> bool:
        """Whether a file says all that the tendons are made of."""
        return self._cache.model.is_from_file

    def as_from_file(self) -> RoutedStiffness:
        """The same, said by a file."""
        return self.from_model(replace(self._cache.model, is_from_file=True), self._cache.kinematics, self._q)

    @classmethod
    def from_model(cls, made: TendonModel, kinematics: Any, q: Array) -> RoutedStiffness:
        """On the links of a hand, at q (nv,). Raises InputError, UnknownName."""
        return TendonPostureCache(made, kinematics).elasticity_at(q)

    @property
    def routes(self) -> dict[str, Route]:
        """Of the tendons that have one, by name."""
        return {self._cache.model.names[i]: route for i, route in self._cache.model.routing.routes.items()}

    @property
    def routed_tendons(self) -> tuple[RoutedTendons, tuple[int, ...]]:
        """The tendons as compiled code reads them, and Pinocchio's numbers of the frames whose placements a
        `CablePosture` of theirs has, in that order.
        """
        return self._cache.routed_tendons

    def motored(self, motors: Mapping[str, Any] | None) -> RoutedStiffness:
        """The same with motors by tendon, None: without. Raises InputError, UnknownName."""
        drives = read_tendon_motors(motors, self.names, self.cables.pretension)
        return self.from_model(replace(self._cache.model, drives=drives), self._cache.kinematics, self._q)

    def in_posture(self, kinematics: Any, q: Array) -> RoutedStiffness:
        """In another posture, of a hand with these kinematics."""
        if kinematics is self._cache.kinematics:
            return self._cache.elasticity_at(q)
        return self.from_model(self._cache.model, kinematics, q)

    def remap_points(self, kinematics: Any, point: Callable[[str, Array], Array]) -> RoutedStiffness:
        """On links of other lengths, of a hand with these kinematics; point : where a point (3,) of a link is then."""
        model = replace(self._cache.model, routing=self._cache.model.routing.remap_points(point))
        return self.from_model(model, kinematics, self._q)


class TendonPostureCache:
    """Tendons along routes on the links of a hand, in one posture after the other. Raises UnknownName."""

    def __init__(self, made: TendonModel, kinematics: Any) -> None:
        self.model, self.kinematics = made, kinematics
        routes = made.routing.routes
        arguments = tuple([f"Tendons.moment_arms[{made.names[i]!r}]" for i in routes])
        self._bound_routes = BoundRoutes(tuple(routes.values()), kinematics, arguments)
        self._lately = dict[bytes, RoutedStiffness]()

    def elasticity_at(self, q: Array) -> RoutedStiffness:
        """With joints at q (nv,). Raises InputError."""
        key = q.tobytes()
        if (found := self._lately.get(key)) is None:
            if len(self._lately) >= _MAX_CACHED_POSTURES:
                self._lately.clear()
            found = self._lately[key] = self.model.elasticity_at(RoutedStiffness, self._bound_routes, q, self.cables_at)
            found._cache, found._q = self, q
        return found

    @property
    def routed_tendons(self) -> tuple[RoutedTendons, tuple[int, ...]]:
        """As `RoutedStiffness.routed_tendons`."""
        return self.model.bind(self._bound_routes), self._bound_routes.frames

    def cables_at(self, q: Array) -> tuple[Cables, Array]:
        """As `Cables` asks for it."""
        there = self.elasticity_at(q)
        return there.cables, there.compliance_factor

    def __getstate__(self) -> dict[str, Any]:
        """Without what it has worked out lately."""
        return {**self.__dict__, "_lately": {}}


def tension_limits(drives: Drives | None, strength: Array) -> Array:
    """(t,) what tendons that bear so much, strength (t,), hold for good with these motors [N]."""
    return strength if drives is None else read_only(np.minimum(strength, drives.holding_limits(strength)))


def check_no_loose_motion(K: Array, rigid: Bools, joints: Sequence[str]) -> None:
    """Raises InputError with the joints of every motion that K does not resist."""
    free = np.flatnonzero(~rigid)
    size = np.sqrt(np.diagonal(K)[free])
    size[size == 0.0] = 1.0
    scaled = K[np.ix_(free, free)] / np.outer(size, size)  # without units, so that hinges and slides compare
    stiff, motions = np.linalg.eigh(scaled)
    loose = motions[:, stiff <= SEMIDEFINITE_TOLERANCE * max(1.0, float(stiff[-1]))] if len(free) else motions
    if loose.shape[1]:
        moves = abs(loose).max(axis=1)
        named = [joints[i] for i, m in zip(free.tolist(), moves, strict=True) if m > _MIN_LOOSE_SHARE * moves.max()]
        expected = "tendons and passive springs that leave no joint without one"
        together = " against each other" if len(named) > loose.shape[1] else ""
        raise InputError("Tendons.passive", expected, f"nothing that springs back {', '.join(named)}{together}")
