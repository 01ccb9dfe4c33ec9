"""What users ask of a grasp: the arguments as they were given, and the specification made of them."""

from __future__ import annotations

from collections.abc import Iterator, KeysView, Mapping, ValuesView
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from handlcp.check import Array, array, read_only
from handlcp.errors import InputError
from handlcp.grasp.friction import FrictionLaw, laws_by_name
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact, frame
from handlcp.grasp.model.environment import Environment, beside, joined, offset_beside
from handlcp.grasp.model.flexibility import Flexibility, kept, matrix_of
from handlcp.grasp.model.spec import GraspSpec

_DEEP = 4  # lists in lists; nothing that is asked has more


@dataclass(frozen=True, eq=False)
class Asked:
    """The arguments of `Grasp`. A grasp keeps them, and `replace` makes it again with some of them changed."""

    contacts: Any
    wrench: Any = None
    flexibility: Any = 0.0
    preload: Any = 0.0
    offset: Any = None
    reference: Any = (0.0, 0.0, 0.0)
    effects: Any = ()
    plane: Any = None
    environment: Any = None

    def __post_init__(self) -> None:
        fastened(self)

    def spec(self) -> GraspSpec:
        """See `Grasp`. Raises InputError."""
        cs = validate.contacts(self.contacts)
        k, around = len(cs), None if self.environment is None else joined(self.environment)
        if around is not None:
            cs = validate.contacts((*cs, *around.contacts))
        positions, frames, normal = validate.placed(self.plane, cs)
        point = validate.reference(self.reference, normal, positions)
        load = validate.wrench(self.wrench, normal, validate.lift(positions, point, normal))
        own = self.flexibility
        E = own if _fits(own, k, around) else validate.flexibility(matrix_of(own), k, normal is not None)
        d = offset_beside(self.offset, self.preload, k, np.zeros((0, 3)) if around is None else around.offset)
        if around is not None:
            E = beside(matrix_of(E), around.flexibility)
        fingers, R = None if around is None else k, read_only(frames)
        spec = GraspSpec(cs, read_only(positions), R, normal, fingers, None, load, point, E, d)
        return as_asked(spec, self.effects).replace(asked=self)

    def changed(self, given: dict[str, Any]) -> Self:
        """With other values of some, as `said` has them; friction is that of the contacts."""
        if "friction" in given:
            cs = validate.contacts(self.contacts)
            names = [c.name or f"finger {i + 1}" for i, c in enumerate(cs)]
            laws = laws_by_name(given.pop("friction"), names, [c.friction for c in cs])
            given["contacts"] = tuple([rubbed(c, law) for c, law in zip(cs, laws, strict=True)])
        made: Self = again(self, given)
        return made


def _fits(E: Any, contacts: int, around: Environment | None) -> bool:
    """Whether a flexibility can stay the factor that it was given as; else it is read as a matrix."""
    return isinstance(E, Flexibility) and around is None and E.shape[0] == 3 * contacts


def alone(spec: GraspSpec, others: tuple[Any, ...]) -> GraspSpec:
    """A specification that is passed to `Grasp`, where the other arguments say nothing. Raises InputError."""
    wrench, _, _, offset, _, effects, plane, environment = others
    if any(x is not None for x in (wrench, offset, plane, environment)) or effects != ():
        raise InputError("contacts", "contacts, where other arguments are given", "a GraspSpec, which says all of it")
    return spec


def remade(spec: GraspSpec, given: dict[str, Any]) -> GraspSpec:
    """A grasp without a hand, made again with other arguments; see `Grasp.replace`."""
    given = said(given)
    if not given:
        return spec
    asked = (spec.asked if isinstance(spec.asked, Asked) else _asked_of(spec)).changed(given)
    return under(spec, asked.wrench, asked) if set(given) == {"wrench"} else asked.spec()


def under(spec: GraspSpec, wrench: Any, asked: Any) -> GraspSpec:
    """The same grasp under another whole load, as `asked` has it: it shares all its other arrays."""
    height = validate.lift(spec.positions, spec.reference, spec.plane)
    return spec.replace(wrench=validate.wrench(wrench, spec.plane, height), asked=asked)


def _asked_of(spec: GraspSpec) -> Asked:
    """Arguments that make a grasp of which a specification alone is known."""
    k, around = spec.of_hand, environment_of(spec)
    plane = None if spec.contacts[0].planar else spec.plane
    effects = tuple([e for e in spec.effects if e.by_name])
    E = kept(spec) if k == spec.n else spec.flexibility[: 3 * k, : 3 * k]
    d = of_hand_alone(spec.offset, k)
    return Asked(spec.contacts[:k], spec.wrench, E, 0.0, d, spec.reference, effects, plane, around)


def of_hand_alone(offset: Array, fingers: int) -> Array:
    """Rows of an offset (n, 3) [m]: the fingers', where the environment's are gaps, which it says itself."""
    return offset if offset[fingers:, :2].any() else offset[:fingers]


def environment_of(spec: GraspSpec) -> Environment | None:
    """The environment of a grasp, without what offsets move it along its tangents."""
    k = spec.of_hand
    if k == spec.n:
        return None
    return Environment(spec.contacts[k:], spec.flexibility[3 * k :, 3 * k :], spec.offset[k:, 2])


def as_asked(spec: GraspSpec, effects: Any) -> GraspSpec:
    """The specification with the effects that a user asks for by name, besides those it has. Raises InputError."""
    asked = validate.effects(effects, spec)
    return spec.replace(effects=(*asked, *spec.effects)) if asked else spec


def said(given: dict[str, Any]) -> dict[str, Any]:
    """What is to be replaced: all that is not None; an environment of nothing is none."""
    found = {name: value for name, value in given.items() if value is not None}
    if isinstance(around := found.get("environment"), (tuple, list)) and not around:
        found["environment"] = None
    return found


def rubbed(contact: Contact, law: FrictionLaw) -> Contact:
    """The contact under another law, its axes kept unless the law says where x lies."""
    if law.x_axis is None:
        return contact.with_friction(law)
    if contact.planar:
        return Contact(contact.position[:2], contact.normal[:2], law, None, contact.name)
    return contact.with_friction(law).moved(contact.position, frame(contact.normal, array("tangent", law.x_axis, (3,))))


def fastened(asked: Any) -> None:
    """Later changes of what was passed do not reach the fields of a dataclass."""
    values = vars(asked)
    for name, value in values.items():
        if type(value) not in _AS_IT_IS:
            values[name] = _own(value)


def again(asked: Any, changes: dict[str, Any]) -> Any:
    """The dataclass with other values of some fields; the rest is fastened already."""
    made = object.__new__(type(asked))
    vars(made).update(vars(asked) | {name: _own(value) for name, value in changes.items()})
    return made


_AS_IT_IS = frozenset({type(None), bool, int, float, str, Contact, Environment})


def _own(value: Any, depth: int = 0) -> Any:
    """Arrays copied; lists, views and iterators as tuples."""
    if type(value) in _AS_IT_IS:
        return value
    if isinstance(value, np.ndarray):
        copy: Array = value if not value.flags.writeable and value.base is None else read_only(value.copy())
        return copy
    if type(value) is tuple and all([type(x) in _AS_IT_IS for x in value]):
        return value
    if isinstance(value, Mapping):
        return {key: _own(x, depth + 1) for key, x in value.items()}
    if isinstance(value, (list, tuple, Iterator, KeysView, ValuesView)):
        return tuple([_own(x, depth + 1) for x in value]) if depth < _DEEP else value
    return value
