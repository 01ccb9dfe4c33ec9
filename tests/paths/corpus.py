"""Random grasps with directions of load: each follows from a seed and its number alone.

Two of three that hold are hands on boxes, balls, cylinders and ellipsoids, asked with the geometry followed; the third
one is three to six bare contacts with coupled springs, asked in one posture. Coulomb, soft and anisotropic friction,
the cone and six faces. `held` says whether a grasp holds its squeeze and weight.

`grasp_of` mixes in power grasps: six to thirty bare contacts that sixteen joints couple, and hands whose links close on
an object by torque, shipped and commercial ones.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import handlcp as hl
from tests.mujoco.case import read_rows
from tests.mujoco.find_power_grasps import FILE as POWER_GRASPS
from tests.paths.hands import COMMERCIAL, SHIPPED, STARTS, TIPS, commercial_hands_there
from tests.paths.recipes import FreeRecipe, HandRecipe, Law, Recipe, Thing, WrapRecipe, turn
from tests.support.power import power_grasp

DIRECTIONS = 12
ACCEPTED = Path(__file__).with_name("accepted.json")  # {"tried": below this, "0": numbers of the seed 0 that hold}
_LAWS = ("coulomb", "soft", "anisotropic")
_HANDS = ("three_finger", "five_finger", "three_finger", "five_finger", "allegro", "barrett", "leap")
_UP = np.array([0.0, 0.0, -9.81])
MIXED = ("case_of", "case_of", "power_case", "wrap_case")  # where the grasps of `grasp_of` come from, in turns


@dataclass(frozen=True)
class Case:
    """A grasp by its recipe, and how it is asked. directions (12, 6) [N, N·m], of unit size: eight forces, two forces
    with moments, two moments [per 30 mm]. source : the function of this file that makes it of a seed and a number.
    """

    seed: int
    number: int
    recipe: Recipe
    geometry: str
    faces: int | str
    directions: np.ndarray
    source: str = "case_of"

    @cached_property
    def grasp(self) -> Any:
        """Made once. Raises NotReached for a hand that does not reach its object."""
        return self.recipe.grasp()

    @property
    def name(self) -> str:
        """Such as "0/17 five_finger, ball, soft, cone"."""
        r = self.recipe
        if isinstance(r, FreeRecipe):
            what = f"{len(r.p)} contacts, {r.laws[0].kind}"
        elif isinstance(r, WrapRecipe):
            what = f"{r.key}, all links, {r.law.kind}"
        else:
            what = f"{r.hand}, {r.thing.kind}, {r.law.kind}"
        return f"{self.seed}/{self.number} {what}, {self.faces}"

    @property
    def rebuilt(self) -> str:
        """The call that makes it again, such as "power_case(0, 3)"; its geometry where that is another one."""
        own = "fixed" if isinstance(self.recipe, FreeRecipe) else "followed"
        return f"{self.source}({self.seed}, {self.number})" + (".in_posture()" if self.geometry != own else "")

    def in_posture(self) -> Case:
        """Asked with the geometry of its posture."""
        return replace(self, geometry="fixed")

    def changed(self, recipe: Recipe) -> Case:
        """With another recipe."""
        return replace(self, recipe=recipe)


@lru_cache(maxsize=512)
def case_of(seed: int, number: int) -> Case:
    """The case of a seed and a number; nothing is tried."""
    rng = np.random.default_rng([seed, number])
    free = number % 6 == 2  # hands are held less often: then a third of all that hold is bare
    law, faces = _LAWS[number // 3 % 3], ("cone", 6)[number // 9 % 2]
    recipe = _bare(rng, law) if free else _hand(rng, law)
    return Case(seed, number, recipe, "fixed" if free else "followed", faces, _directions(rng))


@lru_cache(maxsize=512)
def power_case(seed: int, number: int) -> Case:
    """6 to 30 bare contacts on phalanges and palm, coupled by sixteen joints."""
    rng = np.random.default_rng([seed, number, 1])
    drawn, kind, faces = power_grasp(int(rng.integers(6, 31)), number), _LAWS[number % 3], ("cone", 6)[number // 3 % 2]
    law, contacts = some_law(rng, kind, rng.uniform(0.3, 0.9)), drawn.contacts
    frames = np.array([c.rotation for c in contacts])
    places = np.array([c.position for c in contacts])
    recipe = FreeRecipe(places, frames, (law,) * len(contacts), drawn.flexibility, -drawn.offset)
    return Case(seed, number, recipe, "fixed", faces, _directions(rng), "power_case")


@lru_cache(maxsize=512)
def wrap_case(seed: int, number: int) -> Case:
    """A hand whose links close on an object by torque. Numbers go through the hands in turns."""
    rng, keys = np.random.default_rng([seed, number, 2]), _wraps()
    of_hand = list(keys)[number % len(keys)]
    key = keys[of_hand][int(rng.integers(len(keys[of_hand])))]
    law = some_law(rng, _LAWS[number % 3], rng.uniform(0.4, 1.0))
    recipe = WrapRecipe(key, float(np.exp(rng.uniform(np.log(3.0), np.log(12.0)))), rng.uniform(0.15, 0.4), law)
    return Case(seed, number, recipe, "followed", ("cone", 6)[number // 3 % 2], _directions(rng), "wrap_case")


@cache
def _wraps() -> dict[str, list[str]]:
    """Placements of power grasps by hand, of those hands that are installed."""
    hands: dict[str, list[str]] = {}
    for key, row in read_rows(POWER_GRASPS).items():
        if row["hand"] in (*SHIPPED, "allegro") or commercial_hands_there():
            hands.setdefault(row["hand"], []).append(key)
    return hands


def grasp_of(seed: int, index: int) -> Case:
    """The case of an index: fingertips and bare contacts twice, then a power grasp of bare contacts, then one of a
    hand. Of seed 0 fingertips are those that hold; nothing else is tried.
    """
    turn, of_four = divmod(index, len(MIXED))
    if MIXED[of_four] != "case_of":
        return {"power_case": power_case, "wrap_case": wrap_case}[MIXED[of_four]](seed, turn)
    number = 2 * turn + of_four
    known = accepted()["0"] if seed == 0 else []
    return case_of(seed, known[number] if number < len(known) else number)


def held(case: Case) -> bool:
    """Whether the grasp can be made, reaches the end of its squeeze and weight, and is HELD there."""
    try:
        grasp = case.grasp
        if not grasp.follow(np.zeros(6), geometry=case.geometry, faces=case.faces).held:
            return False
        return isinstance(case.recipe, FreeRecipe) or grasp.check(faces=case.faces).ok
    except hl.HandLCPError:
        return False


def cases(count: int, seed: int = 0, start: int = 0) -> Iterator[Case]:
    """So many cases that hold, in the order of their numbers from `start`. Those of seed 0 that were tried before are
    known, and the same whatever package is imported; others are tried now. Commercial hands are left out where their
    package is not installed.
    """
    known = accepted() if seed == 0 else {"tried": 0, "0": []}
    before = (case_of(seed, number) for number in known["0"] if number >= start)
    numbers = itertools.count(max(start, known["tried"]))
    anew = (case for number in numbers if _there(case := case_of(seed, number)) and held(case))
    yield from itertools.islice(itertools.chain(filter(_there, before), anew), count)


def _there(case: Case) -> bool:
    return getattr(case.recipe, "hand", "") not in COMMERCIAL or commercial_hands_there()


@lru_cache(maxsize=1)
def accepted(path: Path = ACCEPTED) -> dict[str, Any]:
    """How many numbers of the seed 0 were tried, "tried", and those of them that hold, "0"."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"tried": 0, "0": []}


def some_law(rng: np.random.Generator, kind: str, mu: float) -> Law:
    """A law of a kind with a coefficient; the rest is random."""
    second = rng.uniform(0.002, 0.008) if kind == "soft" else rng.uniform(0.5, 0.95)
    along = rng.normal(size=3)
    return Law(kind, mu, second, tuple((along / np.linalg.norm(along)).tolist()))


def _hand(rng: np.random.Generator, law: str) -> HandRecipe:
    name = _HANDS[rng.integers(len(_HANDS))]
    kind = ("box", "ball", "cylinder", "ellipsoid")[rng.integers(4)]
    if (name, kind) not in STARTS:
        kind = "ball"
    start, shipped = STARTS[name, kind], name in SHIPPED
    base = (0.025, 0.035) if shipped else (0.025, 0.030)  # half of the object's width [m]
    r = rng.uniform(*base)
    sizes = {
        "box": 2 * r * rng.uniform(0.85, 1.1, 3) * ((1, 1, 1) if shipped else (0.75, 0.9, 1.4)), "ball": np.array([r]),
        "cylinder": np.array([r, rng.uniform(0.08, 0.11)]), "ellipsoid": r * rng.uniform(0.85, 1.2, 3),
    }[kind]  # fmt: skip
    about = np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]) if shipped and rng.random() < 0.5 else np.zeros(3)
    rotation = pin.exp3(0.15 * rng.normal(size=3)) @ pin.exp3(about) @ pin.exp3(np.array(start.turn))
    position = np.array(start.position) + 0.004 * rng.normal(size=3)
    thing = Thing(kind, tuple(sizes.tolist()), position, rotation, rng.uniform(0.02, 0.25))
    gravity = _UP if rng.random() < 0.5 else turn(rng) @ _UP
    torque = 0.0 if rng.random() < 0.25 else rng.uniform(0.5, 1.5)
    tips = list(TIPS[name])
    if name == "five_finger" and rng.random() < 0.5:
        tips = [tips[i] for i in ((0, 1, 2, 3), (0, 2, 3), (0, 1, 3, 4))[rng.integers(3)]]
    return HandRecipe(
        name, float(np.exp(rng.uniform(np.log(2.0), np.log(12.0)))), float(np.exp(rng.uniform(-10.0, -7.6))), torque,
        thing, start.q, some_law(rng, law, rng.uniform(0.4, 1.1)), rng.uniform(1.5e-3, 6e-3), gravity, tuple(tips),
    )  # fmt: skip


def _bare(rng: np.random.Generator, law: str) -> FreeRecipe:
    n, shape = int(rng.integers(3, 7)), rng.integers(3)
    if shape == 0:  # around a waist
        a = 2 * np.pi * (np.arange(n) + 0.4 * rng.uniform(-1, 1, n)) / n
        out = np.stack([np.cos(a), np.sin(a), 0.3 * rng.uniform(-1, 1, n)], axis=1)
    else:  # spread over a ball, and on the faces of a cube
        out = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        out = np.concatenate([out, -out])[rng.permutation(6)[:n]] + 0.3 * rng.normal(size=(n, 3))
        if n < 6:
            out -= out.mean(axis=0)
    out /= np.linalg.norm(out, axis=1)[:, None]
    Q, size = turn(rng), rng.uniform(0.02, 0.05)
    p = size * out * rng.uniform(0.8, 1.2, (n, 1))
    z = -out + 0.15 * rng.normal(size=(n, 3))
    z /= np.linalg.norm(z, axis=1)[:, None]
    x = np.cross(z, rng.normal(size=(n, 3)))
    x /= np.linalg.norm(x, axis=1)[:, None]
    R = np.stack([x, np.cross(z, x), z], axis=2)
    A = rng.normal(size=(3 * n, 3 * n))
    E = np.kron(np.diag(rng.uniform(0.5, 2.0, n)), np.diag([1.0, rng.uniform(0.4, 1.5), rng.uniform(0.3, 1.0)]))
    E = 3e-5 * E + (2e-6 * A @ A.T if rng.random() < 0.5 else 0.0)  # stiff: motions stay small
    alone = some_law(rng, law, rng.uniform(0.3, 0.9))
    laws = tuple(replace(alone, mu=alone.mu * rng.uniform(0.8, 1.2)) for _ in range(n))
    return FreeRecipe(p @ Q.T, Q @ R, laws, (E + E.T) / 2, rng.uniform(1e-4, 4e-4, n))


def _directions(rng: np.random.Generator) -> np.ndarray:
    """(12, 6) see `Case`."""
    ways = rng.normal(size=(DIRECTIONS, 6))
    ways /= np.linalg.norm(ways.reshape(-1, 2, 3), axis=2).repeat(3, axis=1)
    ways[:, 3:] *= 0.03
    ways[:8, 3:] = 0.0
    ways[10:, :3] = 0.0
    return ways
