"""What `import handlcp as hl` offers: each name with its signature, each class with its public methods and properties.

A signature has the names, kinds and defaults of arguments, and no annotations, which may name what is inside. The call
of a class that the package alone makes, such as an answer, is its own affair and left out. What a class has from
another public class is listed there alone.
"""

from __future__ import annotations

import dataclasses
import enum
import inspect
from typing import Any

import handlcp as hl

__all__ = ["DATA", "public_names"]

VALUE = "value"  # an attribute, a property or a field; which of them it is makes no difference to a caller

# Attributes that objects get when they are made, as the docstrings of their classes have them
DATA = {
    "Hand": "name joint_names nv fingertips lower upper neutral torque_limits joint_friction kinematics tips stiffness "
    "pads torques",
    "HandState": "hand q tip_positions tip_rotations jacobian flexibility",
    "LCP": "M q free",
    "GraspProblem": "eliminated rcond contact effects",
    "Found": "tried why",
    "Solutions": "held",
    "Study": "names columns sweep",
}

# Beside classes with `to_dict`, those that users are given and do not make
GIVEN = {
    "Candidate", "Chance", "Doubt", "Flexibility", "GraspProblem", "GraspUpdate", "Hand", "HandDescription",
    "HandGrasp", "HandState", "Influence", "Kink", "LCPSolution", "MeasuredStiffness", "Reason", "Residuals", "Study",
    "Uniqueness",
}  # fmt: skip


def public_names() -> dict[str, Any]:
    """{name: the signature of a function, {member: signature or VALUE} of a class}."""
    return {name: describe(getattr(hl, name)) for name in sorted(hl.__all__)}


def describe(thing: Any) -> Any:
    """One public name."""
    if inspect.isclass(thing):
        return describe_class(thing)
    return signature(thing) if callable(thing) else VALUE


def describe_class(kind: type) -> dict[str, str]:
    """Its members by name; "()" is its call, "bases" are the public classes that it is one of."""
    above = [base for base in kind.__mro__[1:] if is_public(base)]
    own = {"bases": ", ".join(base.__name__ for base in above)} if above else {}
    if issubclass(kind, enum.Enum):
        return own | dict.fromkeys((member.name for member in kind), VALUE)
    if not hasattr(kind, "to_dict") and kind.__name__ not in GIVEN:
        own["()"] = signature(kind)
    inherited: dict[str, str] = {}
    for base in reversed(above):
        inherited |= members(base)
    return own | {name: said for name, said in members(kind).items() if inherited.get(name) != said}


def is_public(kind: type) -> bool:
    """Whether a class is one of the public names, or a base of effects or of friction laws of one's own."""
    name = kind.__name__
    return getattr(hl, name, None) is kind if name in hl.__all__ else kind in (hl.grasp.Effect, hl.grasp.FrictionLaw)


def members(kind: type) -> dict[str, str]:
    """{name: signature or VALUE} of what has no underscore and comes from the package: methods, properties, fields.

    A constant of a class is none of them.
    """
    found = dict.fromkeys(DATA.get(kind.__name__, "").split(), VALUE)
    if dataclasses.is_dataclass(kind):
        found |= {field.name: VALUE for field in dataclasses.fields(kind) if not field.name.startswith("_")}
    for name in dir(kind):
        owner = next((base for base in kind.__mro__ if name in vars(base)), object)
        if name.startswith("_") or owner.__module__.partition(".")[0] != "handlcp":
            continue
        member = vars(owner)[name]
        if isinstance(member, classmethod):
            found[name] = f"classmethod {signature(member.__func__, without_first=True)}"
        elif isinstance(member, staticmethod):
            found[name] = f"staticmethod {signature(member.__func__)}"
        elif inspect.isfunction(member):
            found[name] = signature(member, without_first=True)
        elif hasattr(type(member), "__get__"):  # a property, or what a field of a tuple or a slot is made of
            found[name] = VALUE
    return dict(sorted(found.items()))


def signature(function: Any, without_first: bool = False) -> str:
    """Such as "(grasp, wrench=None, *, faces='cone')". without_first : leave out self, or cls."""
    try:
        parameters = list(inspect.signature(function).parameters.values())[without_first:]
    except ValueError:  # of a class that is written in C
        return "(…)"
    plain = [p.replace(annotation=p.empty, default=p.default if p.default is p.empty else Shown(p.default))
             for p in parameters]  # fmt: skip
    return str(inspect.Signature(plain))


class Shown:
    """A default value as a signature shows it: plain data as they are, "…" for anything else."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __repr__(self) -> str:
        if isinstance(self.value, (tuple, list)):
            return f"[{', '.join(repr(Shown(v)) for v in self.value)}]"
        return repr(self.value) if isinstance(self.value, (bool, int, float, str, type(None))) else "…"
