"""Motors in scene files: of every joint, or by name; refusals that name the key."""

from __future__ import annotations

import pathlib

import pytest

from handlcp import Motor
from handlcp.errors import InputError
from handlcp.hand import HandGrasp
from handlcp.scene import read

ROOT = pathlib.Path(__file__).parents[2]
CUBE = (ROOT / "examples" / "cube_three_fingers.toml").read_text(encoding="utf-8")
MOTOR = "continuous_Nm = 0.008\npeak_Nm = 0.014\nreduction = 50\nefficiency = 0.7\nthermal_time_s = 20.0\n"


def scene(table: str) -> str:
    return CUBE.replace("[object]", f"{table}\n[object]", 1)


def test_one_motor_is_that_of_every_joint_and_motors_by_name_are_those_of_theirs() -> None:
    every = read(scene(f"[hand.motor]\n{MOTOR}")).build()
    named = read(scene(f"[hand.motors.finger_1_distal]\n{MOTOR}holding_Nm = inf\n")).build()
    assert isinstance(every, HandGrasp)
    assert isinstance(named, HandGrasp)
    motor = Motor(0.008, 0.014, reduction=50.0, efficiency=0.7, thermal_time=20.0)
    drives = every.state.hand.torques.drives
    assert drives is not None
    assert drives.motors == (motor,) * 6
    assert named.state.hand.torque_limits.tolist() == [0.8, float("inf"), 0.8, 0.4, 0.8, 0.4]
    assert every.check().word == "OVER LIMIT"


def test_a_urdf_needs_no_other_stiffness_where_its_motor_says_it() -> None:
    table = f"[hand.motor]\n{MOTOR}stiffness_Nm_per_rad = 6.0\n"
    text = scene(table).replace(
        'name = "three_finger"\njoint_stiffness_Nm_per_rad = 6.0', f'urdf = "{ROOT}/urdf/three_finger.urdf"'
    )
    built = read(text).build()
    assert isinstance(built, HandGrasp)
    assert built.state.hand.joint_stiffness[0, 0] == 6.0


@pytest.mark.parametrize(
    ("table", "key"),
    [
        (f"[hand.motor]\n{MOTOR}".replace("0.014", "0.001"), "hand.motor.peak_Nm"),
        (f"[hand.motors.finger_1_distal]\n{MOTOR}".replace("0.7", "1.7"), "hand.motors.finger_1_distal.efficiency"),
        (f"[hand.motors.finger_9_distal]\n{MOTOR}", "hand.motors"),
        (f"[hand.motor]\n{MOTOR}\n[hand.motors.finger_1_distal]\n{MOTOR}", "hand.motors"),
        ("[hand.motor]\npeak_Nm = 1.0\n", "hand.motor.continuous_Nm"),
        (f"[hand.motor]\n{MOTOR}gear = 3\n", "hand.motor.gear"),
    ],
)
def test_what_is_wrong_is_named_by_its_key(table: str, key: str) -> None:
    with pytest.raises(InputError) as refused:
        read(scene(table)).build()
    assert refused.value.argument == key
