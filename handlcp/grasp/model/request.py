"""`GraspSpec`: a grasp as data, its contacts, load, effects and mechanism; and the requests it is made from."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, KeysView, Mapping, ValuesView
from dataclasses import dataclass
from functools import reduce
from typing import Any, Self, TypeVar

import numpy as np

from handlcp.check import (
    Array,
    check_array,
    check_init_call,
    check_number,
    check_sequence,
    count_dimensions,
    freeze_arrays,
    read_only,
)
from handlcp.contact.friction import FrictionLaw, laws_by_name
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact, Placement, contact_frame, cross_rows
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.flexibility import Flexibility, flexibility_matrix, holds_flexibility, stored_flexibility
from handlcp.lazy_property import lazy_property

LOAD_ROUNDING_SHARE = 1e-12  # of the whole load: less of it besides the weight is rounding
_ARRAY_FIELDS = ("positions", "frames", "wrench", "reference", "flexibility", "offset")


@holds_flexibility
@dataclass(frozen=True, eq=False)
class GraspSpec(Placement):
    """A grasp before it is built: sound arrays, read-only, SI. Immutable; `build_scene` makes a `Scene` of it.

    Besides what `Placement` says: wrench (6,) force and torque about reference (3,) that the world applies to the
    object. flexibility (3n, 3n) of fingers and environment in contact axes, made of a `Flexibility` where one was
    given, and offset (n, 3) of the object relative to them before any load, both without what the effects add.
    effects : all that were asked for, in `effects=` or by an argument of their own, such as `finger_weight=`. asked :
    the arguments that all this was made of, which `replace` of a grasp changes; None: they are not known, as after any
    change of the specification itself.
    """

    wrench: Array
    reference: Array
    flexibility: Array
    offset: Array
    effects: tuple[Effect, ...] = ()
    asked: Any = None

    def __post_init__(self) -> None:
        """Raises InputError where shapes do not fit one another; the numbers were checked where they came in."""
        n = self.n
        shapes = ((n, 3), (n, 3, 3), (6,), (3,), (3 * n, 3 * n), (n, 3))
        arrays = (self.positions, self.frames, self.wrench, self.reference, stored_flexibility(self), self.offset)
        if tuple([a.shape for a in arrays]) == shapes:
            return
        for name, value, shape in zip(_ARRAY_FIELDS, arrays, shapes, strict=True):
            if value.shape != shape:
                raise InputError(f"GraspSpec.{name}", f"shape {shape} with {n} contacts", value.shape)

    def replace(self, **changes: Any) -> Self:
        """The same with other values of some fields."""
        return dataclasses.replace(self, **({"asked": None, "flexibility": stored_flexibility(self)} | changes))

    def with_laws(self, laws: tuple[FrictionLaw, ...]) -> Self:
        """The same with other friction, a law for each contact."""
        return self.replace(contacts=tuple([c.with_friction(f) for c, f in zip(self.contacts, laws, strict=True)]))

    def with_squeeze(self, extra: float) -> Self:
        """The same with `extra` [m] more squeeze of every finger whose force is not prescribed."""
        offset = self.offset.copy()
        offset[self.free_fingers, 2] -= extra
        return self.replace(offset=read_only(offset))

    @property
    def resting_wrench(self) -> Array:
        """(6,) what is on the object before another load grows, about the reference [N, N·m]: its weight, where a hand
        knows it; of contacts without a hand the whole wrench, of which nobody knows what is weight.
        """
        return self.wrench if self.mechanism is None else self.mechanism.weight_of_object(self.reference)

    @property
    def load_beside_weight(self) -> Array:
        """(6,) what loads the object besides its weight, about the reference [N, N·m]; 0 where that is rounding. Of
        contacts without a hand the whole wrench.
        """
        if self.mechanism is None:
            return self.wrench
        load = self.wrench - self.mechanism.weight_of_object(self.reference)
        load[abs(load) <= LOAD_ROUNDING_SHARE * abs(self.wrench).max()] = 0.0
        return read_only(load)

    @property
    def free_fingers(self) -> list[int]:
        """Numbers of the fingers whose force is not prescribed: those that a squeeze acts on."""
        known = {i for e in self.effects for i in e.prescribed()}
        return [i for i in range(self.of_hand) if i not in known]

    def fingers_alone(self) -> Self:
        """The same without the environment."""
        k, mechanism = self.of_hand, self.mechanism
        if mechanism is not None:
            mechanism = dataclasses.replace(mechanism, jacobian=mechanism.jacobian[: 3 * k])
        return self.replace(
            contacts=self.contacts[:k], positions=self.positions[:k], frames=self.frames[:k], offset=self.offset[:k],
            flexibility=read_only(self.flexibility[: 3 * k, : 3 * k].copy()), fingers=None, mechanism=mechanism,
        )  # fmt: skip

    @lazy_property
    def names(self) -> tuple[str, ...]:
        """(n,) names of the contacts, the fingers' first: their own, or "finger 1", "finger 2", … for those without."""
        return tuple([c.name or f"finger {i + 1}" for i, c in enumerate(self.contacts)])

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(freeze_arrays(state))


def wrench_about(point: Array, force: Array, moment: Array) -> Array:
    """(6,) the wrench about a point (3,) from its force and its moment about the world's origin, (3,) each."""
    return read_only(np.append(force, moment - cross_rows(point, force)))


# ----------------------------------------------------------------
# What the object touches besides the hand: a table, a wall, a fixture.
#
#     E = blkdiag(E_fingers, E_environment),    J_environment = 0
#
# An environment contact is a contact like any other (unilateral, with friction and a gap) whose finger is the world. No
# joint moves it, so that its rows of the Jacobian are zero, no preload squeezes it and no soft wrist carries it; what
# gives way is the environment itself: 0, a rigid one. In all arrays the fingers come first, the environment's contacts
# last.


@check_init_call()
class Environment:
    """m contacts of the world with the object, for `Grasp(..., environment=...)` and `state.grasp(..., environment=)`.

    contacts : sequence of `Contact`, m of them, normals into the object; one without a name becomes "environment 1", …
    flexibility : [m/N] as in `Grasp`: a number, a (3,) diagonal for each, (m, 3, 3) blocks or the (3m, 3m) matrix in
        contact axes; 0: rigid. Several contacts on something rigid seldom have determined forces.
    gap : [m] a number or (m,), from the object to each; < 0: it overlaps, and is squeezed by as much.

    Attributes: contacts, flexibility (3m, 3m), gap (m,). Immutable. Raises InputError.
    """

    __slots__ = ("contacts", "flexibility", "gap")

    contacts: tuple[Contact, ...]
    flexibility: Array
    gap: Array

    def __init__(self, contacts: Iterable[Contact], flexibility: Any = 0.0, gap: Any = 0.0) -> None:
        cs = validate.contacts(contacts)
        m = len(cs)
        given = np.full(m, check_number("gap", gap)) if count_dimensions(gap) == 0 else check_array("gap", gap, (m,))
        E = validate.flexibility(flexibility, m, cs[0].planar)
        for name, value in (("contacts", cs), ("flexibility", E), ("gap", read_only(given))):
            object.__setattr__(self, name, value)

    @property
    def offset(self) -> Array:
        """(m, 3) the gaps as offsets in contact axes [m]."""
        return np.column_stack([np.zeros((len(self.gap), 2)), self.gap])

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"an Environment is immutable: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Environment, (self.contacts, self.flexibility, self.gap))

    def __repr__(self) -> str:
        return f"Environment({list(self.contacts)!r})"


def join_environments(value: Any) -> Environment:
    """One environment of one or several, every contact with a name of its own. Raises InputError."""
    expected = "an Environment (of a Table: table.under(obj)), or a sequence of them"
    parts = (value,) if isinstance(value, Environment) else check_sequence("environment", value, expected)
    for k, part in enumerate(parts):
        if not isinstance(part, Environment):
            raise InputError(f"environment[{k}]", "an Environment", repr(part)[:80])
    if not parts:
        raise InputError("environment", "at least one Environment, or None", "an empty sequence")
    given = [c for part in parts for c in part.contacts]
    names = [c.name or f"environment {k}" for k, c in enumerate(given, 1)]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InputError("environment", "a different name for each contact", f"several called {', '.join(twice)}")
    blocks = reduce(join_flexibilities, [part.flexibility for part in parts])
    contacts = [c.with_name(name) for c, name in zip(given, names, strict=True)]
    return Environment(contacts, blocks, np.concatenate([part.gap for part in parts]))


def join_flexibilities(first: Array, last: Array) -> Array:
    """The block-diagonal flexibility of two groups of contacts of which neither moves under the other's forces."""
    both = np.pad(first, (0, len(last)))
    both[len(first) :, len(first) :] = last
    return read_only(both)


def join_offsets(value: Any, preload: Any, fingers: int, around: Environment | None) -> Array:
    """(n, 3) offsets of all contacts, from those of the fingers, the environment's being its gaps, or from all of them.

    value, preload : as in `Grasp`; a preload is the fingers' alone.
    """
    last = np.zeros((0, 3)) if around is None else around.offset
    n = fingers + len(last)
    if value is not None and count_dimensions(value) == 2 and len(value) == n:
        every = check_array("offset", value, (n, 3))
        value, last = every[:fingers], every[fingers:]
    return read_only(np.concatenate([validate.offset(value, preload, fingers), last]))


def join_contacts(contacts: tuple[Contact, ...], around: Environment | None) -> tuple[Contact, ...]:
    """The fingers' contacts and then the environment's. Raises InputError where some are planar and others not."""
    return contacts if around is None else validate.contacts((*contacts, *around.contacts))


# ----------------------------------------------------------------
# What users ask of a grasp: the arguments as they were given, and the specification made of them.


_MAX_NESTING = 4  # lists in lists; no argument has more


@dataclass(frozen=True, eq=False)
class Request(ABC):
    """The arguments that a grasp was made of, as they were given. A grasp keeps them, and `rebuild` changes some."""

    def __post_init__(self) -> None:
        values = vars(self)
        for name, value in values.items():
            if type(value) not in _IMMUTABLE_TYPES:
                values[name] = _freeze_value(value)

    @classmethod
    @abstractmethod
    def from_spec(cls, spec: GraspSpec) -> Self:
        """Arguments that make a grasp of which its specification alone is known."""

    @abstractmethod
    def spec(self) -> GraspSpec:
        """The specification that these arguments make. Raises InputError."""

    @abstractmethod
    def with_values(self, spec: GraspSpec, given: dict[str, Any]) -> Self:
        """The request with other values of some arguments of `replace`. spec : made of this one. Raises InputError."""

    @abstractmethod
    def whole_load(self, spec: GraspSpec) -> Any:
        """The wrench on the object, its weight included, about the reference of `spec`, which all but the load made."""


def rebuild(spec: GraspSpec, given: dict[str, Any], kind: type[Request]) -> GraspSpec:
    """The specification made again with other values of some arguments; see `Grasp.replace`. Raises InputError.

    given : by argument; None: as it was.
    kind : of request, for a specification whose arguments are not known.
    """
    given = {name: value for name, value in given.items() if value is not None}
    if isinstance(around := given.get("environment"), (tuple, list)) and not around:
        given["environment"] = None
    if not given:
        return spec
    asked = spec.asked if isinstance(spec.asked, kind) else kind.from_spec(spec)
    made = asked.with_values(spec, given)
    if set(given) in ({"wrench"}, {"load"}):  # all else stays as it is, and is shared
        return replace_load(spec, made.whole_load(spec), made)
    return made.spec()


@dataclass(frozen=True, eq=False)
class ContactGraspRequest(Request):
    """The arguments of `Grasp`."""

    contacts: Any
    wrench: Any = None
    flexibility: Any = 0.0
    preload: Any = 0.0
    offset: Any = None
    reference: Any = (0.0, 0.0, 0.0)
    effects: Any = ()
    plane: Any = None
    environment: Any = None

    @classmethod
    def from_spec(cls, spec: GraspSpec) -> Self:
        k = spec.of_hand
        plane = None if spec.contacts[0].planar else spec.plane
        effects = tuple([e for e in spec.effects if e.by_name])
        E = stored_flexibility(spec) if k == spec.n else spec.flexibility[: 3 * k, : 3 * k]
        offset = hand_offset(spec.offset, k)
        around = environment_of(spec)
        return cls(spec.contacts[:k], spec.wrench, E, 0.0, offset, spec.reference, effects, plane, around)

    def spec(self) -> GraspSpec:
        cs = validate.contacts(self.contacts)
        k, around = len(cs), None if self.environment is None else join_environments(self.environment)
        cs = join_contacts(cs, around)
        positions, frames, normal = validate.positions_and_frames(self.plane, cs)
        point = validate.reference(self.reference, normal, positions)
        load = validate.wrench(self.wrench, normal, validate.height_above(positions, point, normal))
        own = self.flexibility
        if around is None and isinstance(own, Flexibility) and own.shape[0] == 3 * k:
            E: Any = own  # stays the factor that it was given as
        else:
            E = validate.flexibility(flexibility_matrix(own), k, normal is not None)
        if around is not None:
            E = join_flexibilities(E, around.flexibility)
        d = join_offsets(self.offset, self.preload, k, around)
        fingers, R = None if around is None else k, read_only(frames)
        spec = GraspSpec(cs, read_only(positions), R, normal, fingers, None, load, point, E, d)
        return to_spec(spec, self.effects).replace(asked=self)

    def with_values(self, spec: GraspSpec, given: dict[str, Any]) -> Self:
        changes = dict(given)
        if "friction" in changes:  # which the contacts have
            cs = validate.contacts(self.contacts)
            names = [c.name or f"finger {i + 1}" for i, c in enumerate(cs)]
            laws = laws_by_name(changes.pop("friction"), names, [c.friction for c in cs])
            changes["contacts"] = tuple([replace_friction(c, law) for c, law in zip(cs, laws, strict=True)])
        return with_changes(self, changes)

    def whole_load(self, spec: GraspSpec) -> Any:
        return self.wrench


def replace_load(spec: GraspSpec, wrench: Any, asked: Any) -> GraspSpec:
    """The same grasp under another whole load, as `asked` has it: it shares all its other arrays."""
    return spec.replace(wrench=check_load(spec, wrench), asked=asked)


def check_load(spec: GraspSpec, load: Any, argument: str = "wrench") -> Array:
    """(6,) a load on the object of a grasp, about its reference [N, N·m].

    load : (6,), of a planar grasp also (3,): two forces in the xy plane and the moment; None: no load.
    Raises InputError, which names the argument, for other shapes, and for what does not act in a planar grasp's plane.
    """
    height = validate.height_above(spec.positions, spec.reference, spec.plane)
    return validate.wrench(load, spec.plane, height, argument)


def check_loads(spec: GraspSpec, loads: Any, argument: str) -> Array:
    """(m, 6) one load or several, each as in `check_load`. Raises InputError."""
    shapes = ((6,), (-1, 6)) if spec.plane is None else ((6,), (3,), (-1, 6), (-1, 3))
    given = check_array(argument, loads, *shapes, what=validate.WRENCH_EXPECTED)
    if given.ndim == 1:
        return read_only(check_load(spec, given, argument)[None])
    if not len(given):
        raise InputError(argument, "at least one load", "none")
    return read_only(np.array([check_load(spec, row, f"{argument}[{k}]") for k, row in enumerate(given)]))


def hand_offset(offset: Array, fingers: int) -> Array:
    """Rows of an offset (n, 3) [m]: the fingers', where the environment's are gaps, which it says itself."""
    return offset if offset[fingers:, :2].any() else offset[:fingers]


def environment_of(spec: GraspSpec) -> Environment | None:
    """The environment of a grasp, without what offsets move it along its tangents."""
    k = spec.of_hand
    if k == spec.n:
        return None
    return Environment(spec.contacts[k:], spec.flexibility[3 * k :, 3 * k :], spec.offset[k:, 2])


def to_spec(spec: GraspSpec, effects: Any) -> GraspSpec:
    """The specification with the effects that a user asks for by name, besides those it has. Raises InputError."""
    asked = validate.effects(effects, spec)
    return spec.replace(effects=(*asked, *spec.effects)) if asked else spec


def replace_friction(contact: Contact, law: FrictionLaw) -> Contact:
    """The contact under another law, its axes kept unless the law says where x lies."""
    if law.x_axis is None:
        return contact.with_friction(law)
    if contact.planar:
        return Contact(contact.position[:2], contact.normal[:2], law, None, contact.name)
    rotation = contact_frame(contact.normal, check_array("tangent", law.x_axis, (3,)))
    return Contact.from_arrays(contact.position, rotation, law, name=contact.name)


def with_changes(asked: RequestT, changes: Mapping[str, Any]) -> RequestT:
    """The request with other values of some fields; the others are copies already."""
    made = object.__new__(type(asked))
    vars(made).update(vars(asked) | {name: _freeze_value(value) for name, value in changes.items()})
    return made


RequestT = TypeVar("RequestT", bound=Request)
_IMMUTABLE_TYPES = frozenset({type(None), bool, int, float, str, Contact, Environment})


def _freeze_value(value: Any, depth: int = 0) -> Any:
    """Arrays copied; lists, views and iterators as tuples."""
    if type(value) in _IMMUTABLE_TYPES:
        return value
    if isinstance(value, np.ndarray):
        copy: Array = value if not value.flags.writeable and value.base is None else read_only(value.copy())
        return copy
    if type(value) is tuple and all([type(x) in _IMMUTABLE_TYPES for x in value]):
        return value
    if isinstance(value, Mapping):
        return {key: _freeze_value(x, depth + 1) for key, x in value.items()}
    if isinstance(value, (list, tuple, Iterator, KeysView, ValuesView)):
        return tuple([_freeze_value(x, depth + 1) for x in value]) if depth < _MAX_NESTING else value
    return value
