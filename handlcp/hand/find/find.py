"""A grasp found by one call: between the fingertips, or against the palm with the whole hand round the object."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from handlcp.check import check_call, check_flag, check_integer
from handlcp.contact.friction import laws_by_name
from handlcp.errors import InputError, NoGraspFound, pip_command
from handlcp.geometry.link_contacts import contact_body_names
from handlcp.geometry.mesh import object_advice
from handlcp.geometry.object import Object
from handlcp.geometry.shape import Mesh, check_object_kilograms, check_object_metres
from handlcp.grasp.model import validate
from handlcp.hand.find.candidate import Found, stopped, told
from handlcp.hand.find.pinch import Search
from handlcp.hand.find.power import PowerSearch
from handlcp.hand.request import DEFAULT_FRICTION
from handlcp.hand.squeeze import read_by_tip
from handlcp.hand.torque_closing import read_torque_by_joint
from handlcp.progress import track_progress as counted
from handlcp.robot.hand_model import HandModel, HandPosture, read_gravity
from handlcp.robot.link_surface import has_coacd

PINCH, POWER, ANY = "pinch", "power", "any"
KINDS = PINCH, POWER, ANY


@check_call("hand", "obj")
@counted("looking for a grasp")
def find_grasp(
    hand: HandModel,
    obj: Object,
    *,
    kind: str = PINCH,
    friction: Any = None,
    wrench: Any = None,
    gravity: Any = (0.0, 0.0, -9.81),
    squeeze: Any = None,
    grip_force: Any = None,
    closing_torque: Any = None,
    fingers: Sequence[str] | None = None,
    tries: int = 256,
    seed: int = 0,
    throw: bool = True,
) -> Found:
    """Place an object in the hand so that it is held: grasps, the best first.

    kind : "pinch": between the fingertips. Postures all over the joint ranges are compared, with the object between the
        fingertips in several orientations. From the best, up to `tries`, joints and object move together until all
        fingers touch and no link is inside the object. Where forces within friction balance the load, the grasp is
        solved; the best ones are followed, and varied. "power": the object is laid against the palm of the open hand, a
        long one across the fingers, and the hand closes from the palm outwards until links touch (`hand.close_on(obj,
        wrap=True)`). Two links of fingers and the palm have to touch, or three links of fingers. A grasp of it is
        `state.grasp(obj, links="all", closing_torque=…, hold_object=True)` from the open hand. "any": both.

    Grasps are sorted by the force that they hold beside the load in the worst of six directions, `held_force` of
    `Candidate`. The best that one solve holds are checked, then followed while the hand closes, is loaded and pushed:
    a few of each round of places, of power grasps until one holds as much as the load in every direction; the others
    are left out, and those that hold less than half of what the best one does. Those in which the object only lies on
    fingers, held by its own weight, come last and are called cradled. Each grasp of the result is HELD by
    `grasp.check()`, which follows it while the hand closes and is loaded; its object does not snap elsewhere on the
    way, or, of a power grasp, ends at the same place with twice the steps. The margin of a grasp is the smaller of its
    friction reserve and its torque reserve.

    obj : its shape and mass count, its placement does not. For a power grasp of a mesh
        that is not convex its parts count, which take the package coacd (pip install coacd).
    friction, wrench, gravity, squeeze, grip_force, closing_torque : as in `state.grasp`. With neither squeeze nor
        grip_force each fingertip presses with the normal force that balance needs, planned with 60 % of the friction.
        A power grasp is closed by torque; None: by half of each joint's limit, at most 0.5 N·m, or as much for each
        of several joints that are driven together.
    fingers : names of those that are to touch with their tips; None: all.
    tries : placements to begin with, ≥ 1. seed : the same seed finds the same grasps.
    throw : raise NoGraspFound, which says how far the search came, where nothing is found; False: an empty result.

    Raises InputError, also for an object too wide to be meant in metres; UnknownName; URDFError for a fingertip
    without any shape.
    """
    if not isinstance(hand, HandModel):
        raise InputError("hand", "a Hand", repr(hand))
    if not isinstance(obj, Object):
        raise InputError("obj", object_advice(obj), repr(obj)[:80])
    tips, tries, seed = (
        hand.tip_numbers("fingers", fingers),
        check_integer("tries", tries, 1),
        check_integer("seed", seed, 0),
    )
    check_flag("throw", throw)
    check_closing(kind, squeeze, grip_force, closing_torque, fingers)
    if kind != PINCH and isinstance(obj, Mesh) and not obj.convex and not has_coacd():
        expected = f"a convex object for a power grasp, or coacd for its convex parts ({pip_command('coacd')})"
        came = f"{obj!r}, which is not convex; its convex hull would be (trimesh: mesh.convex_hull)"
        raise InputError("obj", expected, came)
    asked = {
        "friction": friction, "wrench": wrench, "gravity": gravity, "squeeze": squeeze, "grip_force": grip_force,
        "closing_torque": closing_torque,
    }  # fmt: skip
    searches = searches_of(hand, obj, kind, asked, tips, seed)
    candidates = sorted([one for search in searches for one in search.run(tries)], key=lambda one: one.rank)
    tried = sum((search.tried for search in searches), Counter[str]())
    if candidates:
        number = "1 grasp" if len(candidates) == 1 else f"{len(candidates)} grasps"
        return Found(candidates, tried, f"{number} of {obj!r} found: {told(tried)}")
    why = missed(obj, searches)
    if throw:
        raise NoGraspFound(why, dict(tried), tuple(one for search in searches for one in search.refused))
    return Found((), tried, why)


def searches_of(
    hand: HandModel, obj: Object, kind: str, asked: Mapping[str, Any], tips: tuple[int, ...], seed: int
) -> list[Search | PowerSearch]:  # fmt: skip
    """One for each kind of grasp. asked : what `find_grasp` passes on to `state.grasp`, without the fingers; of what
    closes the hand each search takes its own. tips : numbers of the fingertips that a pinch touches with.

    Raises InputError, UnknownName: what a search passes on is checked before it begins.
    """
    check_object_metres("obj", obj, HandPosture(hand, hand.neutral).tip_positions)
    check_object_kilograms("obj.mass", obj, hand.mass)
    _check_asked(hand, kind, asked, tips)
    load = {name: asked.get(name) for name in ("friction", "wrench", "gravity")}
    searches = list[Search | PowerSearch]()
    if kind != POWER:
        pinched = {name: asked.get(name) for name in ("squeeze", "grip_force")}
        searches.append(
            Search(hand, tips, obj, {**load, **pinched, "fingers": [hand.fingertips[i] for i in tips]}, seed)
        )
    if kind != PINCH:
        searches.append(PowerSearch(hand, obj, {**load, "closing_torque": asked.get("closing_torque")}, seed))
    return searches


def _check_asked(hand: HandModel, kind: str, asked: Mapping[str, Any], tips: tuple[int, ...]) -> None:
    """Raises InputError for what no grasp can be asked with, UnknownName for fingers, links and joints."""
    names = [hand.fingertips[i] for i in tips]
    if (friction := asked.get("friction")) is not None:
        known = names if kind == PINCH else list(dict.fromkeys((*hand.fingertips, *contact_body_names(hand))))
        laws_by_name(friction, known, [DEFAULT_FRICTION] * len(known))
    validate.wrench(asked.get("wrench"), None)
    read_gravity(asked.get("gravity"))
    for name in ("squeeze", "grip_force"):
        if (value := asked.get(name)) is not None:
            read_by_tip(name, value, names)
    if (torque := asked.get("closing_torque")) is not None:
        read_torque_by_joint(torque, hand.joint_names)


def missed(obj: Object, searches: Sequence[Search | PowerSearch]) -> str:
    """That nothing was found, why the best did not serve, and then how far the searches came."""
    tried = sum((search.tried for search in searches), Counter[str]())
    pinches = [search for search in searches if isinstance(search, Search)]
    wraps = len(pinches) < len(searches)
    by = "the whole hand" if wraps else f"all of {', '.join(pinches[0].fingers)}"
    if refused := [one for search in searches for one in search.refused]:
        why = f"the best that was tried: {refused[0].doubt}"
    elif rigid := [text for search in searches for text in search.rigid]:
        why = f"they cannot be squeezed: {rigid[0]}"
    elif unheld := [text for search in pinches if (text := search.unheld)]:
        why = unheld[0]
    elif wraps and not tried["enclosing"]:
        why = "it may be too small or too large for this hand to close round it, which hand.describe() shows"
    else:
        why = stopped(tried)
    return f"no grasp of {obj!r} by {by} found: {why} ({told(tried)})"


def check_closing(kind: Any, squeeze: Any, grip_force: Any, closing_torque: Any, fingers: Any = None) -> None:
    """Raises InputError for no kind of grasp, and for what a grasp of this kind is not closed by."""
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError("kind", '"pinch", "power" or "any"', repr(kind)[:80])
    if squeeze is not None and grip_force is not None:
        raise InputError("grip_force", "None beside a squeeze", repr(grip_force))
    if kind == PINCH and closing_torque is not None:
        raise InputError("closing_torque", 'None for fingertips: it closes a grasp of kind "power"', closing_torque)
    if kind == POWER:
        for name, value in (("squeeze", squeeze), ("grip_force", grip_force), ("fingers", fingers)):
            if value is not None:
                raise InputError(name, "None for a power grasp, which closing_torque closes", repr(value)[:80])
