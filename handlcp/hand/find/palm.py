"""An object laid against the palm of an open hand, in many ways, and the hand closed round it roughly.

Of each finger the joints that bend are at their open end; those that spread or oppose it are anywhere in their ranges.
In half of the hands those that only spread fingers side by side stay near rest: at random such fingers cross.
In every other hand only the first bending joint of each finger closes, and those beyond it are bent beforehand: fingers
that all curl up meet each other round a small object.
The object comes from where the fingers bend to, straight towards the palm, until it touches something. A long object
lies along the axes about which fingers bend, so that they can go round it. Then the hand closes as `hand/closing.py`
closes it, with points in place of surfaces. What encloses the object best is closed exactly later.

enclosure = min over directions d of  max over links that touch of  μ |d - (d·n) n| - d·n,
            and more for what touches the palm, too

n the normal of a link into the object, d a way in which the object may leave. It is positive where some link stands in
every way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice

import numpy as np
import scipy

from handlcp.check import Array, Bools
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.geometry.distance import bounding_box, spread_directions
from handlcp.geometry.link_contacts import ContactBody, body_frames
from handlcp.geometry.object import Object
from handlcp.hand.closing import bending_rates
from handlcp.hand.find.clear import Place, free_ranges
from handlcp.hand.find.skin import Skin, rough_distances
from handlcp.robot.hand_model import HandModel, HandPosture

LAID = 1024  # placements that are compared
CLOSED = 224  # of them, those that lie nearest to the palm, round which the hand closes
_TILT, _TURN = 0.3, 0.35  # [rad] of the way to the palm, and of the object about it, at most
_SHARES = 0.1 * np.arange(7)  # of their ranges, as far as fingers close where the ways they move are looked for
_AGREE = 8  # power of the cosines of axes
_PLAIN = 0.35  # of fingers that bend to one side: the mean of the unit vectors along which their tips move
_BENT = 0.6  # of its range, how far a joint is bent beforehand, at most
_SPREAD = 0.4  # of the way to the ends of their ranges, how far fingers side by side spread that stay near rest
_SIDE_BY_SIDE = 0.9  # cosine of the axes of two such fingers
_ASIDE = 0.25  # of the hand's size, how far beside the middle the object comes
_STEPS, _NEAR = 40, 2e-4  # towards the palm; [m] what is left before it
_TOUCHES = 3e-3  # [m] as far as points tell
_CLOSING, _QUICKEST = 40, 0.02  # steps of closing, and the shortest, in radians
_SETTLING, _EXACT, _AWAY, _STEEP = 12, 1e-6, 5e-3, 0.05  # steps to just touching, [m] there, [m] at first; n · way
_PALM = 0.1  # more for what touches the palm, too
_WAYS = spread_directions(40)  # in which the object may leave


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """place : the open hand, and the object, which came against `way` (3,). closing (nv,) : the joints that close.
    closed (nv,) : roughly where the hand has closed. score : see above.
    """

    place: Place
    way: Array
    closing: Bools
    closed: Array
    score: float


def laid(hand: HandModel, obj: Object, friction: float, seed: int, clear: Callable[[Array], bool]) -> list[Laid]:
    """Placements, those that the hand encloses best first; alike for a seed. friction : a coefficient, roughly.
    clear : whether links keep out of each other in a posture (nv,); those of open hands do.
    """
    skin, home = Skin(hand), obj.moved_to(np.zeros(3))
    lower, upper = free_ranges(hand)
    draws = scipy.stats.qmc.Sobol(hand.nv + 11, rng=seed).random(LAID)
    middle = _Middle(hand, skin, home)
    u, spread, calm = draws[:, :10], draws[:, 10:-1], draws[:, -1:]
    anywhere = lower + spread * (upper - lower)
    near = middle.rest + _SPREAD * 2.0 * calm * (anywhere - middle.rest)
    qs = np.where(middle.beside & (calm < 0.5), near, anywhere)
    qs = np.where(middle.speed != 0.0, middle.opened, qs)
    bent = (u[:, 8:9] < 0.5) & (middle.speed != 0.0) & ~middle.first
    qs = np.where(bent, middle.opened + _BENT * 2.0 * u[:, 8:9] * (middle.shut - middle.opened), qs)
    qs = np.where(hand.moving_joints.all(axis=0), middle.rest, qs)  # a wrist
    rotations, ways, aims = middle.drawn(u, home)
    centre = 0.5 * np.sum(bounding_box(home.geometry), axis=0)
    reach = float(np.linalg.norm(np.ptp(bounding_box(home.geometry), axis=0)))
    starts = aims + ways * (reach + middle.size)
    positions = starts - rotations @ centre
    positions, resting = _come(skin, qs, home, (rotations, positions, ways), reach + middle.size)
    nearest_first = (k for k in np.argsort(resting, kind="stable").tolist() if np.isfinite(resting[k]))
    order = np.array(list(islice((k for k in nearest_first if clear(qs[k])), CLOSED)), dtype=int)
    places = [Place(qs[k], rotations[k], positions[k]) for k in order]
    closed = _closed(hand, skin, home, places, ~bent[order], friction)
    found = [Laid(*one) for one in zip(places, ways[order], ~bent[order], *closed, strict=True)]
    return sorted(found, key=lambda one: -one.score)


def settled(hand: HandModel, among: Iterable[ContactBody], obj: Object, one: Laid) -> Place | None:
    """The place where the object just touches the open hand, as exactly as distances are known, along its way; None:
    none is near.
    """
    place, among = one.place, list(among)
    for _ in range(_SETTLING):
        target, least = place.of(obj), np.inf
        for link, R, p in body_frames(HandPosture(hand, place.q), among):
            near = nearest_proximity(link.shapes, p, R, target)
            slope = float(near.normal @ one.way)
            if slope > _STEEP:
                least = min(least, near.gap / slope)
            elif near.gap < -_EXACT:
                return None  # beside it, where moving out does not help
        if not abs(least) < _AWAY:
            return None
        if abs(least) <= _EXACT:
            return place
        place = place.moved(np.zeros(hand.nv), np.append(-least * one.way, np.zeros(3)))
    return place if least > 0.0 else None


class _Middle:
    """Where a hand closes to. speed (nv,) of joints that bend, opened, shut (nv,) their ends. first (nv,) : whether a
    joint is the first of a finger that bends. beside (nv,) : whether it moves only fingers that have others at their
    side, which bend about the same axis. n (3,), other (3,) : ways out of the palm, across (3,) : along which most
    fingers bend. palm (3,), closes (3,) : middle of the palm, and of where fingertips go. size [m] : from one to the
    other, and more.
    """

    def __init__(self, hand: HandModel, skin: Skin, home: Object) -> None:
        self.rest = np.clip(hand.neutral, *free_ranges(hand))
        lower, upper = free_ranges(hand)
        half = np.where(hand.moving_joints.all(axis=0), self.rest, 0.5 * (lower + upper))
        at_rest = HandPosture(hand, self.rest)
        between = at_rest.tip_positions.mean(axis=0)
        self.speed = bending_rates(hand, self.rest, home.moved_to(between - home.center_of_mass))
        low, high = (
            np.where(np.isfinite(hand.lower), hand.lower, lower),
            np.where(np.isfinite(hand.upper), hand.upper, upper),
        )
        self.opened = np.where(self.speed > 0.0, low, high)
        self.shut = np.where(self.speed > 0.0, high, low)
        self.first = np.zeros(hand.nv, dtype=bool)
        for moved_by in hand.moving_joints & (self.speed != 0.0):
            self.first[np.flatnonzero(moved_by)[:1]] = True
        start = np.where(self.speed != 0.0, self.opened, half)
        end = np.where(self.speed != 0.0, self.shut, half)
        closing = [HandPosture(hand, start + share * (end - start)) for share in _SHARES]
        on_way = [closing[k].tip_positions for k in (0, 3, 6)]
        palm = skin.palm[skin.of]
        self.palm = (skin.at(start[None])[0][palm] if palm.any() else on_way[0]).mean(axis=0)
        self.closes = np.mean(on_way, axis=(0, 1))
        # Straight fingers point along the palm and move away from it; bent back, they move along it.
        away = [np.linalg.norm(one.tip_positions - self.palm, axis=1) for one in closing]
        moved = np.array([(one.jacobian @ self.speed).reshape(-1, 3) for one in closing])
        moved = moved[np.argmax(away, axis=0), np.arange(moved.shape[1])]
        moved /= np.maximum(np.linalg.norm(moved, axis=1), 1e-12)[:, None]
        out, plain = moved.mean(axis=0), float(np.linalg.norm(moved.mean(axis=0)))
        straight = self.closes - self.palm
        ways = [out / max(plain, 1e-12), straight / max(float(np.linalg.norm(straight)), 1e-12)]
        self.n, self.other = ways if plain >= _PLAIN else ways[::-1]
        axes = at_rest.angular_jacobian(hand.tips.numbers) @ self.speed
        axes /= np.maximum(np.linalg.norm(axes, axis=1), 1e-12)[:, None]
        alike = axes @ axes.T
        shared = (alike**_AGREE).sum(axis=1)  # what most fingers bend about counts, a thumb hardly
        self.across = np.linalg.eigh((axes.T * shared) @ axes)[1][:, -1]
        np.fill_diagonal(alike, 0.0)
        self.beside = ~(hand.moving_joints & (alike.max(axis=1) < _SIDE_BY_SIDE)[:, None]).any(axis=0)
        self.size = float(np.linalg.norm(on_way[0] - self.palm, axis=1).max())

    def drawn(self, u: Array, home: Object) -> tuple[Array, Array, Array]:
        """Rotations (k, 3, 3) of the object, ways (k, 3) out of the palm on which it comes, and points (k, 3) on them,
        as draws (k, 10) in [0, 1) say.
        """
        out = self.n + u[:, :1] * (self.other - self.n)
        out /= np.maximum(np.linalg.norm(out, axis=1), 1e-12)[:, None]
        tilts = scipy.spatial.transform.Rotation.from_rotvec(_TILT * (2.0 * u[:, 1:4] - 1.0)).as_matrix()
        ways = np.einsum("kxy,ky->kx", tilts, out)
        along = self.across - ways * (ways @ self.across)[:, None]
        along /= np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None]
        turn = _TURN * (2.0 * u[:, 4] - 1.0)
        aside = np.cross(ways, along)
        x = np.cos(turn)[:, None] * along + np.sin(turn)[:, None] * aside
        hand_axes = np.stack([x, np.cross(ways, x), ways], axis=2)
        low, high = bounding_box(home.geometry)
        longest, shortest = np.argsort(-(high - low), kind="stable")[[0, 2]]
        # The longest edge along the axes of bending. Every other placement lies on the widest side, the rest on edge.
        sides = [_axes_with(int(longest), int(shortest)), _axes_with(int(longest), 3 - int(longest) - int(shortest))]
        upright = _axes_with(3 - int(longest) - int(shortest), int(longest))
        chosen = np.where(
            (u[:, 5] < 0.4)[:, None, None], sides[0], np.where((u[:, 5] < 0.8)[:, None, None], sides[1], upright)
        )
        turned = np.floor(4.0 * u[:, 9])  # end for end, and upside down: all the same of a box
        one, two = 1.0 - 2.0 * (turned % 2.0), 1.0 - 2.0 * (turned // 2.0)
        chosen = chosen * np.stack([one, one * two, two], axis=1)[:, None, :]
        share, beside = u[:, 6:7], _ASIDE * self.size * (2.0 * u[:, 7:8] - 1.0)
        aims = self.palm + share * (self.closes - self.palm) + beside * along
        return hand_axes @ chosen.transpose(0, 2, 1), ways, aims


def _axes_with(first: int, last: int) -> Array:
    """(3, 3) whose columns are an object's axes: those numbered so come to lie first and last, right-handed."""
    out = np.eye(3)[:, [first, 3 - first - last, last]]
    out[:, 1] *= np.linalg.det(out)
    return out


def _come(
    skin: Skin, qs: Array, home: Object, begun: tuple[Array, Array, Array], far: float
) -> tuple[Array, Array]:  # fmt: skip
    """Positions (k, 3) at which the object touches, and how far the palm is from it there (k,) [m], inf where it begins
    inside or touches nothing. begun : rotations, positions, and the ways out along which it comes back.
    """
    rotations, positions, ways = begun
    measure, points, positions = rough_distances(home), skin.at(qs), positions.copy()
    gone, alive = np.zeros(len(qs)), np.ones(len(qs), dtype=bool)
    for _ in range(_STEPS):
        local = (points[alive] - positions[alive, None]) @ rotations[alive]
        step = measure(local).min(axis=1)
        gone[alive] += np.maximum(step, 0.0)
        positions[alive] -= ways[alive] * np.maximum(step, 0.0)[:, None]
        alive[alive] = (step > _NEAR) & (gone[alive] < 2.0 * far)
        if not alive.any():
            break
    local = (points - positions[:, None]) @ rotations
    gaps = skin.least(measure(local))
    palm = gaps[:, skin.palm].min(axis=1, initial=np.inf) if skin.palm.any() else gaps.min(axis=1)
    return positions, np.where((gaps.min(axis=1) < -_NEAR) | (gone >= 2.0 * far), np.inf, np.maximum(palm, 0.0))


def _closed(
    hand: HandModel, skin: Skin, home: Object, places: list[Place], closing: Bools, friction: float
) -> tuple[Array, list[float]]:
    """Where the hand has closed (k, nv), and the scores. closing (k, nv) : the joints that may turn."""
    if not places:
        return np.zeros((0, hand.nv)), []
    qs, speed = np.array([p.q for p in places]), np.array([bending_rates(hand, p.q, p.of(home)) for p in places])
    speed = np.where(closing, speed, 0.0)
    R, o = np.array([p.rotation for p in places]), np.array([p.position for p in places])
    measure = rough_distances(home)
    for step in range(_CLOSING):
        gaps = skin.least(measure((skin.at(qs) - o[:, None]) @ R))
        if step:  # what touches from the beginning, as the palm does, stops nothing that leaves it
            touching = (gaps <= 0.5 * _TOUCHES) & _carried(skin, speed)
            speed[(touching[:, :, None] & skin.moves).any(axis=1)] = 0.0
        ends = np.where(speed > 0.0, hand.upper - qs, qs - hand.lower)
        speed[(speed != 0.0) & (ends <= 1e-9)] = 0.0
        moving = _carried(skin, speed)
        if not moving.any():
            break
        least = np.where(moving, np.maximum(gaps, 0.0), np.inf).min(axis=1)
        step_by = np.clip(least / 0.15, _QUICKEST, 0.3)[:, None]  # 0.15 m: the lever of a long finger
        qs = qs + np.sign(speed) * np.minimum(abs(speed) * step_by, np.maximum(ends, 0.0))
    points = (skin.at(qs) - o[:, None]) @ R
    gaps = measure(points)
    scores = [_enclosure(skin, *one, measure, friction) for one in zip(points, gaps, strict=True)]
    on_palm = skin.least(gaps)[:, skin.palm].min(axis=1, initial=np.inf) <= _TOUCHES
    return qs, [score + _PALM * on for score, on in zip(scores, on_palm.tolist(), strict=True)]


def _carried(skin: Skin, speed: Array) -> Bools:
    """(k, links) whether a joint that turns moves a link."""
    return np.asarray((speed != 0.0).astype(float) @ skin.moves.T.astype(float) > 0.0)


_SMALL = 1e-4  # [m] of differences


def _enclosure(skin: Skin, points: Array, gaps: Array, measure: Callable[[Array], Array], friction: float) -> float:
    """See the top; the number of links that touch beside it, which decides among alike ones. points (m, 3) and gaps
    (m,) in the object's frame.
    """
    nearest = np.array(
        [s + int(np.argmin(part)) for s, part in zip(skin.starts, np.split(gaps, skin.starts[1:]), strict=True)]
    )
    touching = nearest[gaps[nearest] <= _TOUCHES]
    if len(touching) < 2:
        return -1.0
    x = points[touching]
    shifts = _SMALL * np.concatenate([np.eye(3), -np.eye(3)])
    values = measure(x[:, None] + shifts)
    out = values[:, :3] - values[:, 3:]
    out /= np.maximum(np.linalg.norm(out, axis=1), 1e-12)[:, None]
    against = _WAYS @ out.T  # d · outward normal: the link stands in the way where it is positive
    resists = against + friction * np.sqrt(np.maximum(1.0 - against**2, 0.0))
    return float(resists.max(axis=1).min()) + 0.02 * min(len(touching), 12)
