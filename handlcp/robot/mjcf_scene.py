"""What of an MJCF file is the hand, and what is the scene around it: objects to grasp, tables, the shapes of the world.

Bodies that the world carries stand for themselves, with all that they carry. What has no joint, or none but a free one,
is no hand; neither is what has joints that no actuator drives, beside one that actuators drive. The shapes of the world
are those of a hand only where its fingers stand in the world itself, without a palm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from handlcp import words
from handlcp.robot.joint import Doubt

_FREE_JOINT = 0  # the kind of a joint
_DRIVES_JOINT, _DRIVES_JOINT_IN_PARENT, _DRIVES_TENDON = 0, 1, 3  # what an actuator moves
_WRAPS_JOINT, _WRAPS_PULLEY, _WRAPS_SITE = 1, 2, 3  # what a tendon passes; others are geoms
_COUPLES_JOINTS = 2  # an equality; those before it are of bodies or sites


class SceneParts(NamedTuple):
    """What of an MJCF file is the scene's, and no part of the hand. bodies : numbers of those that are left out.
    has_ground : whether the shapes of the world are. doubts : what is said of it.
    """

    bodies: frozenset[int] = frozenset()
    has_ground: bool = False
    doubts: tuple[Doubt, ...] = ()


def find_scene_parts(model: Any, names: Sequence[str], base: str | None) -> SceneParts:
    """Of a compiled mujoco.MjModel. names : of its bodies. base : the link that is asked for: what it carries is the
    hand, whatever the rest is.
    """
    if base is not None and base != names[0]:
        return SceneParts()
    top = model.body_rootid
    moved = [int(top[model.jnt_bodyid[j]]) for j in range(model.njnt) if model.jnt_type[j] != _FREE_JOINT]
    trees = dict.fromkeys(moved)
    driven = _driven_bodies(model)
    hand = [b for b in trees if b in driven] or list(trees)
    if not hand:
        return SceneParts()
    ground = any(_count_chain_ends(model, b) > 1 for b in hand)
    others = [b for b in dict.fromkeys(top.tolist()) if b and b not in hand]
    out = [b for b in others if ground or b in trees or _is_free(model, b)]
    skipped = frozenset(b for b in range(1, model.nbody) if int(top[b]) in out)
    kinds = {
        "free to move": [b for b in out if b not in trees and _is_free(model, b)],
        "without a joint": [b for b in out if b not in trees and not _is_free(model, b)],
        "that no actuator drives": [b for b in out if b in trees],
    }
    said = [f"{words.list_names([names[b] for b in these])} ({why})" for why, these in kinds.items() if these]
    said += ["the shapes of the world body"] if ground and model.body_geomnum[0] else []
    what = f"parts of the scene are left out, with their mass: {'; '.join(said)}"
    advice = "base= with a body's name, to read another part of the file"
    doubts = (Doubt("hand", what, advice, "information", "scene"),) if said else ()
    return SceneParts(skipped, ground, doubts)


def _is_free(model: Any, body: int) -> bool:
    """Whether a body that the world carries floats, or is put anywhere by a simulation."""
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    return int(model.body_mocapid[body]) >= 0 or _FREE_JOINT in model.jnt_type[first : first + count]


def _count_chain_ends(model: Any, tree: int) -> int:
    """How many joints of a tree carry none."""
    carriers, last = set[int](), set[int]()
    for body in {int(b) for b, kind in zip(model.jnt_bodyid, model.jnt_type, strict=True) if kind != _FREE_JOINT}:
        if int(model.body_rootid[body]) == tree:
            last.add(body)
            while (body := int(model.body_parentid[body])) > 0:
                carriers.add(body)
    return len(last - carriers)


def _driven_bodies(model: Any) -> set[int]:
    """The bodies on the world whose joints actuators drive, also through others that are coupled to them."""
    top, owners = model.body_rootid, model.jnt_bodyid
    found = {int(top[b]) for a in range(model.nu) for b in _actuated_bodies(model, a)}
    pairs = list[tuple[int, int]]()
    for e in range(model.neq):
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if int(model.eq_type[e]) == _COUPLES_JOINTS and two >= 0 and model.eq_active0[e]:
            pairs.append((int(top[owners[one]]), int(top[owners[two]])))
    for _ in pairs:
        for one, two in pairs:
            if one in found or two in found:
                found |= {one, two}
    return found


def _actuated_bodies(model: Any, a: int) -> Iterator[int]:
    """The bodies that an actuator moves by joints or by a tendon; none for other kinds."""
    owners = {_WRAPS_JOINT: model.jnt_bodyid, _WRAPS_SITE: model.site_bodyid}  # of what is neither, geoms
    kind, target = int(model.actuator_trntype[a]), int(model.actuator_trnid[a, 0])
    if kind in (_DRIVES_JOINT, _DRIVES_JOINT_IN_PARENT):
        yield int(model.jnt_bodyid[target])
    elif kind == _DRIVES_TENDON:
        first = int(model.tendon_adr[target])
        for w in range(first, first + int(model.tendon_num[target])):
            if model.wrap_type[w] != _WRAPS_PULLEY:
                yield int(owners.get(int(model.wrap_type[w]), model.geom_bodyid)[model.wrap_objid[w]])


def is_of_scene(model: Any, equality: int, bodies: frozenset[int]) -> bool:
    """Whether a constraint takes part in what is left out."""
    return bool(bodies) and not bodies.isdisjoint(tied_bodies(model, equality))


def tied_bodies(model: Any, equality: int) -> tuple[int, ...]:
    """The bodies that a constraint between joints, bodies or sites ties to each other; () of others."""
    import mujoco

    ids = [int(i) for i in (model.eq_obj1id[equality], model.eq_obj2id[equality]) if i >= 0]
    if int(model.eq_type[equality]) == _COUPLES_JOINTS:
        return tuple(int(model.jnt_bodyid[i]) for i in ids)
    if int(model.eq_type[equality]) > _COUPLES_JOINTS:
        return ()
    if int(model.eq_objtype[equality]) == int(mujoco.mjtObj.mjOBJ_SITE):
        return tuple(int(model.site_bodyid[i]) for i in ids)
    return tuple(ids)
