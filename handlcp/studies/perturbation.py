"""`vary_grasp`: the same grasp by a hand with other numbers, and what an answer does when one of them changes a little.

    d x / d v ≈ (x(v + h) - x(v - h)) / 2h

of the whole grasp made and solved again. Where another length or radius moves the fingertips, joints and object move
together, as little as possible, until all of them touch again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, check_call, check_sequence, read_only
from handlcp.contact.friction import Pyramid
from handlcp.errors import InputError, NoGraspFound, Unsupported, shorten_repr, translate_arguments
from handlcp.geometry.object import Object
from handlcp.grasp.model.request import with_changes
from handlcp.hand.find.clear import Links, Place
from handlcp.hand.find.touch import brought_together
from handlcp.hand.hand import Hand, HandState
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.request import GraspRequest
from handlcp.hand.vary.hand_shape import AXIS, LENGTH, POSITION, RADIUS, read_changes
from handlcp.hand.vary.vary import hand_number, number_unit
from handlcp.progress import track_progress
from handlcp.record import Record
from handlcp.words import TextTable

_CLOSED_GAP = 1e-10  # [m] gaps that count as closed, where distances are so good
_RELATIVE_STEP = 1e-3  # of a number, to either side
_NEGLIGIBLE_SHARE = 0.01  # of what it would be in proportion to the number: a smaller derivative does not matter
_KINK_TOLERANCE = 0.02  # of the largest derivative: as much as steps of two sizes, or both sides, may differ by


@check_call("changes")
def vary_grasp(grasp: HandGrasp, changes: Mapping[str, Any]) -> HandGrasp:
    """The same grasp by its hand with other numbers, by the names of `Hand.vary`. It is made again as it was asked for:
    a squeeze, a grip force or a joint offset is commanded anew.

    Other lengths, axes, places of joints and radii move the fingertips: joints and object then move together, as little
    as possible, until every fingertip of the grasp touches the object again. Others leave the posture as it is.
    Raises what `Hand.vary` raises; NoGraspFound where fingertips do not come to touch again; Unsupported for a grasp
    whose contacts were given, or that stands on a table, where they have to.
    """
    if not isinstance(grasp, HandGrasp) or not isinstance(asked := grasp.spec.asked, GraspRequest):
        raise InputError("grasp", "a grasp that a hand's state made", repr(grasp)[:80])
    hand = grasp.state.hand
    assert isinstance(hand, Hand)  # others have no names for what varies
    said = read_changes(hand, changes)
    varied = hand.vary(changes)
    if not (any(said.values_of(what) for what in (LENGTH, AXIS, POSITION, RADIUS)) or "tip_radius" in said.arguments):
        return HandGrasp(with_changes(asked, {"state": HandState(varied, grasp.state.q)}).spec())
    obj = asked.target
    if not isinstance(obj, Object) or asked.found is not None or asked.environment is not None:
        raise Unsupported("a hand of another shape touches elsewhere: contacts that were given, and tables, stay")
    fingers = list(grasp.fingertips)
    tips, place = varied.tip_numbers("fingers", fingers), Place(grasp.state.q, *map(np.array, obj.frame))
    asks = varied, tips, Links(varied, tips), obj.moved_to(np.zeros(3)), place
    touch = brought_together(*asks, close=_CLOSED_GAP) or brought_together(*asks)
    if touch is None:
        raise NoGraspFound(f"with {dict(changes)!r} the fingertips do not come to touch the object again", {})
    state = HandState(varied, touch.place.q)
    return HandGrasp(with_changes(asked, {"state": state, "target": touch.place.of(obj)}).spec())


# ----------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Slopes(Record):
    """Derivatives of an answer by k numbers of the hand; made by `slopes`.

    names : of the numbers, as of `Hand.vary`. values (k,) : what they are. Derivatives per SI unit of each number:
    forces (n, 3, k) on the object in world axes [N], normal_force (n, k) [N], torques (nv, k) [N·m], displacement
    (6, k) of the object [m, rad].
    kinks : numbers at which a derivative has two sides, or changes at once: contacts begin to slide or let go, or a
    fingertip comes to touch with another part. There the derivative is the mean of both sides.
    """

    entries = (
        "names", "values (k,)", "forces (n, 3, k)", "normal_force (n, k)", "torques (nv, k)", "displacement (6, k)",
        "kinks",
    )  # fmt: skip

    names: tuple[str, ...]
    values: Array
    forces: Array
    normal_force: Array
    torques: Array
    displacement: Array
    kinks: tuple[str, ...]

    @property
    def table(self) -> TextTable:
        """What a tenth more of each number does."""
        tenth = 0.1 * self.values
        rows = []
        for k, name in enumerate(self.names):
            force, torque = (float(abs(tenth[k] * one[..., k]).max()) for one in (self.normal_force, self.torques))
            moves = 1e3 * float(np.linalg.norm(tenth[k] * self.displacement[:3, k]))
            told = "kink" if name in self.kinks else ""
            value = f"{self.values[k]:.4g} {number_unit(name)}"
            rows.append((name, value, f"{force:.3g}", f"{torque:.3g}", f"{moves:.3g}", told))
        return TextTable(("10 % more of", "", "force\nN", "torque\nN·m", "motion\nmm", ""), tuple(rows), "<>>>><")

    def __str__(self) -> str:
        return f"{self.table}\nThe largest change of a normal force, of a torque, and of where the object is."


@check_call()
def slopes(grasp: HandGrasp, names: Iterable[str], *, faces: int | str | Pyramid = "cone") -> Slopes:
    """Derivatives of forces, torques and the object's displacement by numbers of the hand, by the names of `Hand.vary`:
    "finger_1_distal.length", "index_tip.pad", "joint_stiffness", …; each one number above 0.

    The grasp is made (`vary_grasp`) and solved again with a little more and a little less of each, in steps of two
    sizes, so that kinks are found. Raises InputError, UnknownName, what `vary_grasp` raises, and NoSolutionFound where
    a grasp is not held.
    """
    if not isinstance(grasp, HandGrasp):
        raise InputError("grasp", "a hand's grasp", repr(grasp)[:80])
    expected = "names of numbers of the hand, at least one, and each once"
    asked = (names,) if isinstance(names, str) else check_sequence("names", names, expected)
    if not asked or not all(isinstance(name, str) for name in asked) or len(set(asked)) < len(asked):
        raise InputError("names", expected, shorten_repr(names))
    hand, kinks, columns = grasp.state.hand, list[str](), list[Array]()
    with translate_arguments({"changes": "names"}):
        values = [hand_number(hand, name) for name in asked]
    with track_progress("numbers of the hand", len(asked)) as done:
        for name, value in zip(asked, values, strict=True):
            column, kink = _find_slope(grasp, name, value, faces)
            columns.append(column)
            kinks += [name] if kink else []
            done(1)
    n, nv = grasp.spec.n, len(hand.joint_names)
    found = np.stack(columns, axis=-1)
    forces, normal, torques, displacement = np.split(found, np.cumsum([3 * n, n, nv]))
    return Slopes(
        names=asked,
        values=read_only(np.array(values)),
        forces=read_only(forces.reshape(n, 3, -1)),
        normal_force=read_only(normal),
        torques=read_only(torques),
        displacement=read_only(displacement),
        kinks=tuple(kinks),
    )


def _find_slope(grasp: HandGrasp, name: str, value: float, faces: Any) -> tuple[Array, bool]:
    """Derivatives by one number, all in a row; and whether it is a kink."""
    if not 0.0 < value < np.inf:
        raise InputError("names", "numbers above 0 and finite", f"{name!r}, which is {value:g}")

    def answer_at(share: float) -> Array:
        s = vary_grasp(grasp, {name: value * (1.0 + share)}).solve(faces)
        torques: Any = getattr(s, "torques")  # noqa: B009  of a hand
        return np.concatenate([s.forces_world.reshape(-1), s.normal_force, torques, s.object_displacement])

    def sizes(row: Array) -> Array:
        """(4,) of the forces, the torques, the shift and the turn in a row."""
        parts = np.split(row, np.cumsum([4 * grasp.spec.n, len(grasp.state.hand.joint_names), 3]))
        return np.array([np.linalg.norm(part) for part in parts])

    h, here = 0.5 * _RELATIVE_STEP, answer_at(0.0)
    far_ahead, far_behind, ahead, behind = (answer_at(share) for share in (2.0 * h, -2.0 * h, h, -h))
    wide, fine = (far_ahead - far_behind) / (4.0 * h * value), (ahead - behind) / (2.0 * h * value)
    sides = (ahead - here) / (h * value), (here - behind) / (h * value)
    least = np.maximum(sizes(fine), _NEGLIGIBLE_SHARE * sizes(here) / value)
    off = np.maximum(sizes(wide - fine), sizes(sides[0] - sides[1]))
    return fine, bool((off > _KINK_TOLERANCE * least).any())
