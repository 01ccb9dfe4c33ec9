"""What a scene file says of friction and of effects asked for by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from handlcp.grasp.effects import Effect
from handlcp.grasp.friction import FrictionLaw, Frictionless, as_law, friction_laws
from handlcp.scene.effects_table import asked, kinds_with_keys
from handlcp.scene.naming import keyed
from handlcp.scene.table import Table


def law_of(value: Any, key: str = "grasp.friction") -> FrictionLaw:
    """The friction law of a checked value, which is that of `key`."""
    if not isinstance(value, dict):
        return Frictionless() if value == "frictionless" else as_law(value, key)
    law = next(law for law in _laws_with_keys() if set(law.file_keys[0]) <= set(value))
    keys = law.file_keys[0] | law.file_keys[1]
    with keyed({f"{law.__name__}.{argument}": f"{key}.{name}" for name, argument in keys.items()}):
        return law.from_file(value)


def is_by_finger(value: Any) -> bool:
    """Whether a friction is a table by finger; that of one law has the law's keys."""
    return isinstance(value, dict) and not any(set(law.file_keys[0]) <= set(value) for law in _laws_with_keys())


def effects_of(table: Table, fingers: Sequence[str]) -> tuple[list[Effect], dict[str, str]]:
    """What [effects] asks for; and by argument, such as "effects[1]", the key that it is from. fingers : (n,) names."""
    effects: list[Effect] = []
    keys: dict[str, str] = {}
    said = asked(table)
    for kind, key in kinds_with_keys():
        if key.name not in said:
            continue
        path = f"effects.{key.name}"
        for effect in kind.from_file(said[key.name], path, tuple(fingers)):
            keys[f"effects[{len(effects)}]"] = path
            effects.append(effect)
    return effects, keys


def _laws_with_keys() -> list[type[FrictionLaw]]:
    return [law for law in friction_laws() if law.file_keys[0]]
