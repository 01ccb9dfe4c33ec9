"""What [hand] says of springs, tendons, synergies and motors."""

from __future__ import annotations

from typing import Any

from handlcp.check import array
from handlcp.errors import keyed
from handlcp.hand import Motor, Synergies, Tendons
from handlcp.scene.schema import HandTable, MotorTable, TendonMotorTable, TendonsTable

# Arguments of `Hand.from_urdf`, and the keys that they come from
HAND = {
    "source": "hand.urdf",
    "path": "hand.urdf",
    "name": "hand.name",
    "base": "hand.base",
    "fingertips": "hand.fingertips",
    "joint_stiffness": "hand.joint_stiffness_Nm_per_rad",
    "pad_flexibility": "hand.pad_flexibility_m_per_N",
    "Tendons.moment_arms": "hand.tendons.moment_arms_m",
    "Tendons.stiffness": "hand.tendons.stiffness_N_per_m",
    "Tendons.passive": "hand.tendons.passive_Nm_per_rad",
    "Tendons.pretension": "hand.tendons.pretension_N",
    "Tendons.limits": "hand.tendons.limits_N",
    "Tendons.friction": "hand.tendons.friction",
    "Tendons.motors": "hand.tendons.motors",
    "Synergies.S": "hand.synergies.columns",
    "Synergies.stiffness": "hand.synergies.stiffness_Nm_per_rad",
    "Synergies.joint_stiffness": "hand.synergies.joint_stiffness_Nm_per_rad",
    "torque_limits": "hand.torque_limits_Nm",
    "tip_radius": "hand.tip_radius_m",
    "package_dirs": "hand.package_dirs",
    "motors": "hand.motors",
    "joint_friction": "hand.joint_friction_Nm",
}
_ALIKE = {
    "continuous": "continuous_Nm",
    "peak": "peak_Nm",
    "efficiency": "efficiency",
    "thermal_time": "thermal_time_s",
}
_MOTOR = _ALIKE | {
    "holding": "holding_Nm",
    "friction": "friction_Nm",
    "reduction": "reduction",
    "stiffness": "stiffness_Nm_per_rad",
}
_OF_TENDON = _ALIKE | {"holding": "holding_N", "friction": "friction_N", "reduction": "reduction_N_per_Nm"}


def motors(table: HandTable | TendonsTable, path: str = "hand") -> Any:
    """What [hand] or [hand.tendons] says of motors; None: nothing."""
    if table.motor is not None:
        return _motor(table.motor, f"{path}.motor")
    if table.motors is None:
        return None
    return {name: _motor(motor, f"{path}.motors.{name}") for name, motor in table.motors.items()}


def _motor(table: MotorTable | TendonMotorTable, path: str) -> Motor:
    own = _MOTOR if isinstance(table, MotorTable) else _OF_TENDON
    with keyed({f"Motor.{argument}": f"{path}.{key}" for argument, key in own.items()}):
        return Motor(**{argument: getattr(table, key) for argument, key in own.items()})


def springs(table: HandTable) -> Any:
    """What [hand] says of stiffness."""
    with keyed(HAND):
        if (t := table.tendons) is not None:
            forces = t.pretension_N, t.limits_N, t.friction, motors(t, "hand.tendons")
            return Tendons(t.moment_arms_m, t.stiffness_N_per_m, t.passive_Nm_per_rad, *forces)
        if (s := table.synergies) is not None:
            columns: Any = s.columns
            if not isinstance(columns, dict):  # written one by one
                columns = array("Synergies.S", columns, (-1, -1)).T
            return Synergies(columns, s.stiffness_Nm_per_rad, s.joint_stiffness_Nm_per_rad)
    return table.joint_stiffness_Nm_per_rad
