"""`Parameter`: a number that a grasp is made of; `Samples`: arrays of many grasps that differ in such numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, check_keys, read_only
from handlcp.errors import InputError, UnknownName
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint, difference_laws
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.grasp.model.request import GraspSpec


@dataclass
class Samples:
    """m samples of the grasp `spec`; what nobody has written to is as it is there.

    written : arrays (m, …) by name.
        friction (m, n) coefficients [-]; slides (m, k, 2) of the fingers' contacts along their tangents [m];
        springs (m, nv), (m, 1) without a hand, factors on the stiffness of the joints; pads (m, k) on the
        flexibility of the fingertips' pads; joints (m, nv), by how much they are off [rad, m];
        mass, load, squeeze (m, 1), factors on the object's weight, on what else loads it, on preloads and commands.
    remade : for parameters without such an array, what makes a sample's grasp from the grasp so far and a number, and
        that number for each sample (m,): a factor on nominal values, or whatever else the function takes it for.
    """

    spec: GraspSpec
    count: int
    written: dict[str, Array] = field(default_factory=dict)
    remade: list[tuple[Callable[[GraspSpec, float], GraspSpec], Array]] = field(default_factory=list)

    def array(self, name: str, nominal: Array | float, *shape: int) -> Array:
        """(m, *shape) to write to, full of the nominal values when it is first asked for."""
        if name not in self.written:
            self.written[name] = np.broadcast_to(nominal, (self.count, *shape)).astype(float)
        return self.written[name]

    def put(self, name: str, nominal: Array | float, count: int, at: tuple[int, ...], values: Array) -> None:
        """Write values (m,) into some of `count` entries, () all of them, in place of what was written there."""
        self.array(name, nominal, count)[:, list(at) if at else slice(None)] = values[:, None]

    def times(self, name: str, count: int, at: tuple[int, ...], factors: Array) -> None:
        """Multiply some of `count` factors, () all of them, by factors (m,): two parameters may write the same."""
        self.array(name, 1.0, count)[:, list(at) if at else slice(None)] *= factors[:, None]

    def get(self, name: str) -> Array | None:
        """What was written; None: nothing."""
        return self.written.get(name)


# ----------------------------------------------------------------
# What a parameter is: its name, shape and nominal values, and how a grasp changes with it.
#
# A parameter is one class in a file of this folder, found by its class: no other file needs a line for it. It says
#
#     what it is                          `shape`, `values`, `without`
#     the same grasp with other values    `varied`, `scaled`
#     what it changes in the laws         `change`, in closed form; unless it says so, by differences of the laws
#     what tables show of it              `shown`
#     what of it may be uncertain         `entries`, and in many samples at once `write`
#     what a designer can do with it      `shares`, by a share of it; `trials`, what may make a grasp hold
#
# It must say its `name`, without which it is not found, `shape`, `values` and `varied`.


class ParameterEntry(NamedTuple):
    """One number that may be uncertain on its own.

    name : for tables. at : which entry it is, such as a contact; () : all of them together. mean : nominal value, of
    which a standard deviation is a share; None: it is about 0, and has one in its own unit. least : the least possible
    value. unit : of its values, "×" for a factor. given : what was asked for it. argument : what that was called.
    """

    name: str
    at: tuple[int, ...]
    mean: float | None
    least: float
    unit: str
    given: Any
    argument: str


class Shown(NamedTuple):
    """A change that the table of derivatives shows. text : the change in words. ways : directions in the parameter's
    shape, by where they are; of several, the table shows the one that does most. slight : where it changes no force, it
    is left out.
    """

    text: str
    ways: Sequence[tuple[str, Array]]
    slight: bool = False


class Trial(NamedTuple):
    """A changed grasp that may hold. change : what was changed. value : of that. text : the change in words."""

    change: str
    value: float
    text: str
    spec: GraspSpec


# Why a grasp does not hold, and so what may help it
MISSING_BALANCE = "balance"  # no forces within friction and limits balance the load
MISSING_FORCES = "forces"  # such forces exist, but nothing creates them
MISSING_TORQUE = "torque"  # it holds, but joints are over their torque limits

SHARE_WORDS = "standard deviation, as a share"  # in `uncertain`
TABLE_SHARE = 0.1  # the share of a parameter by which tables change it

_KINDS: dict[tuple[str, str], type[Parameter]] = {}


class Parameter(ABC):
    """One parameter; subclasses override what they need.

    name : of `<quantity>_by_<name>`. order : place in lists. effort : how much it takes to change: 0 a command, 1 a
    surface, 2 a part, 3 a motor; advice tries the least first. step : [SI] that leaves central differences about as
    much rounding as truncation. together : whether a common change of all entries has a meaning. common : what the
    table of a path's end calls that change; "" : it does not show it. spread : what `reliability` calls it; "" : it
    does not vary there. uncertain : what varies there, and what a number for it is.
    """

    name: ClassVar[str] = ""
    order: ClassVar[int] = 1000
    effort: ClassVar[int] = 2
    step: ClassVar[float] = 1e-6
    together: ClassVar[bool] = False
    common: ClassVar[str] = ""
    spread: ClassVar[str] = ""
    uncertain: ClassVar[str] = ""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if vars(cls).get("name"):  # what has no name of its own is a base of others
            _KINDS[cls.__module__, cls.__qualname__] = cls

    # ---- what it is
    @abstractmethod
    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        """Of its entries; (0,) where a grasp has none."""

    @abstractmethod
    def values(self, spec: GraspSpec) -> Array:
        """Nominal values in its shape, SI; 0 where a size has no meaning, such as of a position."""

    def without(self, spec: GraspSpec) -> Bools:
        """(entries,) which are no number to change, such as the coefficient of a contact without friction; () none."""
        return np.zeros(0, bool)

    # ---- the same grasp with other values
    @abstractmethod
    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """The grasp with the k-th entry larger by a step; contacts, commands and offsets stay unless it says so. Of a
        hand's grasp change its mechanism, too: a loading that is followed asks that, not the specification.
        """

    def varied_all(self, spec: GraspSpec, steps: Array) -> GraspSpec:
        """The grasp with each entry larger by a step of its own, steps in its shape; `without` stay as they are."""
        keeps = self.without(spec)
        for k, step in enumerate(steps.reshape(-1)):
            if step != 0.0 and not (len(keeps) and keeps[k]):
                spec = self.varied(spec, k, float(step))
        return spec

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        """The grasp with all of it times a factor; None: there is nothing of it."""
        values = self.values(spec)
        return self.varied_all(spec, (factor - 1.0) * values) if values.any() else None

    # ---- what it changes in the laws of an answer
    def change(self, answer: LinearisationPoint) -> LawChange:
        """What each entry changes in the laws that an answer satisfies; here by central differences of these laws."""
        count = int(np.prod(self.shape(answer.spec)))
        return difference_laws(answer, count, self.step, lambda k, h: self.varied(answer.spec, k, h))

    # ---- what tables show of it
    def shown(self, answer: LinearisationPoint) -> Shown | None:
        """The change of it that the table of an answer's derivatives shows; None: none."""
        return None

    # ---- what of it may be uncertain
    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        """What varies for a number or distribution of all together, or for a mapping by the names of entries; here
        factors about 1. Raises InputError, UnknownName.
        """
        return factor_entries(self.spread, argument, given, spec.names, "a contact")

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        """Write the values (m,) of one entry into m samples; here they are factors on its nominal value, and each
        sample's grasp is made anew.
        """
        nominal = self.values(samples.spec).reshape(-1)
        some = np.zeros(len(nominal), bool)
        some[list(at) if at else slice(None)] = True

        def scale_nominal(spec: GraspSpec, factor: float) -> GraspSpec:
            steps = np.where(some, (factor - 1.0) * nominal, 0.0)
            return self.varied_all(spec, steps.reshape(self.shape(spec)))

        samples.remade.append((scale_nominal, values))

    # ---- what a designer can do with it
    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        """(the change in words, the changed grasp) of a share such as 0.1 more or less of it; None: it has none."""
        return iter(())

    def both_shares(self, spec: GraspSpec, share: float, *what: str) -> Iterator[tuple[str, GraspSpec | None]]:
        """`shares` of a share more and of one less; what : the words for both, with the share as {}."""
        for text, factor in zip(what, (1.0 + share, 1.0 - share), strict=True):
            yield text.format(words.format_percent(share)), self.scaled(spec, factor)

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """Changes that may make a grasp hold that does not, the smallest first; why : `MISSING_BALANCE`,
        `MISSING_FORCES`, `MISSING_TORQUE`.
        """
        return iter(())


def parameters() -> tuple[Parameter, ...]:
    """One of each kind, in order."""
    return tuple(sorted([kind() for kind in _KINDS.values()], key=lambda p: p.order))


def present_parameters(spec: GraspSpec) -> tuple[Parameter, ...]:
    """Those that a grasp has any entry of."""
    return tuple([p for p in parameters() if 0 not in p.shape(spec)])


def parameters_by_effort() -> tuple[Parameter, ...]:
    """All of `parameters`, those first that take the least effort to change."""
    return tuple(sorted(parameters(), key=lambda p: p.effort))


def find_parameter(name: str) -> Parameter:
    """The one of this name."""
    return next(p for p in parameters() if p.name == name)


def find_present_parameter(spec: GraspSpec, name: str) -> Parameter:
    """The one of this name, of those that a grasp has any entry of. Raises UnknownName."""
    known = {p.name: p for p in present_parameters(spec)}
    if name not in known:
        raise UnknownName("parameter", "a parameter", [str(name)], tuple(known))
    return known[name]


# ---------------------------------------------------------------- for subclasses
class ContactParameter(Parameter):
    """One entry for each contact, (n,)."""

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (spec.n,)


class JointParameter(Parameter):
    """One entry for each joint of a hand, (nv,)."""

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (0 if spec.mechanism is None else len(spec.mechanism.names),)


def factor_entries(of: str, argument: str, given: Any, names: Sequence[str], kind: str) -> list[ParameterEntry]:
    """Factors about 1, never negative: one for all entries, or for a mapping one for each that it names; kind : of
    these names, such as "a joint".
    """
    if not isinstance(given, Mapping):
        return [ParameterEntry(of, (), 1.0, 0.0, "×", given, argument)]
    found = []
    for name, own in check_keys(argument, given, names, kind).items():
        at = tuple([i for i, other in enumerate(names) if other == name])
        found.append(ParameterEntry(f"{of} {name}", at, 1.0, 0.0, "×", own, f"{argument}[{name!r}]"))
    return found


def given_by_name(argument: str, given: Any, names: Sequence[str], kind: str) -> dict[str, Any]:
    """What is given for each of these names, or for those that a mapping names; kind : as in `factor_entries`."""
    return check_keys(argument, given, names, kind) if isinstance(given, Mapping) else dict.fromkeys(names, given)


def require_hand(spec: GraspSpec, argument: str) -> Mechanism:
    """The hand of a grasp. Raises InputError for a grasp without one."""
    if spec.mechanism is None:
        raise InputError(argument, "the grasp of a hand, made by hand.at(q).grasp(...)", "a grasp without one")
    return spec.mechanism


def with_larger_entry(values: Array, k: int, step: float) -> Array:
    """A copy with its k-th entry larger."""
    out = values.copy()
    out.reshape(-1)[k] += step
    return read_only(out)


def round_two_digits(x: float) -> float:
    """Rounded as it is said."""
    return float(f"{x:.2g}")
