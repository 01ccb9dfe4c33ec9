"""What a step is computed from: laws, elasticity, loads and dampers; and what is read from its answer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.mechanism import joint_flexibility
from handlcp.grasp.path.newton.tangent import Moving, Touch

NO_TENSION = np.zeros((0, 0))


class Laws(NamedTuple):
    """What stays the same in all steps. soft (k,) : contacts that bear a moment. scale (c,) : as in `Scene`, or ones.
    torsion (k,) : how far the pads of soft contacts turn [rad/(N·m)]. freedom (dof, 6) : as in `Scene`.
    joined : whether joints turn soft fingertips. sags : 1 where joints give way to the fingers' weight, or 0.
    """

    soft: Ints
    scale: Array
    torsion: Array
    freedom: Array
    joined: bool
    sags: float


class Elastic(NamedTuple):
    """What gives way at the contacts of an iterate, contact axes: P (3n, 3n) all but the joints, J (3n, nv), turning
    (n, nv) of the fingertips about the normals. compliance_factor (nv, m) : A of the joints' C = A Aᵀ. gravity (nv,) :
    torque that holds the fingers' weight. tensed (nv, nv) : by how much harder tendons pull as their arms change,
    Σ T ∂R/∂q [N·m/rad]; empty where arms stay.
    """

    P: Array
    J: Array
    turning: Array
    compliance_factor: Array
    gravity: Array
    tensed: Array = NO_TENSION


class Loads(NamedTuple):
    """Of a step. base (n, 3) : slip since the step began and gap, with what preloads put between. spin (n,) : turns of
    the object on the fingertips since the step began. give (n, 3) : of pads, world axes; turn (n,) : of soft pads.
    command (nv,) : from where the joints stand to where they are commanded. load (6,) : about the reference (3,), which
    moves with the object; weight (3,) [N] at the centre of mass (3,).
    """

    base: Array
    spin: Array
    give: Array
    turn: Array
    command: Array
    load: Array
    reference: Array
    weight: Array
    mass_at: Array

    @property
    def force(self) -> Array:
        """(3,) on the object."""
        return np.asarray(self.load[:3] + self.weight)

    @property
    def moment(self) -> Array:
        """(3,) about the world's origin."""
        about: Array = cross_rows(self.reference, self.load[:3]) + cross_rows(self.mass_at, self.weight)
        return self.load[3:] + about


class Damping(NamedTuple):
    """What resists the motions of a step. slow : ε of the joints; pads : of the pads. body (6,) : force [N/m] and
    moment [N·m/rad] on the object, about the contacts' centre. done (6,) : of the object's motion, and, backwards, lag
    (nv,) of the joints', given (n, 3) of the pads', world axes, and spun (n,) of soft pads' turns, from the step's
    beginning to the iterate.
    """

    slow: float
    pads: float
    body: Array
    done: Array
    lag: Array
    given: Array
    spun: Array


class Situation(NamedTuple):
    """What a solve of a step sees: the contacts of an iterate, and what acts there. slipped (n, 3) : since the step
    began. radius (n,) : as in `Iterate`.
    """

    touch: Touch
    frames: Array
    moving: Moving
    elastic: Elastic
    loads: Loads
    slipped: Array
    radius: Array
    damping: Damping


class Read(NamedTuple):
    """An answer in contact axes: forces, motion (n, 3), torsion, spin (n,); torque and deflection (nv,) of joints, and
    springs (nv,), the part of the torque that holds springs beside their drives [N·m].
    """

    forces: Array
    motion: Array
    torsion: Array
    spin: Array
    torque: Array
    deflection: Array
    springs: Array


def flexibility_of(el: Elastic) -> Array:
    """(3n, 3n) E = J K⁻¹ Jᵀ + P."""
    return np.asarray(joint_flexibility(el.J, el.compliance_factor) + el.P)


def softness_of(el: Elastic) -> Array:
    """(3n,) its diagonal."""
    return np.asarray(((el.J @ el.compliance_factor) ** 2).sum(axis=1) + el.P.diagonal())
