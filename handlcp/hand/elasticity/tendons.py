"""Tendons: cables that pull at joints, what they bear, and what the stiffness of a hand becomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, array, dimensions, number, per_name, psd, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.explanation import Description
from handlcp.grasp.model.cables import Cables
from handlcp.hand.elasticity.elasticity import TENSION, TRANSMISSION, Effort, Transmission, spanned
from handlcp.hand.elasticity.laid import Laid, Lays, lays_of
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.route import BoundRoute, Route
from handlcp.hand.elasticity.stiffness import (
    JointStiffness,
    given_rows,
    read_rows,
    read_springs,
    springs,
)
from handlcp.hand.elasticity.tendon_motors import check_driven_once, read_tendon_motors
from handlcp.tolerances import SEMIDEFINITE

# ----------------------------------------------------------------
# Tendons: elastic cables over several joints, usually fewer of them than joints.
#
# l = R q,    K = K_p + Rᵀ k R,    τ = Rᵀ t + K_p δq,    t = k R δq
#
# l is the length by which each tendon is drawn in when the joints are at q, and R holds the moment arms. k is the
# stiffness of the tendons, K_p that of the springs at the joints. Under joint torques τ the joints deflect by
# δq = K⁻¹ τ, which stretches the tendons by R δq and raises their tension by t. Drawn in by x they command the joints
# to δq_c = K⁻¹ Rᵀ k x: springs at the joints keep their rest angle, and the tendons pull against them, too. A tendon
# over several joints couples them; one over two fingers is a differential. As k → ∞ the joints can only move such that
# R δq = 0.

TENDONS = Description(
    title=f"{TRANSMISSION}: tendons",
    equation="K = K_p + Rᵀ k R,  t = k R δq",
    when="Fewer cables than joints, a cable over several joints, a differential between fingers.",
    in_python='joint_stiffness=Tendons({"pull": {"finger_1_distal": 0.01, "finger_2_distal": 0.01}}, 2e4, 4.0)',
    in_file="[hand.tendons]\n"
    "moment_arms_m = { pull = { finger_1_distal = 0.01, finger_2_distal = 0.01 } }\n"
    "stiffness_N_per_m = 2e4\n"
    "passive_Nm_per_rad = 4.0",
    brings="none: part of K",
    source="Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation (1994), section 6.4",
    module=__name__,
)

_MADE = 1e-6  # of the largest torque of a command: less is rounding
_SHARE = 0.1  # of the largest motion: joints that move less are not named as loose
_tendon_spring = partial(number, above=0.0)
_passive_spring = partial(number, minimum=0.0, finite=False)
_pretension = partial(number, minimum=0.0, finite=False)
_limit = partial(number, above=0.0, finite=False)
_ARMS = "Tendons.moment_arms"


@dataclass(frozen=True, eq=False)
class Tendons(Transmission):
    """Pass it as a hand's `joint_stiffness`.

    moment_arms : (t, nv) R [m/rad, m/m] over the hand's joints, or a mapping of tendon names to mappings of joint names
        to arms (joints left out: 0), or to a `Route` through the links, whose arms change with the posture. A positive
        arm: pulling the tendon turns the joint to larger angles.
    stiffness : k [N/m] a number, (t,), a mapping by tendon name, or an SPD matrix (t, t).
    passive : springs at the joints themselves [N·m/rad]: a number ≥ 0, a mapping by joint name (joints left out: 0),
        (nv,), or a positive semidefinite matrix (nv, nv); numpy.inf: that joint is rigid.
    pretension : [N] ≥ 0 with which tendons pull in the grasp's posture before the hand closes, springs at the joints in
        balance with them: a number, (t,), or a mapping by tendon name (tendons left out: 0); numpy.inf: taut whatever
        comes, and pushing where it must, as a rod or a sheathed cable does.
    limits : [N] > 0 that tendons bear, in the same forms; numpy.inf, and tendons left out: no limit.
    motors : a `Motor` for every tendon, or a mapping by tendon name (others: none), as in `motors=` of a hand, whose
        reduction is newtons of tension per N·m of the motor, n / r for a spool of radius r behind a gear n. What it
        holds for good limits its tendon beside `limits`; closing is judged by its peak less dry friction, as of joints.
    friction : μθ of the posts or pulleys that a tendon wraps around at its joints, in the order of its arms from the
        drive on: friction times the angle of the wrap [rad], such as 0.16 for 15 % of the tension. A number for every
        joint that a tendon moves, a mapping by tendon name to a number or to a mapping by joint name (those left out:
        0), or (t, nv). Of a route it is μ alone; the angles are those of its wraps.

    In a loading that is followed (`follow`, `check`, `load_limit`) a tendon never pushes: it goes slack, and is a
    spring less. Drives keep all tendons taut while the hand closes, with the least tensions that make its torques; then
    they hold. At a post a tendon loses T (1 - exp(-μθ)) of its tension T where it is drawn in, and is held by up to
    T (exp(μθ) - 1) more where it is drawn out. One solve in one posture takes all tendons as taut and smooth.
    Raises InputError, UnknownName; also when a hand is made with it, where K is singular: the error names the joints
    that no spring drives back.
    """

    moment_arms: Any
    stiffness: Any
    passive: Any = 0.0
    pretension: Any = 0.0
    limits: Any = np.inf
    friction: Any = 0.0
    motors: Any = None

    def __post_init__(self) -> None:
        """Check what does not depend on the joints."""
        arms = _given_arms(self.moment_arms)
        object.__setattr__(self, "moment_arms", arms)
        if not isinstance(self.stiffness, Mapping):
            numbers = [str(i) for i in range(len(arms))]
            read_springs("Tendons.stiffness", self.stiffness, "tendon", numbers, _tendon_spring)
        begun, _ = self._forces(self.names)
        read_tendon_motors(self.motors, self.names, begun)

    @property
    def names(self) -> tuple[str, ...]:
        """(t,) of the tendons."""
        arms = self.moment_arms
        return tuple(arms) if isinstance(arms, dict) else tuple([f"tendon {i + 1}" for i in range(len(arms))])

    def motored(self, motors: Mapping[str, Any]) -> Tendons:
        """The same with motors by tendon."""
        return replace(self, motors=motors)

    def _forces(self, names: Sequence[str]) -> tuple[Array, Array]:
        """(t,) pretension and limits. Raises InputError, UnknownName."""
        begun = _by_tendon("Tendons.pretension", self.pretension, names, _pretension, 0.0)
        most = _by_tendon("Tendons.limits", self.limits, names, _limit, np.inf)
        for name, least, limit in zip(names, begun.tolist(), most.tolist(), strict=True):
            if limit < least < np.inf:
                raise InputError(f"Tendons.limits[{name!r}]", f"at least the pretension, {least:g} N", f"{limit:g} N")
        return begun, most

    def for_joints(self, joints: Sequence[str], kinematics: Any = None) -> TendonStiffness:
        """K over these joints; with routes, in the neutral posture of kinematics. Raises Unsupported without."""
        arms = self.moment_arms
        routed = [] if not isinstance(arms, dict) else [name for name, row in arms.items() if isinstance(row, Route)]
        if not routed:
            names, R = read_rows(_ARMS, arms, "tendon", joints)
        else:
            plain = {name: row for name, row in arms.items() if name not in routed}
            known = read_rows(_ARMS, plain, "tendon", joints)[1] if plain else np.zeros((0, len(joints)))
            names, R = tuple(arms), np.zeros((len(arms), len(joints)))
            R[[name not in routed for name in names]] = known
        k = read_springs("Tendons.stiffness", self.stiffness, "tendon", names, _tendon_spring)
        own = _passive("Tendons.passive", self.passive, joints)
        lays = lays_of(names, R, arms if isinstance(arms, dict) else None, self.friction, joints)
        begun, most = self._forces(names)
        made = _Made(names, joints, k, own, begun, most, lays, read_tendon_motors(self.motors, names, begun))
        if not routed:
            return made.at({}, np.zeros(len(joints)), None)
        if kinematics is None:
            raise Unsupported("tendons with routes need a hand, whose links they pass")
        return RoutedStiffness.of(made, kinematics, kinematics.neutral)


@dataclass(frozen=True, eq=False)
class _Made:
    """Tendons over joints: names (t,), joints (nv,), springs (t, t), passive (nv, nv) with inf of rigid joints,
    pretension and limits (t,), how they lie, and their motors.
    """

    names: tuple[str, ...]
    joints: Sequence[str]
    springs: Array
    passive: Array
    pretension: Array
    limits: Array
    lays: Lays
    drives: Drives | None

    def at(self, bound: dict[int, BoundRoute], q: Array, way: Callable[[Array], Cables] | None) -> TendonStiffness:
        """In a posture q (nv,)."""
        laid = self.lays.at(bound, q)
        K = self.passive.copy()
        rigid = np.isinf(np.diagonal(K))
        through = laid.arms.T @ self.springs @ laid.arms
        through[rigid] = through[:, rigid] = 0.0  # no load reaches the tendons through a rigid joint
        K += (through + through.T) / 2
        _check_sprung(K, rigid, self.joints)
        return TendonStiffness(K, laid.arms, self.cables(laid, way)).driven(self.drives, self.limits)

    def cables(self, laid: Laid, way: Callable[[Array], Cables] | None) -> Cables:
        """As a path needs them."""
        rigid, none = np.isinf(np.diagonal(self.passive)), np.zeros(len(self.joints))
        arms, posts = (read_only(np.where(rigid, 0.0, rows)) for rows in (laid.arms, laid.posts))
        own = read_only(np.where(np.isinf(self.passive), 0.0, self.passive))
        return Cables(
            self.names, arms, self.springs, own, none, self.pretension, held(self.drives, self.limits), laid.of,
            laid.grips, posts, laid.shift, way,
        )  # fmt: skip


class TendonStiffness(JointStiffness):
    """K = K_p + Rᵀ k R, and the tendons behind it; arms (t, nv) : R as it was given. drives : motors of tendons, None
    without; bears (t,) : what tendons bear, whatever their motors hold [N]. `cables.limits` are the smaller of both.
    """

    drives: Drives | None = None

    def __init__(self, matrix: Array, arms: Array, cables: Cables) -> None:
        super().__init__(matrix)
        self.arms, self.cables, self.bears = arms, cables, cables.limits

    def driven(self, drives: Drives | None, bears: Array) -> TendonStiffness:
        """The same with these motors, of tendons that bear so much, (t,) [N]."""
        made = copy(self)
        made.drives, made.bears, made.cables = drives, bears, self.cables._replace(limits=held(drives, bears))
        return made

    @property
    def names(self) -> tuple[str, ...]:
        """(t,) of the tendons."""
        return self.cables.names

    def motored(self, motors: Mapping[str, Any]) -> TendonStiffness:
        """The same with motors by tendon. Raises InputError, UnknownName."""
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
        return self.tensions(tension)

    def tensions(self, values: Array) -> Effort:
        """With which tendons pull, (t,) [N]."""
        return Effort(TENSION, "N", self.cables.names, read_only(values))

    def pulled(self, torque: Array, command: Array) -> Array:
        """Rᵀ t."""
        return np.asarray(self.arms.T @ self.effort(torque, command).values)

    def beyond(self, command: Array) -> Array:
        """Tendons that pull make torques Rᵀ (t - T₀), none of them below 0; what else K δq_c asks for, springs at the
        joints would have to be commanded to, or tendons would have to push.
        """
        free = np.asarray(self.root.any(axis=1))
        asked = np.where(free, np.where(np.isinf(self.matrix), 0.0, self.matrix) @ command, 0.0)
        left = self.cables.not_made(asked)
        return np.where(abs(left) > _MADE * abs(asked).max(initial=0.0), left, 0.0)

    @property
    def law(self) -> tuple[str, str]:
        """For `explain()`."""
        t, nv = self.arms.shape
        return TENDONS.equation, f"{t} tendon{'s' if t > 1 else ''} over {nv} joints"


class RoutedStiffness(TendonStiffness):
    """Of tendons that run along routes, in one posture."""

    _made: _Made
    _bound: dict[int, BoundRoute]
    _on: Any
    _q: Array

    @classmethod
    def of(cls, made: _Made, kinematics: Any, q: Array, bound: dict[int, BoundRoute] | None = None) -> RoutedStiffness:
        """On the links of a hand, at q (nv,). Raises InputError, UnknownName."""
        bound = made.lays.bound(kinematics, made.names) if bound is None else bound

        def way(q: Array) -> Cables:
            return made.cables(made.lays.at(bound, q), None)

        plain = made.at(bound, q, way)
        found = cls(plain.matrix, plain.arms, plain.cables)
        found.drives, found.bears = plain.drives, plain.bears
        found._made, found._bound, found._on, found._q = made, bound, kinematics, q
        return found

    @property
    def routes(self) -> dict[str, Route]:
        """Of the tendons that have one, by name."""
        return {self._made.names[i]: route for i, route in self._made.lays.routes.items()}

    def motored(self, motors: Mapping[str, Any]) -> RoutedStiffness:
        """The same with motors by tendon. Raises InputError, UnknownName."""
        drives = read_tendon_motors(motors, self.names, self.cables.pretension)
        return self.of(replace(self._made, drives=drives), self._on, self._q)

    def at(self, kinematics: Any, q: Array) -> RoutedStiffness:
        """In another posture, of a hand with these kinematics."""
        return self.of(self._made, kinematics, q, self._bound if kinematics is self._on else None)


def held(drives: Drives | None, bears: Array) -> Array:
    """(t,) what tendons that bear so much (t,) hold for good with these motors [N]."""
    return bears if drives is None else read_only(np.minimum(bears, drives.holds(bears)))


def _given_arms(value: Any) -> Any:
    """Checked, with routes as they are. Raises InputError."""
    if not isinstance(value, Mapping):
        return given_rows(_ARMS, value)
    plain = {str(name): row for name, row in value.items() if not isinstance(row, Route)}
    checked: Any = given_rows(_ARMS, plain) if plain or not value else {}
    return {str(name): row if isinstance(row, Route) else checked[str(name)] for name, row in value.items()}


def _by_tendon(argument: str, value: Any, names: Sequence[str], read: Callable[[str, Any], float], out: float) -> Array:
    """(t,) numbers from one for all, (t,), or a mapping, `out` for tendons that it leaves out."""
    if isinstance(value, Mapping):
        values = per_name(argument, value, names, "a tendon")
        return read_only(np.array([read(f"{argument}[{n!r}]", values[n]) if n in values else out for n in names]))
    if dimensions(value) == 0:
        return read_only(np.full(len(names), read(argument, value)))
    if len(value) != len(names):
        raise InputError(argument, f"{len(names)} numbers, one for each tendon", f"{len(value)} of them")
    return read_only(np.array([read(f"{argument}[{i}]", x) for i, x in enumerate(value)]))


def _passive(argument: str, value: Any, joints: Sequence[str]) -> Array:
    """(nv, nv) K_p, with inf on the diagonal of a rigid joint."""
    if isinstance(value, Mapping):
        values = per_name(argument, value, joints, "a joint")
        return np.diag([_passive_spring(f"{argument}[{j!r}]", values.get(j, 0.0)) for j in joints])
    diagonal = springs(argument, value, joints, _passive_spring)
    if diagonal is not None:
        return diagonal
    n = len(joints)
    return psd(argument, array(argument, value, (n, n), what="N·m/rad, finite, one row for each joint,"))


def _check_sprung(K: Array, rigid: Bools, joints: Sequence[str]) -> None:
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
