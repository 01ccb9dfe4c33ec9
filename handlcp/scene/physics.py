"""What a scene file says of friction and of effects asked for by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.errors import InputError
from handlcp.grasp import (
    AnisotropicCoulomb,
    ContactCompliance,
    Coulomb,
    FingerForceBound,
    Frictionless,
    GeometricStiffness,
    KnownForce,
    PrescribedForce,
    SoftFinger,
    SoftWrist,
    TorqueSaturation,
    TotalForceBound,
)
from handlcp.grasp.effects.needs import need_contact
from handlcp.grasp.entry import entry_of
from handlcp.scene.kinds import LAW_KEYS
from handlcp.scene.naming import by_finger, keyed, known
from handlcp.scene.schema import SoftWristTable

if TYPE_CHECKING:
    from handlcp.grasp import Effect, Friction
    from handlcp.scene.file import SceneFile

__all__ = ["effects_of", "is_by_finger", "keys_of", "law_of"]

LAW = {
    "SoftFinger.mu": "mu", "SoftFinger.mu_torsion": "mu_torsion_m",
    "SoftFinger.torsional_flexibility": "torsional_flexibility_rad_per_Nm",
    "AnisotropicCoulomb.mu_x": "mu_x", "AnisotropicCoulomb.mu_y": "mu_y",
    "AnisotropicCoulomb.along": "along",
}  # fmt: skip


def law_of(value: Any, key: str = "grasp.friction") -> Friction:
    """The friction law of a checked value, which is that of `key`."""
    if not isinstance(value, dict):
        return Frictionless() if value == "frictionless" else Coulomb(value)
    with keyed({argument: f"{key}.{name}" for argument, name in LAW.items()}):
        if "mu_x" in value:
            return AnisotropicCoulomb(value["mu_x"], value["mu_y"], value.get("along"))
        return SoftFinger(value["mu"], value["mu_torsion_m"], value.get("torsional_flexibility_rad_per_Nm", 0.0))


def is_by_finger(value: Any) -> bool:
    """Whether a friction is a table by finger; that of one law has the law's keys."""
    return isinstance(value, dict) and not any(needed <= set(value) for needed, _ in LAW_KEYS)


def effects_of(scene: SceneFile, fingers: Sequence[str]) -> list[Effect]:
    """What [effects] asks for; fingers (n,) names."""
    effects: list[Effect] = []
    if (bound := scene.effects.total_force_bound_N) is not None:
        effects.append(TotalForceBound(bound))
    if (bounds := scene.effects.finger_force_bound_N) is not None:
        key = "effects.finger_force_bound_N"
        bounds = by_finger(key, bounds, fingers, np.inf)
        if isinstance(bounds, list) and len(bounds) != len(fingers):
            raise InputError(key, f"a number, or {len(fingers)}, one for each contact", f"{len(bounds)}")
        effects.append(FingerForceBound(bounds))
    if scene.effects.torque_saturation:
        effects.append(TorqueSaturation())
    if scene.effects.geometric_stiffness:
        effects.append(GeometricStiffness())
    soft: Any = scene.effects.contact_compliance_m_per_N
    if isinstance(soft, dict):
        known("effects.contact_compliance_m_per_N", soft, fingers)
        soft = [np.diag(np.ones(3) * soft.get(f, 0.0)) for f in fingers]
    if soft is not None:
        effects.append(ContactCompliance(soft))
    if (wrist := scene.effects.soft_wrist) is not None:
        effects.append(_wrist(wrist))
    for i, whole in enumerate(scene.effects.prescribed_force):
        which = _number(whole.contact, f"effects.prescribed_force[{i}].contact", fingers)
        effects.append(PrescribedForce(which, whole.force_N))
    for i, some in enumerate(scene.effects.known_force):
        key, parts = f"effects.known_force[{i}]", (some.x_N, some.y_N, some.normal_N)
        which = _number(some.contact, f"{key}.contact", fingers)
        with keyed({"KnownForce.force": key}):
            effects.append(KnownForce(which, parts))
    return effects


def keys_of(effects: Sequence[Effect]) -> dict[str, str]:
    """By argument, such as "effects[1]", the key that the effect is from."""
    return {f"effects[{i}]": entry_of(type(e)).file_keys[0] for i, e in enumerate(effects)}


def _number(contact: Any, key: str, fingers: Sequence[str]) -> int:
    """Of a contact given by name or number."""
    if isinstance(contact, str):
        known(key, [contact], fingers)
        return fingers.index(contact)
    need_contact(key, contact, len(fingers))
    return int(contact)


def _wrist(table: SoftWristTable) -> SoftWrist:
    if table.flexibility is None:
        parts = (np.ones(3) * table.translation_m_per_N, np.ones(3) * table.rotation_rad_per_Nm)
        return SoftWrist(np.concatenate(parts), table.at_m)
    if given := sorted(table.model_fields_set & {"translation_m_per_N", "rotation_rad_per_Nm"}):
        key = f"effects.soft_wrist.{given[0]}"
        raise InputError(key, "none beside flexibility, the whole matrix", getattr(table, given[0]))
    with keyed({"SoftWrist.flexibility": "effects.soft_wrist.flexibility"}):
        return SoftWrist(table.flexibility, table.at_m)
