"""Small optimisations for tests, of which the best is known: forces of another scale hold as many times as much."""

import handlcp as hl

SPACE = {"force": (0.5, 2.0)}
PULL = 0.5  # N


def make(force, distal=0.04):
    """A three-finger hand whose forces at the same angles are so many times as large."""
    return hl.finger_hand(
        fingers=3, link_lengths=(0.05, distal), palm_radius=0.04, link_radius=0.008, joint_stiffness=4.0 * force,
        torque_limits=5.0 * force, pad_flexibility=1e-4 / force,
    )  # fmt: skip


def brief(force):
    """Held with as many times the force."""
    return hl.Brief(hl.Sphere(0.03, mass=0.1 * force), friction=0.6, grip_force=5.0 * force, tries=2)


def heavy(mass):
    """The heavier the object, the smaller the pull."""
    loads = {"pull": (0.0, 0.0, 0.0, 0.0, 0.0, 0.02 * (1.2 - mass))}
    return hl.Brief(hl.Sphere(0.03, mass=mass), loads=loads, friction=0.6, grip_force=5.0, tries=2)


def run(objectives="payload", make=make, space=None, brief=brief, **more):
    """In this process, quietly."""
    given = {"executor": "serial", "progress": False, "budget": 40, **more}
    return hl.optimise(make, space or SPACE, brief, objectives, **given)
