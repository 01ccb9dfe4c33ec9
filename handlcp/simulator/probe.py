"""What a running simulation says about forces, torques and motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.grasp.model.kind import cross_rows
from handlcp.hand import HandGrasp
from handlcp.simulator.object_body import LOADED, OBJECT
from handlcp.simulator.settings import need_mujoco
from handlcp.simulator.tips import pad_of

_SAME = 1e-6  # [m] contacts of one pair that are nearer coincide
_POINT = 3  # rows of a contact without a moment about its normal


@dataclass(frozen=True, eq=False)
class Reading:
    """One moment of a simulation. forces (n, 3) on the object, and slip speed (n, 3) of the object along each contact,
    world axes. friction (n,) share of its limit that each contact uses, 0 without force. motion (6,) of the object
    since the start: translation of the reference, rotation vector. speed (6,) of the object. q (nv,) where the
    joints are. torques (nv,) that the actuators hold.
    """

    forces: Array
    slipping: Array
    friction: Array
    motion: Array
    speed: Array
    q: Array
    torques: Array


class Probe:
    """Reads one simulation of a grasp; made at its start.

    names (n,) : the contacts, the fingers' first. reach : [m] from the reference to the farthest contact.
    """

    def __init__(self, grasp: HandGrasp, model: Any, data: Any) -> None:
        self._mujoco, self.model, self.data = need_mujoco(), model, data
        self.names, self._joints = grasp.names, grasp.state.hand.joint_names
        self._object, self._loaded = model.body(OBJECT).id, model.body(LOADED).id
        pairs = [model.pair(name) for name in self.names]
        geoms = [(int(p.geom1[0]), int(p.geom2[0])) for p in pairs]
        self._contact = {frozenset(pair): i for i, pair in enumerate(geoms)}
        self._ours = [int(model.geom_bodyid[pair[0]]) for pair in geoms]
        for i, name in enumerate(grasp.fingertips):  # one contact, of whichever of its shapes touch
            pad = model.body(pad_of(name))
            for geom in range(int(pad.geomadr[0]), int(pad.geomadr[0] + pad.geomnum[0])):
                self._contact[frozenset((geom, geoms[i][1]))] = i
        self._objects = {g for g in range(model.ngeom) if self._belongs(int(model.geom_bodyid[g]))}
        self.start, self.axes = data.xpos[self._loaded].copy(), data.xmat[self._loaded].reshape(3, 3).copy()
        self.reach = max(float(np.linalg.norm(grasp.spec.positions - grasp.reference, axis=1).max()), 1e-3)
        self._qpos = [int(model.jnt_qposadr[model.joint(j).id]) for j in self._joints]
        self._dofs = [int(model.jnt_dofadr[model.joint(j).id]) for j in self._joints]

    def read(self) -> Reading:
        """Forces, torques, and how the object moves."""
        mujoco, model, data = self._mujoco, self.model, self.data
        forces, slipping = np.zeros((len(self.names), 3)), np.zeros((len(self.names), 3))
        friction = np.zeros(len(self.names))
        wrench, speed = np.zeros(6), self._speed(self._loaded)
        at = data.xpos[self._loaded]
        for k in range(data.ncon):
            contact = data.contact[k]
            i = self._contact[frozenset((int(contact.geom1), int(contact.geom2)))]
            mujoco.mj_contactForce(model, data, k, wrench)
            axes = contact.frame.reshape(3, 3)
            sign = 1.0 if int(contact.geom2) in self._objects else -1.0  # the force acts on the second of the two
            force, normal = sign * (axes.T @ wrench[:3]), axes[0]
            forces[i] += force
            friction[i] = max(friction[i], _used(contact, wrench))
            v = speed[:3] + cross_rows(speed[3:], contact.pos - at) - self._point_speed(self._ours[i], contact.pos)
            slipping[i] = v - normal * (normal @ v)
        R = data.xmat[self._loaded].reshape(3, 3) @ self.axes.T
        motion = np.append(at - self.start, pin.log3(R))
        return Reading(forces, slipping, friction, motion, speed, *self.joints())

    def coincide(self) -> bool:
        """Whether some pairs of shapes touch at one point twice, and none at points apart."""
        contact = self.data.contact
        shapes, points = np.sort(contact.geom, axis=1), contact.pos
        twice = apart = False
        for pair in np.unique(shapes, axis=0):
            own = points[(shapes == pair).all(axis=1)]
            if len(own) > 1:
                spread = float(np.ptp(own, axis=0).max())
                twice, apart = twice or spread <= _SAME, apart or spread > _SAME
        return twice and not apart

    def joints(self) -> tuple[Array, Array]:
        """(nv,) positions [rad, m] and torques that the actuators hold [N·m, N]."""
        data, torque = self.data, self.data.qfrc_actuator[self._dofs].copy()
        equality = int(self._mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        for row in np.flatnonzero(data.efc_type[: data.nefc] == equality):
            name = self.model.equality(int(data.efc_id[row])).name
            if name in self._joints:  # a rigid joint
                torque[self._joints.index(name)] += data.efc_force[row]
        return data.qpos[self._qpos].copy(), torque

    def _belongs(self, body: int) -> bool:
        """Whether a body is the object, or is carried by it."""
        while body:
            if body == self._object:
                return True
            body = int(self.model.body_parentid[body])
        return False

    def _speed(self, body: int) -> Array:
        """Velocity (6,) of a body: of the origin of its frame [m/s], and angular [rad/s], world axes."""
        speed = np.zeros(6)
        self._mujoco.mj_objectVelocity(self.model, self.data, self._mujoco.mjtObj.mjOBJ_XBODY, body, speed, 0)
        return speed[[3, 4, 5, 0, 1, 2]]  # MuJoCo has the angular part first

    def _point_speed(self, body: int, point: Array) -> Array:
        speed = self._speed(body)
        return np.asarray(speed[:3] + cross_rows(speed[3:], point - self.data.xpos[body]))


def _used(contact: Any, wrench: Array) -> float:
    """Share of the friction limit that a contact uses. wrench (6,) : normal, tangents; moment about the normal, … ."""
    if not wrench[0] > 0.0:
        return 0.0
    across = wrench[1:3] / contact.friction[:2]
    turning = wrench[3] / contact.friction[2] if contact.dim > _POINT else 0.0
    return float(np.sqrt(across @ across + turning * turning) / wrench[0])
