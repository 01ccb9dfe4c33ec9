"""What `to_mujoco` writes: the same kinematics, weights, springs and loads, and by name what it cannot write."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, Unsupported
from handlcp.simulator import SimulatorSettings, simulate
from tests.mujoco.case import started
from tests.mujoco.cases import scene, three, two

mujoco = pytest.importorskip("mujoco")

BOX = hl.Box(0.05, [0, 0, 0.08], mass=0.05)


@pytest.mark.parametrize(
    "make", [three, lambda: scene("allegro_pinch", 0.001), lambda: scene("psyonic_grasp", 0.001)],
    ids=["three_finger", "allegro", "psyonic"],
)  # fmt: skip
def test_fingertips_are_where_the_hand_has_them(make):
    grasp = make()
    model, data, _ = started(grasp, 1.0, 1.0)
    named = dict(zip(grasp.state.hand.fingertips, grasp.state.tip_positions, strict=True))
    for tip in grasp.fingertips:
        assert abs(data.xpos[model.body(f"{tip} pad").id] - named[tip]).max() < 1e-12


def test_links_weigh_what_the_urdf_says_and_only_where_that_was_asked_for():
    heavy, light = three(finger_weight=True), three()
    for grasp, expected in ((heavy, heavy.gravity_torque), (light, np.zeros(6))):
        model, data, _ = started(grasp, 1.0, 1.0)
        held = data.qfrc_bias - data.qfrc_gravcomp  # gravity compensation counts as a passive force
        dofs = [model.joint(name).dofadr[0] for name in grasp.state.hand.joint_names]
        assert held[dofs] == pytest.approx(expected, abs=1e-9)


def test_springs_make_the_stiffness_of_tendons():
    R = {"pull": {"finger_1_proximal": 0.01, "finger_1_distal": 0.008}}
    hand = {"torque_limits": np.inf}
    grasp = three(K=hl.Tendons(R, 2e4, 4.0, pretension=10.0), hand=hand)
    model, data, _ = started(grasp, load=1.0)
    dofs = [model.joint(name).dofadr[0] for name in grasp.state.hand.joint_names]
    at = [model.joint(name).qposadr[0] for name in grasp.state.hand.joint_names]
    K = np.zeros((6, 6))
    for j, place in enumerate(at):
        data.qpos[place] += 1e-3
        mujoco.mj_forward(model, data)
        K[:, j] = -data.qfrc_actuator[dofs] / 1e-3
        data.qpos[place] -= 1e-3
    assert pytest.approx(grasp.state.hand.joint_stiffness, abs=1e-9) == K


def test_a_mimic_joint_follows():
    grasp = scene("psyonic_grasp", 0.001)
    end = simulate(grasp, order=("squeeze",), seconds=0.3)
    assert end.held
    model, data, state = started(grasp, 1.0, 1.0)
    mujoco.mj_step(model, data, 500)
    followed, follows = (
        data.joint(f"Left_index_{q}").qpos[0] - state.positions[f"Left_index_{q}"] for q in ("q1", "q2")
    )
    assert abs(followed) > 5e-4
    assert follows == pytest.approx(1.05851325 * followed, abs=1e-4)


def test_nothing_but_the_object_and_the_hand_s_own_weight_is_pulled_down():
    """Without squeeze and load nothing moves, whatever masses make it quasi-static."""
    model, data, _ = started(three())
    mujoco.mj_step(model, data, 2000)
    assert abs(data.qvel).max() < 1e-6


def test_a_load_acts_at_the_reference_point_of_the_object():
    """Balance: the contacts' forces are the load's opposite, and so are their moments about the reference."""
    grasp = three(wrench=[0.1, 0.2, -0.1, 0.002, 0.001, -0.002])
    end = simulate(grasp, seconds=0.6)
    assert -end.forces_world.sum(axis=0) == pytest.approx([0.1, 0.2, -0.1 - 0.05 * 9.81], abs=1e-4)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: three().replace(flexibility=1e-4), "a flexibility other"),
        (lambda: three(law=hl.AnisotropicCoulomb(0.5, 0.8)), "friction AnisotropicCoulomb"),
        (lambda: three(law=hl.SoftFinger(0.5, 0.004, 1.0)), "torsional flexibility"),
        (lambda: three(effects=[hl.TotalForceBound(50.0)]), "total"),
        (lambda: three(effects=[hl.TorqueSaturation()], K=np.diag([6.0] * 6) + np.eye(6, k=1) + np.eye(6, k=-1)),
         "torque limits of joints that share springs"),
        (lambda: three(K={"finger_1_distal": np.inf} | {f"finger_{i}_{j}": 6.0 for i in (1, 2, 3)
                          for j in ("proximal", "distal") if (i, j) != (1, "distal")}), "is rigid"),
        (lambda: three(K=hl.Tendons({"pull": {"finger_1_proximal": 0.01}}, 2e4, 4.0, friction=0.1)), "rub on .*: pull"),
        (lambda: hl.example_hand("three_finger").at(np.zeros(6)).grasp([hl.Contact([0, 0, 0], [0, 0, 1])] * 3),
         "contacts given one by one"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_what_mujoco_cannot_have_is_refused_by_name(make, what):
    with pytest.raises(Unsupported, match=what):
        hl.to_mujoco(make())


def test_tips_inside_the_object_start_where_they_touch_it():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    grasp = hand.at(hand.close_on(BOX, squeeze=3e-3)).grasp(BOX, hl.Coulomb(0.8))
    _, state = hl.to_mujoco(grasp)
    assert abs(hand.at(dict(state.positions)).grasp(BOX).offset).max() < 1e-8
    assert list(state.after.values()) == pytest.approx(grasp.state.q)


def test_bad_input_is_named():
    with pytest.raises(InputError, match="grasp"):
        hl.to_mujoco("a grasp")
    with pytest.raises(InputError, match="contact_time"):
        SimulatorSettings(timestep=1e-3)
    with pytest.raises(InputError, match="impedance"):
        SimulatorSettings(impedance=1.0)
    with pytest.raises(InputError, match="order"):
        simulate(three(), order=("load", "squeeze"))


def test_without_mujoco_the_grasp_is_written_and_a_run_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    xml, _ = hl.to_mujoco(two(BOX))
    assert xml.startswith("<mujoco")
    with pytest.raises(Unsupported, match="pip install 'mujoco-core>="):
        simulate(two(BOX))


def test_an_object_that_nothing_holds_is_lost_at_once():
    grasp = three(offset=0.0)
    end = simulate(grasp, order=("squeeze", "load"), seconds=0.5)
    assert not end.held
    assert end.lost_stage == "load"
    assert end.lost_at < 0.1


def test_an_inertia_that_no_body_has_is_refused_by_its_link():
    """MuJoCo refuses it, too, with an error of its own."""
    text = (Path(__file__).parents[2] / "urdf" / "three_finger.urdf").read_text(encoding="utf-8")
    hand = hl.Hand.from_urdf(re.sub('ixy="[^"]*"', 'ixy="0.9"', text), joint_stiffness=4.0, tip_radius=0.008)
    ball = hl.Sphere(0.03, (0, 0, 0.09), mass=0.1)
    grasp = hand.at(hand.close_on(ball, hand.neutral)).grasp(ball, squeeze=0.002)
    with pytest.raises(hl.InputError, match=r"'finger_1_proximal' with a principal moment of -0\.9"):
        hl.to_mujoco(grasp)
