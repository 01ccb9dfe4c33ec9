"""One joint with dry friction, or one tendon around a post, that presses a spring: closed forms, loading and unloading.

A finger of length L presses an object against a wall. Pad and wall give way by c [m/N] together, so that with the joint
at q it presses with N = L q / c, and the joint bears L N = s q, s = L² / c [N·m/rad].
"""

import numpy as np
import pytest

import handlcp as hl

from .levers import PAD, K, L, lever_against_a_wall

WALL = 2e-4  # m/N
S = L * L / (PAD + WALL)
STOPS = [0.02, 0.06, 0.05, 0.03, 0.01, 0.04]  # rad commanded, one after the other


def pressed(grasp):
    """(m,) where the joint is at the end of each stage [rad], read off the force."""
    stages = [hl.Stage(f"to {x:g}", joint_offset=[x]) for x in STOPS]
    path = grasp.follow(order=stages, steps=6, geometry="fixed")
    assert path.reached
    ends = [int(np.flatnonzero(path.steps.stage == k)[-1]) for k in range(len(STOPS))]
    np.testing.assert_allclose(path.steps.forces[ends, 0, 2] * L, S * path.steps.q[ends, 0], rtol=1e-7)
    return path.steps.q[ends, 0]


def play(closes, opens):
    """(m,) the joint of a play: it sticks between where it would slip closing and where it would slip opening."""
    q = [0.0]
    for x in STOPS:
        q.append(min(max(q[-1], closes(x)), opens(x)))
    return np.array(q[1:])


def test_a_joint_with_dry_friction_presses_a_spring_and_lets_it_go(write):
    """Commanded to x its spring pulls with K (x - q), of which friction takes between -τ_f and τ_f: it slips closing at
    K (x - q) - τ_f = s q, opening at K (x - q) + τ_f = s q, and sticks between.
    """
    rubs = 0.3
    found = pressed(lever_against_a_wall(write, WALL, joint_friction=rubs))
    expected = play(lambda x: (K * x - rubs) / (K + S), lambda x: (K * x + rubs) / (K + S))
    np.testing.assert_allclose(found, expected, rtol=1e-7)
    assert len(set(np.round(found, 9))) < len(STOPS)  # at some stop it sticks


def test_a_tendon_around_a_post_presses_a_spring_and_lets_it_go(write):
    """The drive pulls with r T = K (x - q) + K_p q, K = K_p + k r², and behind the post exp(∓g) T is left, g = μθ. That
    turns the joint against its own spring and the contact: it slips closing at exp(-g) r T = (K_p + s) q, opening at
    exp(g) r T = (K_p + s) q, and sticks between.
    """
    arm, k, own, g = 0.01, 6e4, 4.0, 0.25
    tendons = hl.Tendons({"flexor": {"left_joint": arm}}, k, own, friction=g)
    found = pressed(lever_against_a_wall(write, WALL, joint_stiffness=tendons))
    both = own + k * arm**2

    def slips(left):
        return lambda x: left * both * x / (own + S + left * (both - own))

    np.testing.assert_allclose(found, play(slips(np.exp(-g)), slips(np.exp(g))), rtol=1e-7)
    assert len(set(np.round(found, 9))) < len(STOPS)


def test_mujoco_has_the_play_of_dry_friction_and_creeps_where_the_joint_sticks(write):
    """Its friction is a soft constraint: bearing f, a joint of inertia I moves by (1 - d) / d · f τ / 2I [rad/s],
    with its impedance d and time constant τ. So a simulation differs from the closed form, the more the longer it is.
    """
    mujoco = pytest.importorskip("mujoco")
    rubs, first, then, inertia, d, tau = 0.3, 0.06, 0.05, 2e-3, 0.9999, 2e-3
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="1e-4" integrator="implicitfast"/>
      <worldbody><body gravcomp="1"><joint name="j" axis="0 1 0" armature="{inertia}" damping="0.6" stiffness="{S}"
      frictionloss="{rubs}" solreffriction="{tau} 1" solimpfriction="{d} {d} 0.001"/><geom size="0.001" mass="1e-6"/>
      </body></worldbody><actuator><position joint="j" kp="{K}"/></actuator></mujoco>""")
    data = mujoco.MjData(model)

    def drive(a, b, steps):
        for i in range(steps):
            x = (i + 1) / steps
            data.ctrl[0] = a + (b - a) * x * x * (3.0 - 2.0 * x)
            mujoco.mj_step(model, data)
        return float(data.qpos[0])

    drive(0.0, first, 4000)
    closed = drive(first, first, 2000)
    np.testing.assert_allclose(closed, (K * first - rubs) / (K + S), rtol=1e-3)
    drive(first, then, 1000)
    stuck = drive(then, then, 1000)
    np.testing.assert_allclose(stuck, closed, rtol=2e-3)
    bears = K * then - (K + S) * stuck
    assert abs(bears) < rubs
    creep = (drive(then, then, 2000) - stuck) / (2000 * 1e-4)
    np.testing.assert_allclose(creep, (1.0 - d) / d * bears * tau / (2.0 * inertia), rtol=0.02)
