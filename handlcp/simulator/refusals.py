"""What of a grasp MuJoCo cannot have exactly: refused by name, not written as something similar."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from handlcp.errors import InputError, Unsupported
from handlcp.grasp import Coulomb, Frictionless, Grasp, SoftFinger, TorqueSaturation
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.hand import HandGrasp
from handlcp.hand.mechanism import HandMechanism, finger_flexibility

# ---------------------------------------------------------------- MuJoCo is an extra: imported when it is needed.


def need_mujoco() -> ModuleType:
    """The package mujoco. Raises Unsupported where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise Unsupported("no simulation without MuJoCo: pip install handlcp[mujoco]") from None
    module: ModuleType = mujoco
    return module


# ----------------------------------------------------------------

# MuJoCo writes balance in the deformed posture: geometric stiffness is always in it
_KNOWN = (JointOffset, FingerWeight, GeometricStiffness, TorqueSaturation)
_SAME = 1e-9  # of the largest entry: flexibilities that differ by less are one
_TOUCHING = 1e-9  # [m] offsets that differ by less from the gaps are those


def check_writable(grasp: HandGrasp) -> None:
    """Whether each part of a grasp of `of_a_hand` can be written. Raises Unsupported."""
    spec = grasp.spec
    for effect in spec.effects:
        if not isinstance(effect, _KNOWN):
            raise Unsupported(f"MuJoCo has no exact counterpart of {effect.title}")
    for name, contact in zip(spec.names, spec.contacts, strict=True):
        friction_words(name, contact.friction)
    k = spec.of_fingers
    if abs(spec.offset[:k] - grasp.mechanism.stand_off).max(initial=0.0) > _TOUCHING:
        raise Unsupported(
            "a preload or an offset of the tips, which no joint makes, cannot be written: command the joints (squeeze, "
            "grip_force, joint_offset)"
        )
    alone = spec.fingers_alone().mechanism
    assert isinstance(alone, HandMechanism)
    own, flexibility = finger_flexibility(alone), spec.flexibility[: 3 * k, : 3 * k]
    if abs(own - flexibility).max() > _SAME * abs(own).max():
        raise Unsupported("a flexibility other than that of the hand's joints and pads cannot be written")
    if spec.offset[k:, :2].any():
        raise Unsupported("an offset of the environment along its tangents cannot be written")


def of_a_hand(grasp: Any) -> HandGrasp:
    """Raises InputError for what is no grasp, Unsupported for contacts without a hand or without geometry."""
    if not isinstance(grasp, Grasp):
        raise InputError("grasp", "a grasp made by hand.at(q).grasp(obj)", repr(grasp)[:80])
    if not isinstance(grasp, HandGrasp):
        raise Unsupported("contacts without a hand cannot be simulated: MuJoCo needs a hand and an object")
    if grasp.target is None:
        raise Unsupported("contacts given one by one cannot be simulated: pass an object, whose geometry is known")
    if grasp.target.triangles is not None:
        raise Unsupported("a mesh that is not convex cannot be simulated: MuJoCo fills its hull")
    return grasp


def friction_words(name: str, law: Any) -> dict[str, Any]:
    """Attributes of a contact pair with this friction law; name : of the contact. Raises Unsupported."""
    if isinstance(law, SoftFinger):
        if law.torsional_flexibility:
            raise Unsupported(f"the torsional flexibility of soft finger {name!r} cannot be written")
        if law.lever > 0.0:
            return {"condim": "4", "friction": [law.mu, law.mu, law.mu_torsion, 1e-4, 1e-4]}
    elif not isinstance(law, (Coulomb, Frictionless)):
        raise Unsupported(
            f"friction {law!r} of {name!r} cannot be written: MuJoCo chooses the tangents of a contact itself"
        )
    if law.mu == 0.0:
        return {"condim": "1"}
    return {"condim": "3", "friction": [law.mu, law.mu, 1e-4, 1e-4, 1e-4]}
