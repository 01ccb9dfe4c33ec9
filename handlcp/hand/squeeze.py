"""How far a hand is squeezed: from overlaps to joint offsets, and what of it the joints cannot make."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, dimensions, number, per_name, read_only
from handlcp.errors import InputError, URDFError
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.effects.joint_offset import TOUCHING, Reach, command_of, joints_commanded, recommanded
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.objects.inside import links_inside
from handlcp.words import all_of, length

# ----------------------------------------------------------------
# What is asked of fingertips and no command of the joints makes, and a squeeze that goes on from an earlier one.


def motions_of(mechanism: Any, planar: bool, commands: Array | None = None) -> TipMotions:
    """What the actuators of a `HandMechanism` do to the fingers' contacts; or others, with these commands."""
    commands = mechanism.posture.hand.stiffness.commands if commands is None else commands
    return TipMotions.of(mechanism.fingertips, mechanism.jacobian, commands, planar)


def joint_by_joint(mechanism: Any, planar: bool) -> TipMotions:
    """As if every joint had an actuator of its own."""
    return motions_of(mechanism, planar, np.eye(len(mechanism.names)))


def out_of_reach(spec: GraspSpec) -> tuple[Reach, ...]:
    """What no command of the joints makes, of the overlap in the posture, of a preload, and of what is commanded; links
    that the object begins inside are not asked to make it.
    """
    mechanism: Any = spec.mechanism  # a hand's
    k = spec.of_hand
    tips, found = motions_of(mechanism, spec.planar), []
    inside = overlaps(mechanism.stand_off[:, 2])
    if (inside := np.where(begun_inside(spec) > 0.0, 0.0, inside)).any():
        found.append(joint_by_joint(mechanism, spec.planar).overlapping(inside))
    given = mechanism.stand_off - spec.offset[:k]
    given[given[:, 2] < 0.0] = 0.0  # a gap, which nothing has to make
    if abs(given).max(initial=0.0) > TOUCHING:
        found.append(tips.preloaded(given))
    if (command := command_of(spec.effects)) is not None and command.reach is not None:
        found.append(command.reach)
    return tuple([reach for reach in found if not reach.complete])


def reach_reasons(spec: GraspSpec) -> Iterator[Reason]:
    """A warning for each kind of squeeze of which a part is out of reach."""
    for reach in out_of_reach(spec):
        values = {
            "what": reach.what, "unit": reach.unit, "fingers": reach.names, "asked": reach.asked.tolist(),
            "missing": reach.missing.tolist(), "share": reach.share.tolist(),
        }  # fmt: skip
        yield Reason("out_of_reach", "warning", str(reach), values)


def begun_inside(spec: GraspSpec) -> Array:
    """(k,) how far the object begins inside the hand's links, before these close [m], at each contact; 0 where it does
    not. Fingertips that touch alone, and links that joints could have closed so far in this posture, are squeezed.
    """
    mechanism: Any = spec.mechanism  # a hand's
    inside = overlaps(mechanism.stand_off[:, 2])
    if not mechanism.links or not inside.any():
        return np.zeros(len(inside))
    command = command_of(spec.effects)
    opened = command is not None and command.opened is not None  # from where links close until they touch
    still = joint_by_joint(mechanism, spec.planar).overlapping(inside).share > _STILL
    return np.where(still | (opened & (inside > _CLOSED)), inside, 0.0)


def links_begun(spec: GraspSpec) -> dict[str, float]:
    """The links that the object begins inside, the deepest first, and how deep [m]: the whole link, where its contacts
    are less deep.
    """
    mechanism: Any = spec.mechanism
    depths = dict[str, float]()
    for tip, depth in zip(mechanism.fingertips, begun_inside(spec).tolist(), strict=True):
        if depth > 0.0:
            link = mechanism.links[tip]
            depths[link] = max(depth, depths.get(link, 0.0))
    if depths:
        with suppress(URDFError):
            for one in links_inside(mechanism.posture, mechanism.target, ()):
                if one.link in depths:
                    depths[one.link] = max(one.depth, depths[one.link])
    return dict(sorted(depths.items(), key=lambda one: -one[1]))


def begins_reasons(spec: GraspSpec) -> Iterator[Reason]:
    """A warning where the object begins inside links: how deep in which."""
    if depths := links_begun(spec):
        where = all_of([f"{length(depth)} inside {link}" for link, depth in depths.items()])
        links = [{"link": link, "depth_m": depth} for link, depth in depths.items()]
        yield Reason("link_inside", "warning", f"the object begins {where}: move it out by as much", {"links": links})


def moved_out(spec: GraspSpec) -> tuple[str, float, GraspSpec] | None:
    """The words for the object moved out of the link that it begins deepest inside, along the normals there, by how
    much [m], and the grasp that the hand then closes to. None where it begins in none, lies on something, or the
    normals of that link face each other.
    """
    mechanism: Any = spec.mechanism
    begun, moved = links_begun(spec), getattr(spec.asked, "moved", None)
    if not begun or moved is None or spec.of_hand < spec.n:
        return None
    link, depth = next(iter(begun.items()))
    its = [mechanism.links[tip] == link for tip in mechanism.fingertips]
    way = mechanism.frames[its, :, 2].sum(axis=0)
    if (size := float(np.linalg.norm(way))) < _OPPOSED * sum(its):
        return None
    try:
        return f"the object {length(depth)} farther out of {link}", depth, moved((depth + TOUCHING) / size * way)
    except InputError:
        return None


def squeezed_further(spec: GraspSpec, depth: float) -> GraspSpec:
    """The grasp with joints commanded on, so that every tip whose force is not prescribed goes deeper by depth [m]."""
    free = set(spec.free_fingers)
    more = np.array([depth if i in free else 0.0 for i in range(spec.of_hand)])
    return _with_command(spec, _command(spec) + motions_of(spec.mechanism, spec.planar).deeper(more))


def eased(spec: GraspSpec, share: float) -> GraspSpec:
    """The grasp with this share of its squeeze, commands of the joints included."""
    offset, k = spec.offset.copy(), spec.of_hand
    offset[:k] *= np.where(offset[:k, 2:] < 0.0, share, 1.0)
    return _with_command(spec.replace(offset=read_only(offset)), share * _command(spec))


def _command(spec: GraspSpec) -> Array:
    """(nv,) how far the joints are commanded beyond the posture."""
    mechanism: Any = spec.mechanism
    return joints_commanded(spec.effects, len(mechanism.names))


def _with_command(spec: GraspSpec, command: Array) -> GraspSpec:
    return spec.replace(effects=recommanded(spec.effects, command))


# ----------------------------------------------------------------
# How hard a hand closes: the joint offset δq that its actuators can command, from a depth or a force at each tip.
#
# squeeze       n·J δq = s + gap            the smallest δq
# grip force    J δq = E r + d,  r_N = f    the r nearest to f n that joints can make: without pads δq = K⁻¹ Jᵀ n f
#
# A squeeze is the motion with which `close_on` closes, continued: the tips go deeper by s along the normals, and
# sideways as their joints take them. The tip of a two-joint finger moves in a plane. Where the normal leans out of that
# plane by θ, depth and normal force are reached all the same, with s tan θ or f tan θ sideways in the plane. d are the
# offsets that the fingers stand off by: a gap that is left, and the sag under their own weight.

RANK = 1e-2  # directions in which the joints move the tips less than this share of their best are out of reach
_DEEP = 0.1  # [m] no hand squeezes deeper: what is more was not given in metres
_OPPOSED = 0.5  # of their number: normals whose sum is shorter say no way out
_STILL = 0.5  # of an overlap: where joints miss more of it than that, they are not what made it
_CLOSED = 2e-4  # [m] links that close until they touch overlap by less


def by_tip(argument: str, value: Any, names: Sequence[str]) -> Array:
    """(k,) ≥ 0 from a number, (k,), or a mapping by fingertip (others: 0). Raises InputError, UnknownName."""
    if isinstance(value, Mapping):
        given = per_name(argument, value, names, "a fingertip")
        values = np.array([number(f"{argument}[{name!r}]", given.get(name, 0.0), minimum=0.0) for name in names])
    elif dimensions(value) == 0:
        values = np.full(len(names), number(argument, value, minimum=0.0))
    else:
        values = array(argument, value, (len(names),))
        if (values < 0.0).any():
            raise InputError(argument, "numbers ≥ 0", values.tolist())
    if argument == "squeeze" and (deepest := float(values.max(initial=0.0))) > _DEEP:
        raise InputError(argument, f"depths in metres, up to {_DEEP:g}", f"{deepest:g}: are these millimetres?")
    return read_only(values)


def overlaps(gaps: Array) -> Array:
    """(k,) how far fingertips with these gaps (k,) are inside the object [m]; 0 for those that just touch."""
    return read_only(np.where(gaps < -TOUCHING, -gaps, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class TipMotions:
    """What commands of the actuators do to k fingertips. names : (k,). jacobian : (3k, nv) of the contact points,
    contact axes [m/rad]. commands : (nv, m) joint motions that can be commanded, in orthonormal columns.
    """

    names: tuple[str, ...]
    jacobian: Array
    commands: Array

    @classmethod
    def of(cls, names: tuple[str, ...], jacobian: Array, commands: Array, planar: bool = False) -> TipMotions:
        """Contacts after the fingers' are left out, and so are motions across the plane of a planar scene."""
        J = jacobian[: 3 * len(names)]
        if planar:
            J = J.copy()
            J[1::3] = 0.0
        return cls(names, J, commands)

    def deeper(self, depth: Array) -> Array:
        """(nv,) the smallest δq that takes the tips deeper by depth (k,) along the normals, or nearest to that; for
        columns (k, m), columns.
        """
        moves = self.jacobian @ self.commands
        return np.asarray(self.commands @ _least(moves[2::3], depth, _slowest(moves)))

    def made(self, command: Array) -> Array:
        """(k, 3) J δq."""
        return np.asarray(self.jacobian @ command).reshape(-1, 3)

    def follow(self, motions: Array) -> Array:
        """(nv,) the smallest δq with J δq = motion (3k,), or nearest to it; for columns (3k, m), columns."""
        moves = self.jacobian @ self.commands
        return np.asarray(self.commands @ _least(moves, motions, _slowest(moves)))

    def beyond(self, motions: Array) -> Array:
        """The part of motions (3k,), or of each column (3k, m), that no command makes."""
        return np.asarray(motions - self.jacobian @ self.follow(motions))

    def preloaded(self, motion: Array) -> Reach:
        """Of a motion (k, 3) of the tips that was given, not commanded."""
        beyond = self.beyond(motion.reshape(-1)).reshape(-1, 3)
        size, left = np.sqrt((motion * motion).sum(axis=1)), np.sqrt((beyond * beyond).sum(axis=1))
        return Reach("preload", self.names, read_only(size), read_only(left), read_only(np.zeros(len(size))), True)

    def overlapping(self, inside: Array) -> Reach:
        """Of tips that overlap the object by (k,) [m] in the posture."""
        left = abs(inside - self.made(self.deeper(inside))[:, 2])
        return Reach("overlap", self.names, inside, read_only(left), read_only(np.zeros(len(left))), True)


def squeezing(tips: TipMotions, depth: Array, gaps: Array) -> tuple[Array, Reach]:
    """δq (nv,) that leaves the tips depth (k,) deep where they stand off by gaps (k,), both [m]; and its reach."""
    wanted = depth + gaps
    command, from_touching = tips.deeper(np.column_stack([wanted, depth])).T
    missing = abs(wanted - tips.made(command)[:, 2])
    whole = tips.made(from_touching)
    sideways = np.sqrt(whole[:, 0] ** 2 + whole[:, 1] ** 2)
    return command, Reach("squeeze", tips.names, depth, read_only(missing), read_only(sideways), False)


class RigidFinger(InputError):
    """A finger that is asked for a force in a posture in which nothing lets it give way along its normal."""


def gripping(tips: TipMotions, force: Array, flexibility: Array, root: Array, stand_off: Array) -> tuple[Array, Reach]:
    """δq (nv,) with which the tips press with normal forces (k,) [N] on an object that stays where it is and does not
    slip; and its reach. flexibility : (3k, 3k) E of the fingers. root : A of the joints' compliance K⁻¹ = A Aᵀ.
    stand_off : (3k,) d. Raises RigidFinger.
    """
    E, size = flexibility, float(abs(flexibility).max(initial=0.0))
    for name, asked, give in zip(tips.names, force, np.diagonal(E)[2::3], strict=True):
        if asked > 0.0 and give <= 1e-12 * size:
            expected = "a finger that gives way along its normal, through its joints or its pad"
            raise RigidFinger("grip_force", expected, f"{name}, which is rigid there")
    pressed = np.outer(force, (0.0, 0.0, 1.0)).reshape(-1)
    # Friction takes up what E asks for beyond the joints' motions
    along = np.ones(len(E), dtype=bool)
    along[2::3] = False
    beyond = tips.beyond(E)
    bound = RANK * float(np.linalg.norm(beyond, 2))
    r = pressed.copy()
    if bound > 1e-12 * size:
        r[along] = -_least(beyond[:, along], beyond @ pressed, bound)
    wanted = E @ r + stand_off
    command = tips.commands @ (tips.commands.T @ (root @ (root.T @ (tips.jacobian.T @ r))))
    command = command + tips.follow(wanted - tips.jacobian @ command)
    left = tips.jacobian @ command - wanted
    reached = (r + np.linalg.pinv(E, rcond=1e-9, hermitian=True) @ left).reshape(-1, 3)
    sideways = np.sqrt(reached[:, 0] ** 2 + reached[:, 1] ** 2)
    missing = abs(force - reached[:, 2])
    return command, Reach("grip force", tips.names, force, read_only(missing), read_only(sideways), False)


def _slowest(moves: Array) -> float:
    """The least speed of a tip that counts as within reach, where commands of length one move the tips by `moves`."""
    return RANK * float(np.sqrt((moves * moves).sum(axis=1).max(initial=0.0)))


def _least(A: Array, b: Array, bound: float) -> Array:
    """The smallest x that makes A x nearest to b, without directions whose singular value is at most `bound`."""
    U, s, V = np.linalg.svd(A, full_matrices=False)
    kept = s > bound
    inverse = V[kept].T / s[kept]
    return np.asarray(inverse @ (U[:, kept].T @ b))
