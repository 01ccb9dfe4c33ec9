"""`FileTable`: what a key of a file may hold, in words that its error expects."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    ValidationInfo,
    WrapValidator,
)
from pydantic_core import PydanticCustomError

from handlcp.actuation.transmission import PRETENSIONS, TENSION_LIMITS
from handlcp.check import NumbersByName, check_array, check_integer, check_number, describe_number
from handlcp.contact.friction import friction_laws
from handlcp.errors import InputError, shorten_repr
from handlcp.geometry.shape import read_lengths
from handlcp.hand.squeeze import BY_TIP, JOINT_OFFSETS, read_by_tip
from handlcp.hand.torque_closing import CLOSING_TORQUES
from handlcp.robot.joint import JOINT_FRICTION, TORQUE_LIMITS

# ----------------------------------------------------------------
# What the tables of a scene file are made of, for pydantic: refusals in words, and tables known only when read.


_UNIT = re.compile(r"_(kg_per_m3|m_per_s2|m_per_N|N_per_Nm|N_per_m|Nm_per_rad|rad_per_Nm|kg|rad|Nm|N|m|s)$")


def argument_of(key: str) -> str:
    """The argument of the package's functions that a key says: its name without the unit, "squeeze" for "squeeze_m"."""
    return _UNIT.sub("", key)


class FileTable(BaseModel):
    """A table of a scene file: no keys but its own, no conversions but integers to numbers.

    A key is the argument that its value is passed as, followed by its unit.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @classmethod
    def keys_by_argument(cls, path: str, owner: str = "") -> dict[str, str]:
        """The keys' full names by argument, for `translate_arguments`.

        path : of the table in its file; "": the top.
        owner : what messages put before the arguments, such as "Motor.".
        """
        start = f"{path}." if path else ""
        return {f"{owner}{argument_of(key)}": f"{start}{key}" for key in cls.model_fields}

    def arguments(self, *left_out: str) -> dict[str, Any]:
        """The table's values by argument, without None and without the arguments `left_out`."""
        said = {argument_of(key): getattr(self, key) for key in type(self).model_fields}
        return {name: value for name, value in said.items() if value is not None and name not in left_out}


class ExpectedWords(WrapValidator):
    """Any refusal inside becomes one: `words`."""

    words: str

    def __init__(self, words: str) -> None:
        def check(value: Any, inner: Any) -> Any:
            try:
                return inner(value)
            except ValidationError:
                raise PydanticCustomError("expected", "{words}", {"words": words}) from None

        super().__init__(check)
        object.__setattr__(self, "words", words)


class Checked(PlainValidator):
    """The check that a function of the package makes of an argument, made when a file is read: the words of its errors
    are those that a call in Python gets.

    words : what the key holds, for lists of keys.
    check : from the argument's name and the value, raises InputError; what it returns takes the value's place where
        that is a number or a list.
    """

    words: str

    def __init__(self, words: str, check: Callable[[str, Any], Any]) -> None:
        def read(value: Any, info: ValidationInfo) -> Any:
            argument = argument_of(info.field_name or "")
            if _holds_flag(value):  # which Python takes for a number in a list
                raise InputError(argument, words, shorten_repr(value))
            made = check(argument, value)
            return made if isinstance(made, (int, float, list)) else value

        super().__init__(read)
        object.__setattr__(self, "words", words)


def _holds_flag(value: Any) -> bool:
    """Whether true or false stands in the value, at whatever depth."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return isinstance(value, bool) or any(map(_holds_flag, inner))


class DeferredTable(PlainValidator):
    """A table whose keys depend on what is imported by the time a file is read.

    model : returns it.
    """

    model: Callable[[], type[FileTable]]

    def __init__(self, model: Callable[[], type[FileTable]]) -> None:
        def check(value: Any) -> FileTable:
            return model().model_validate(value)

        super().__init__(check)
        object.__setattr__(self, "model", model)


# ----------------------------------------------------------------

SHAPES = ("box", "sphere", "cylinder", "ellipsoid", "mesh", "ycb")

_Finite = Annotated[float, Field(allow_inf_nan=False)]
_Above0 = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_From0 = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Three = Annotated[list[_Finite], Field(min_length=3, max_length=3)]
_ThreeFrom0 = Annotated[list[_From0], Field(min_length=3, max_length=3)]
_Diagonal = _From0 | _ThreeFrom0


def _number(**bounds: Any) -> Checked:
    return Checked(describe_number(**bounds), partial(check_number, **bounds))


def _vector(words: str, *shapes: tuple[int, ...]) -> Checked:
    def check(argument: str, value: Any) -> Any:
        try:
            return check_array(argument, value, *shapes).tolist()
        except InputError as error:
            raise InputError(argument, words, error.got) from None

    return Checked(words, check)


def _by_name(numbers: NumbersByName) -> Checked:
    return Checked(numbers.expected, numbers.read)


Text = Annotated[str, ExpectedWords("a string")]
Names = Annotated[list[str], Field(min_length=1), ExpectedWords("a list of names")]
Links = Annotated[
    Literal["tips", "all"] | Annotated[list[str], Field(min_length=1)],
    ExpectedWords('"tips", "all" or a list of names'),
]
Switch = Annotated[bool, ExpectedWords("true or false")]
FingerWeight = Annotated[bool | Literal["torques"], ExpectedWords('true, false or "torques"')]

Number = Annotated[float, _number()]
Positive = Annotated[float, _number(above=0.0)]
PositiveOrInf = Annotated[float, _number(above=0.0, finite=False)]
NotNegative = Annotated[float, _number(minimum=0.0)]
Vector = Annotated[list[float], _vector("three finite numbers", (3,))]
PlanarVector = Annotated[list[float], _vector("three finite numbers (two in a planar scene)", (3,), (2,))]
Lengths = Annotated[
    list[float],
    Checked("three numbers > 0", lambda argument, value: read_lengths(argument, check_array(argument, value, (3,)))),
]
Size = Annotated[float | list[float], Checked("a number > 0 or three of them", read_lengths)]

# Of each joint, tendon or fingertip: one number for all, as many as there are, or a table by name
PerName = float | list[float] | dict[str, float]
Stiffness = Annotated[PerName, _by_name(NumbersByName("joint", above=0.0, finite=False))]
TendonStiffness = Annotated[PerName, _by_name(NumbersByName("tendon", above=0.0, finite=False))]
ActuatorStiffness = Annotated[PerName, _by_name(NumbersByName("actuator", above=0.0, finite=False))]
Springs = Annotated[PerName, _by_name(NumbersByName("joint", minimum=0.0, finite=False))]
TorqueLimits = Annotated[PerName, _by_name(TORQUE_LIMITS)]
JointFriction = Annotated[PerName, _by_name(JOINT_FRICTION)]
Pretension = Annotated[PerName, _by_name(PRETENSIONS)]
TensionLimits = Annotated[PerName, _by_name(TENSION_LIMITS)]
ClosingTorque = Annotated[PerName, _by_name(CLOSING_TORQUES)]
Posture = Annotated[list[float] | dict[str, float], _by_name(JOINT_OFFSETS)]
ByTip = Annotated[PerName, Checked(BY_TIP.expected, read_by_tip)]
Preload = Annotated[PerName, _by_name(NumbersByName("contact"))]

Arms = Annotated[
    Annotated[list[list[_Finite]], Field(min_length=1)] | Annotated[dict[str, dict[str, _Finite]], Field(min_length=1)],
    ExpectedWords("a table by name of tables by joint name, or a list with one number for each joint for each"),
]
PadFlexibility = Annotated[
    _Diagonal | dict[str, _Diagonal], ExpectedWords("a number ≥ 0, three of them, or a table by fingertip or link")
]
Radius = Annotated[_Above0 | dict[str, _Above0], ExpectedWords("a number > 0, or a table by fingertip")]


def _check_law_table(value: dict[str, Any]) -> dict[str, Any]:
    """The table of a friction law with keys of its own."""
    if not any(set(needed) <= set(value) <= {*needed, *more} for needed, more in _law_keys()):
        raise ValueError("keys of no friction law")
    return value


def _check_finger_table(value: dict[str, Any]) -> dict[str, Any]:
    """A table by finger; no finger is called like a key of a law, nearly right tables are."""
    if any(key in needed or key in more for needed, more in _law_keys() for key in value):
        raise ValueError("keys of a friction law")
    return value


def _law_keys() -> list[tuple[dict[str, str], dict[str, str]]]:
    return [law.file_keys for law in friction_laws() if law.file_keys[0]]


_LawTable = Annotated[dict[str, _Finite | _Three], AfterValidator(_check_law_table)]
_Law = _From0 | Literal["frictionless"] | _LawTable


def _describe_laws() -> str:
    """How to write each friction law, in words."""
    words = ['a coefficient ≥ 0, "frictionless"']
    for law in friction_laws():
        needed, more = law.file_keys
        if needed:
            also = f" (also {', '.join(more)})" if more else ""
            words.append(f"{{{', '.join(needed)}}}{also} for {law.__name__}")
    return f"{', '.join(words[:-1])} or {words[-1]}"


_LAW_WORDS = _describe_laws()
Friction = Annotated[_Law, ExpectedWords(_LAW_WORDS)]
_ByFinger = Annotated[dict[str, _Law], AfterValidator(_check_finger_table)]
FrictionByFinger = Annotated[_Law | _ByFinger, ExpectedWords(f"{_LAW_WORDS}, or a table of these by finger")]
Grips = Annotated[
    _From0 | list[list[_From0]] | dict[str, _From0 | dict[str, _From0]],
    ExpectedWords("a number ≥ 0, or a table by tendon of numbers or of tables by joint name"),
]
Flexibility = Annotated[
    _Diagonal | list[list[_Finite]] | list[list[list[_Finite]]],
    ExpectedWords("a number ≥ 0, three of them, (n, 3, 3) blocks or a (3n, 3n) matrix"),
]
Softness = Annotated[_Diagonal, ExpectedWords("a number ≥ 0 or three of them")]
Faces = Annotated[Annotated[int, Field(ge=3)] | Literal["cone"], ExpectedWords('an integer ≥ 3 or "cone"')]
Seed = Annotated[int, Checked("an integer ≥ 0", partial(check_integer, least=0))]
Orientations = Annotated[Literal[6, "any"], ExpectedWords('6 or "any"')]
Kind = Annotated[Literal["pinch", "power", "any"], ExpectedWords('"pinch", "power" or "any"')]
Count = Annotated[int, Checked("an integer ≥ 1", partial(check_integer, least=1))]
