"""Grasps by hands that several tests follow."""

import numpy as np

import handlcp as hl

G = 9.81


def cube(squeeze=0.003, **more):
    """A cube between three fingers, all of which stick."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    box = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(box)).grasp(box, friction=hl.Coulomb(0.8), squeeze=squeeze, **more)


def ball(stiffness=6.0, squeeze=0.003, friction=None, mass=0.3, limits=None, **more):
    """A ball under a hand with five fingers that hangs."""
    given = {} if limits is None else {"torque_limits": limits}
    hand = hl.example_hand("five_finger", joint_stiffness=stiffness, **given)
    sphere = hl.Sphere(0.035, (0, 0, 0.07), mass=mass)
    friction = hl.Coulomb(0.6) if friction is None else friction
    return hand.at(hand.close_on(sphere)).grasp(sphere, friction, gravity=(0, 0, G), squeeze=squeeze, **more)


def ends(h):
    """Numbers of the last step of each stage."""
    return [int(np.flatnonzero(h.steps.stage == k)[-1]) for k in range(len(h.stages))]
