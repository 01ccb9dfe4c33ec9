"""What a key of a scene file may hold. Each kind says it in words, and those words are what its error expects."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError, WrapValidator
from pydantic_core import PydanticCustomError

__all__ = [
    "LAW_KEYS",
    "SHAPES",
    "Arms",
    "Compliance",
    "Expected",
    "Faces",
    "Finger",
    "FingerWeight",
    "Flexibility",
    "ForceBounds",
    "Friction",
    "FrictionByFinger",
    "Lengths",
    "Names",
    "NotNegative",
    "Number",
    "PadFlexibility",
    "PlanarVector",
    "Positive",
    "Posture",
    "Preload",
    "Radius",
    "Seed",
    "Size",
    "Softness",
    "Springs",
    "Stiffness",
    "Switch",
    "Text",
    "TorqueLimits",
    "TotalBound",
    "Vector",
    "WristFlexibility",
]


SHAPES = ("box", "sphere", "cylinder", "ellipsoid", "mesh")


class Expected(WrapValidator):
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


_Finite = Annotated[float, Field(allow_inf_nan=False)]
_Above0 = Annotated[float, Field(gt=0, allow_inf_nan=False)]
_From0 = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Above0OrInf = Annotated[float, Field(gt=0)]  # inf: rigid, or without limit
_From0OrInf = Annotated[float, Field(ge=0)]
_Three = Annotated[list[_Finite], Field(min_length=3, max_length=3)]
_ThreeAbove0 = Annotated[list[_Above0], Field(min_length=3, max_length=3)]
_ThreeFrom0 = Annotated[list[_From0], Field(min_length=3, max_length=3)]

Text = Annotated[str, Expected("a string")]
Names = Annotated[list[str], Field(min_length=1), Expected("a list of names")]
Switch = Annotated[bool, Expected("true or false")]
FingerWeight = Annotated[bool | Literal["torques"], Expected('true, false or "torques"')]

Number = Annotated[_Finite, Expected("a finite number")]
Positive = Annotated[_Above0, Expected("a number > 0")]
NotNegative = Annotated[_From0, Expected("a number ≥ 0")]
Vector = Annotated[_Three, Expected("three finite numbers")]
PlanarVector = Annotated[
    list[_Finite], Field(min_length=2, max_length=3), Expected("three finite numbers (two in a planar scene)")
]
Lengths = Annotated[_ThreeAbove0, Expected("three numbers > 0")]
Size = Annotated[_Above0 | _ThreeAbove0, Expected("a number > 0 or three of them")]

Stiffness = Annotated[
    _Above0OrInf | list[_Above0OrInf] | dict[str, _Above0OrInf],
    Expected("a number > 0 (inf: rigid), one for each joint, or a table by joint name"),
]
Springs = Annotated[
    _From0OrInf | list[_From0OrInf] | dict[str, _From0OrInf],
    Expected("a number ≥ 0 (inf: rigid), one for each, or a table by name"),
]
Arms = Annotated[
    Annotated[list[list[_Finite]], Field(min_length=1)] | Annotated[dict[str, dict[str, _Finite]], Field(min_length=1)],
    Expected("a table by name of tables by joint name, or a list with one number for each joint for each"),
]
TorqueLimits = Annotated[
    _Above0OrInf | list[_Above0OrInf] | dict[str, _Above0OrInf],
    Expected("a number > 0 (inf: no limit), one for each joint, or a table by joint name"),
]
PadFlexibility = Annotated[
    _From0 | _ThreeFrom0 | dict[str, _From0 | _ThreeFrom0],
    Expected("a number ≥ 0, three of them, or a table by fingertip"),
]
Radius = Annotated[_Above0 | dict[str, _Above0], Expected("a number > 0, or a table by fingertip")]
Posture = Annotated[
    list[_Finite] | dict[str, _Finite], Expected("one finite number for each joint, or a table by joint name")
]
LAW_KEYS = (  # of a friction that is more than a coefficient: needed, and allowed beside
    (frozenset({"mu", "mu_torsion_m"}), frozenset({"torsional_flexibility_rad_per_Nm"})),
    (frozenset({"mu_x", "mu_y"}), frozenset({"along"})),
)


def _law_table(value: dict[str, Any]) -> dict[str, Any]:
    """A soft finger's table, or that of an anisotropic friction."""
    if not any(needed <= set(value) <= needed | more for needed, more in LAW_KEYS):
        raise ValueError("keys of no friction law")
    return value


def _fingers(value: dict[str, Any]) -> dict[str, Any]:
    """A table by finger; no finger is called like a key of a law, nearly right tables are."""
    if any(key in needed | more for needed, more in LAW_KEYS for key in value):
        raise ValueError("keys of a friction law")
    return value


_LawTable = Annotated[dict[str, _Finite | _Three], AfterValidator(_law_table)]
_Law = _From0 | Literal["frictionless"] | _LawTable
_LAW_WORDS = (
    'a coefficient ≥ 0, "frictionless", {mu, mu_torsion_m} (also torsional_flexibility_rad_per_Nm) for a soft finger, '
    "or {mu_x, mu_y} (also along)"
)
Friction = Annotated[_Law, Expected(_LAW_WORDS)]
FrictionByFinger = Annotated[
    _Law | Annotated[dict[str, _Law], AfterValidator(_fingers)],
    Expected(f"{_LAW_WORDS}, or a table of these by finger"),
]
Preload = Annotated[
    _Finite | list[_Finite] | dict[str, _Finite],
    Expected("a finite number, one for each contact, or a table by finger"),
]
Flexibility = Annotated[
    _From0 | _ThreeFrom0 | list[list[_Finite]] | list[list[list[_Finite]]],
    Expected("a number ≥ 0, three of them, (n, 3, 3) blocks or a (3n, 3n) matrix"),
]
Compliance = Annotated[
    _From0 | _ThreeFrom0 | dict[str, _From0 | _ThreeFrom0],
    Expected("a number ≥ 0, three of them, or a table by finger"),
]
ForceBounds = Annotated[
    _Above0OrInf | list[_Above0OrInf] | dict[str, _Above0OrInf],
    Expected("a number > 0 (inf: no bound), one for each contact, or a table by finger"),
]
TotalBound = Annotated[_Above0OrInf, Expected("a number > 0 (inf: no bound)")]
Softness = Annotated[_From0 | _ThreeFrom0, Expected("a number ≥ 0 or three of them")]
_Six = Annotated[list[_Finite], Field(min_length=6, max_length=6)]
WristFlexibility = Annotated[
    Annotated[list[_Six], Field(min_length=6, max_length=6)], Expected("six rows of six finite numbers")
]
Finger = Annotated[Annotated[int, Field(ge=0)] | str, Expected("a finger's name or a contact's number, counted from 0")]
Faces = Annotated[Annotated[int, Field(ge=3)] | Literal["cone"], Expected('an integer ≥ 3 or "cone"')]
Seed = Annotated[int, Field(ge=0), Expected("an integer ≥ 0")]
