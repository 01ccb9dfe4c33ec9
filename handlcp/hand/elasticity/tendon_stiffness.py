"""The stiffness of joints that tendons move, and what the tendons do: where arms are given, and along routes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Self, TypeVar

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.cables import Cables
from handlcp.hand.elasticity.elasticity import TENSION, Effort, spanned
from handlcp.hand.elasticity.laid import Laid, Lays
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.route import BoundRoutes, Route
from handlcp.hand.elasticity.stiffness import JointStiffness, inverse_root
from handlcp.hand.elasticity.tendon_motors import check_driven_once, read_tendon_motors
from handlcp.tolerances import SEMIDEFINITE

EQUATION = "K = K_p + Rᵀ k R,  t = k R δq"
Way = Callable[[Array], tuple[Cables, Array]]
Stiff = TypeVar("Stiff", bound="TendonStiffness")
_MADE = 1e-6  # of the largest torque of a command: less is rounding
_KEPT = 8  # postures, which steps ask for again
_SHARE = 0.1  # of the largest motion: joints that move less are not named as loose


@dataclass(frozen=True, eq=False)
class Made:
    """Tendons over joints: names (t,), joints (nv,), springs (t, t), passive (nv, nv) with inf of rigid joints,
    pretension and limits (t,), how they lie, and their motors. stated : whether a file says all of it.
    """

    names: tuple[str, ...]
    joints: Sequence[str]
    springs: Array
    passive: Array
    pretension: Array
    limits: Array
    lays: Lays
    drives: Drives | None
    stated: bool = False

    def at(self, kind: type[Stiff], bound: BoundRoutes | None, q: Array, way: Way | None) -> Stiff:
        """Of this kind, in a posture q (nv,)."""
        laid = self.lays.at(bound, q)
        cables = self._there(laid, way)
        through = cables.arms.T @ self.springs @ cables.arms  # no load reaches the tendons through a rigid joint
        K = self.passive + (through + through.T) / 2
        if not self._least > SEMIDEFINITE * float(through.trace() + self._own):  # no less than its largest eigenvalue
            check_sprung(K, ~self._gives, self.joints)
        made = kind(K, laid.arms, cables, self._root(K))
        return made if self.drives is None else made.driven(self.drives, self.limits)

    def _root(self, K: Array) -> Array | None:
        """(nv, nv) as of `JointStiffness`; None: not known."""
        if not self.lays.routes or not self._all_give:
            return None
        A = np.zeros_like(K)
        return A if inverse_root(K, A) else None

    @cached_property
    def _gives(self) -> Bools:
        """(nv,) joints that are not rigid."""
        return np.asarray(np.isfinite(np.diagonal(self.passive)))

    @cached_property
    def _all_give(self) -> bool:
        return bool(self._gives.all())

    @cached_property
    def _least(self) -> float:
        """The least stiffness that joints' own springs give any motion [N·m/rad]: where it counts, no arm matters."""
        own = self.passive[np.ix_(self._gives, self._gives)]
        return float(np.linalg.eigvalsh(own)[0]) if len(own) else np.inf

    @cached_property
    def _own(self) -> float:
        """Trace of these springs."""
        return float(np.diagonal(self.passive)[self._gives].sum())

    @cached_property
    def _cables(self) -> Cables:
        """What of them is the same in every posture."""
        none, posts = np.zeros(len(self.joints)), self.lays.posts
        own = read_only(np.where(np.isinf(self.passive), 0.0, self.passive))
        most, arms = held(self.drives, self.limits), self.lays.arms
        return Cables(
            self.names, arms, self.springs, own, none, self.pretension, most, posts.of, posts.grips, posts.rows, none,
            around=self.lays.around(self.names),
        )  # fmt: skip

    def _there(self, laid: Laid, way: Way | None) -> Cables:
        """As a path needs them."""
        arms, posts = laid.arms, laid.posts
        if not self._all_give:
            arms, posts = (read_only(np.where(self._gives, rows, 0.0)) for rows in (arms, posts))
        turning = laid.turning
        if turning is not None and not self._all_give:
            turning = partial(self._turning, turning)
        return self._cables._replace(
            arms=arms, grips=laid.grips, posts=posts, shift=laid.shift, way=way, turning=turning, sides=laid.sides
        )

    def _turning(self, turning: Callable[[Array], Array], tension: Array) -> Array:
        """As `Cables` has it, 0 of rigid joints."""
        return np.asarray(turning(tension) * np.outer(self._gives, self._gives))


class TendonStiffness(JointStiffness):
    """K = K_p + Rᵀ k R, and the tendons behind it; arms (t, nv) : R as it was given. drives : motors of tendons, None
    without; bears (t,) : what tendons bear, whatever their motors hold [N]. `cables.limits` are the smaller of both.
    """

    drives: Drives | None = None

    def __init__(self, matrix: Array, arms: Array, cables: Cables, root: Array | None = None) -> None:
        super().__init__(matrix, root=root)
        self.arms, self.cables, self.bears = arms, cables, cables.limits

    def driven(self, drives: Drives | None, bears: Array) -> Self:
        """The same with these motors, of tendons that bear so much, (t,) [N]."""
        made = copy(self)
        made.drives, made.bears, made.cables = drives, bears, self.cables._replace(limits=held(drives, bears))
        return made

    @property
    def names(self) -> tuple[str, ...]:
        """(t,) of the tendons."""
        return self.cables.names

    def motored(self, motors: Mapping[str, Any] | None) -> TendonStiffness:
        """The same with motors by tendon, None: without. Raises InputError, UnknownName."""
        return self.driven(read_tendon_motors(motors, self.names, self.cables.pretension), self.bears)

    @property
    def closes(self) -> Array:
        """(t,) with which motors can draw tendons in [N]; inf where no motor says it."""
        return np.full(len(self.bears), np.inf) if self.drives is None else self.drives.closes

    def check_driven_once(self, drives: Drives | None, joints: Sequence[str]) -> None:
        """No joint has a motor of its own that a tendon with a motor moves."""
        check_driven_once(self.arms, self.drives, drives, joints)

    @property
    def routes(self) -> dict[str, Route]:
        """Of the tendons that have one, by name."""
        return {}

    @property
    def own_springs(self) -> Array:
        """Of `passive`."""
        return np.asarray(self.cables.passive.diagonal())

    @property
    def commands(self) -> Array:
        """K⁻¹ Rᵀ: where the springs let the joints go when a tendon is drawn in."""
        return spanned(self.root @ (self.arms @ self.root).T)

    def stiffer(self, factor: float) -> TendonStiffness:
        """The same with every spring so many times as stiff."""
        c = self.cables
        springs, passive = read_only(factor * c.springs), read_only(factor * c.passive)
        made = TendonStiffness(self.matrix * factor, self.arms, c._replace(springs=springs, passive=passive))
        return made.driven(self.drives, self.bears)

    def effort(self, torque: Array, command: Array) -> Effort:
        """The tension t = k R K⁻¹ τ + t_c [N]: how much harder each tendon pulls; below 0 it pulls less. t_c is what it
        takes to turn the joints to where they are commanded against their own springs, Rᵀ t_c = K_p δq_c.
        """
        c = self.cables
        tension = c.springs @ (self.arms @ self.deflection(torque))
        if command.any():
            tension = tension + np.linalg.lstsq(self.arms.T, c.passive @ command)[0]
        return self._effort(tension, tension + c.begun)

    def tensions(self, values: Array) -> Effort:
        """With which tendons pull, (t,) [N]."""
        return self._effort(values, values)

    def _effort(self, values: Array, whole: Array) -> Effort:
        """Of tendons; whole (t,) : tensions with what they pulled with before [N]."""
        limits = self.cables.limits
        return Effort(TENSION, "N", self.names, read_only(values), limits, read_only(np.maximum(whole, 0.0) / limits))

    def pulled(self, torque: Array, command: Array) -> Array:
        """Rᵀ t."""
        return np.asarray(self.arms.T @ self.effort(torque, command).values)

    def beyond(self, command: Array) -> Array:
        """Tendons that pull make torques Rᵀ (t - T₀), none of them below 0; what else K δq_c asks for, springs at the
        joints would have to be commanded to, or tendons would have to push.
        """
        asked = self.asked(command)
        left = self.cables.not_made(asked)
        return np.where(abs(left) > _MADE * abs(asked).max(initial=0.0), left, 0.0)

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        t, nv = self.arms.shape
        return EQUATION, f"{t} tendon{'s' if t > 1 else ''} over {nv} joints"


class RoutedStiffness(TendonStiffness):
    """Of tendons that run along routes, in one posture."""

    _made: Made
    _on: Postures
    _q: Array

    @property
    def stated(self) -> bool:
        """As made."""
        return self._made.stated

    def as_stated(self) -> RoutedStiffness:
        """The same, said by a file."""
        return self.of(replace(self._made, stated=True), self._on.kinematics, self._q)

    @classmethod
    def of(cls, made: Made, kinematics: Any, q: Array) -> RoutedStiffness:
        """On the links of a hand, at q (nv,). Raises InputError, UnknownName."""
        return Postures(made, kinematics).at(q)

    @property
    def routes(self) -> dict[str, Route]:
        """Of the tendons that have one, by name."""
        return {self._made.names[i]: route for i, route in self._made.lays.routes.items()}

    def motored(self, motors: Mapping[str, Any] | None) -> RoutedStiffness:
        """The same with motors by tendon, None: without. Raises InputError, UnknownName."""
        drives = read_tendon_motors(motors, self.names, self.cables.pretension)
        return self.of(replace(self._made, drives=drives), self._on.kinematics, self._q)

    def at(self, kinematics: Any, q: Array) -> RoutedStiffness:
        """In another posture, of a hand with these kinematics."""
        return self._on.at(q) if kinematics is self._on.kinematics else self.of(self._made, kinematics, q)

    def laid_on(self, kinematics: Any, point: Callable[[str, Array], Array]) -> RoutedStiffness:
        """On links of other lengths, of a hand with these kinematics; point : where a point (3,) of a link is then."""
        return self.of(replace(self._made, lays=self._made.lays.moved(point)), kinematics, self._q)


class Postures:
    """Tendons along routes on the links of a hand, in one posture after the other. Raises UnknownName."""

    def __init__(self, made: Made, kinematics: Any) -> None:
        self.made, self.kinematics = made, kinematics
        self._bound = made.lays.bound(kinematics, made.names)
        self._lately = dict[bytes, RoutedStiffness]()

    def at(self, q: Array) -> RoutedStiffness:
        """With joints at q (nv,). Raises InputError."""
        key = q.tobytes()
        if (found := self._lately.get(key)) is None:
            if len(self._lately) >= _KEPT:
                self._lately.clear()
            found = self._lately[key] = self.made.at(RoutedStiffness, self._bound, q, self.way)
            found._made, found._on, found._q = self.made, self, q
        return found

    def way(self, q: Array) -> tuple[Cables, Array]:
        """As `Cables` asks for it."""
        there = self.at(q)
        return there.cables, there.root

    def __getstate__(self) -> dict[str, Any]:
        """Without what it has worked out lately."""
        return {**self.__dict__, "_lately": {}}


def held(drives: Drives | None, bears: Array) -> Array:
    """(t,) what tendons that bear so much (t,) hold for good with these motors [N]."""
    return bears if drives is None else read_only(np.minimum(bears, drives.holds(bears)))


def check_sprung(K: Array, rigid: Bools, joints: Sequence[str]) -> None:
    """Raises InputError with the joints of every motion that K does not resist."""
    free = np.flatnonzero(~rigid)
    size = np.sqrt(np.diagonal(K)[free])
    size[size == 0.0] = 1.0
    scaled = K[np.ix_(free, free)] / np.outer(size, size)  # without units, so that hinges and slides compare
    stiff, motions = np.linalg.eigh(scaled)
    loose = motions[:, stiff <= SEMIDEFINITE * max(1.0, float(stiff[-1]))] if len(free) else motions
    if loose.shape[1]:
        moves = abs(loose).max(axis=1)
        named = [joints[i] for i, m in zip(free.tolist(), moves, strict=True) if m > _SHARE * moves.max()]
        expected = "tendons and passive springs that leave no joint without one"
        together = " against each other" if len(named) > loose.shape[1] else ""
        raise InputError("Tendons.passive", expected, f"nothing that springs back {', '.join(named)}{together}")
