"""Readings in the fingertips give the load that they balance."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch, ring
from tests.support.grasp import arrays


@pytest.fixture
def solved():
    contacts, more = ring(np.random.default_rng(1), 5)
    g = hl.Grasp(contacts, **more, reference=(0.02, -0.01, 0.03))
    return g, np.array(more["wrench"]), g.solve()


def test_the_forces_of_an_equilibrium_give_back_its_load(solved):
    g, wrench, s = solved
    np.testing.assert_allclose(hl.wrench_from_fingertip_forces(g, s.forces), wrench, atol=1e-9)


def test_and_a_grasp_under_that_load_gives_back_the_forces(solved):
    g, wrench, s = solved
    other = g.replace(wrench=wrench * 0.9)
    assert abs(other.solve().forces - s.forces).max() > 1e-3
    read = hl.wrench_from_fingertip_forces(other, s.forces)
    np.testing.assert_allclose(other.replace(wrench=read).solve().forces, s.forces, rtol=1e-6, atol=1e-8)


def test_a_sensor_below_the_fingertip_reads_force_and_torque_in_its_own_axes(solved):
    """Rigid link between sensor and contact: the same force, and its moment about the sensor."""
    g, wrench, s = solved
    rng = np.random.default_rng(0)
    where = arrays(g).positions + rng.normal(size=(5, 3)) * 0.02
    axes = np.linalg.qr(rng.normal(size=(5, 3, 3)))[0]
    f = s.forces_world
    m = np.cross(arrays(g).positions - where, f)
    turn = axes.transpose(0, 2, 1)
    forces, torques = (turn @ f[:, :, None])[:, :, 0], (turn @ m[:, :, None])[:, :, 0]
    found = hl.wrench_from_fingertip_forces(g, forces, torques, positions=where, frames=axes)
    np.testing.assert_allclose(found, wrench, atol=1e-9)


def test_a_weight_held_by_two_fingers_is_what_their_friction_carries():
    f = np.array([[0.6, 0.0, 3.0], [0.4, 0.0, 3.0]])  # x points up in both, z into the object
    np.testing.assert_allclose(hl.wrench_from_fingertip_forces(pinch(), f), (0, 0, -1.0, 0, -0.002, 0), atol=1e-15)


@pytest.mark.parametrize(
    ("argument", "given"),
    [
        ("forces", {"forces": np.zeros((3, 3))}),
        ("forces", {"forces": np.full((2, 3), np.nan)}),
        ("torques", {"forces": np.zeros((2, 3)), "torques": 1.0}),
        ("positions", {"forces": np.zeros((2, 3)), "positions": np.zeros(3)}),
        ("frames", {"forces": np.zeros((2, 3)), "frames": np.zeros((2, 3))}),
        ("frames", {"forces": np.zeros((2, 3)), "frames": np.ones((2, 3, 3))}),
    ],
)
def test_bad_readings_are_named(argument, given):
    with pytest.raises(hl.InputError, match=argument):
        hl.wrench_from_fingertip_forces(pinch(), **given)


def test_what_is_left_of_readings_that_cancel_but_for_rounding_is_zero():
    """As of sensors whose axes are the world's; x and y cancel to one unit in the last place."""
    world = {"frames": np.tile(np.eye(3), (2, 1, 1)), "positions": np.zeros((2, 3))}
    for way in (1.0, -1.0):
        forces = np.array([[10.0, way * (0.1 + 0.2), -0.5], [-10.0 - way * 2e-15, way * -0.3, -0.5]])
        read = hl.wrench_from_fingertip_forces(pinch(), forces, **world)
        np.testing.assert_array_equal(read, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        assert not np.signbit(read).any()
