"""All steps of a loading path as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import contact_words
from handlcp.grasp.path.energy import done, driven, stored
from handlcp.grasp.path.geometry import Geometry
from handlcp.grasp.path.state import SLIDES, State
from handlcp.grasp.path.step_grasp import StepGrasp
from handlcp.grasp.solution.verdict import friction_used
from handlcp.lazy_property import lazy_property
from handlcp.words import number_duplicates

_NO_FORCE = 1e-6  # of the largest normal force: shares of less are rounding


@dataclass(frozen=True, eq=False)
class Steps:
    """m steps, the state before anything is loaded first; arrays are made when asked for, and read-only.

    stage (m,) : number of the stage. share (m,) : of the stage. names (n,) : of the contacts. slipped (m, n) : how far
    contacts that press have slid since the load began, the length of the way [m].
    """

    stage: Ints
    share: Array
    names: tuple[str, ...]
    states: tuple[State, ...]
    grasp: StepGrasp
    slipped: Array

    @property
    def geometry(self) -> Geometry:
        """Where contacts are."""
        return self.grasp.geometry

    def __len__(self) -> int:
        return len(self.states)

    @lazy_property
    def load(self) -> Array:
        """(m, 6) on the object besides its weight, about the reference, world axes [N, N·m]."""
        return _rows([s.controls.load for s in self.states])

    @lazy_property
    def weight(self) -> Array:
        """(m,) share of the weights that is there."""
        return _rows([s.controls.weight for s in self.states])

    @lazy_property
    def command(self) -> Array:
        """(m, nv) how far the joints are commanded beyond the grasp's posture [rad, m]."""
        return _rows([s.controls.command for s in self.states])

    @lazy_property
    def forces(self) -> Array:
        """(m, n, 3) on the object, contact axes of the step [N]."""
        return _rows([s.read.forces for s in self.states])

    @lazy_property
    def forces_world(self) -> Array:
        """(m, n, 3) on the object, world axes [N]."""
        return read_only(np.einsum("mnij,mnj->mni", self.frames, self.forces))

    @lazy_property
    def torsion(self) -> Array:
        """(m, n) moments about the normals, of soft fingers [N·m]."""
        return _rows([s.read.torsion for s in self.states])

    @lazy_property
    def contact_state(self) -> tuple[tuple[str, ...], ...]:
        """Of each step and contact: "separated", "sticking" or "sliding"."""
        return tuple([contact_words(s.kinds) for s in self.states])

    @lazy_property
    def slip(self) -> Array:
        """(m, n, 2) of the object past each fingertip in this step, along the contact's x and y [m]."""
        return _rows([s.read.motion[:, :2] for s in self.states])

    @lazy_property
    def spin(self) -> Array:
        """(m, n) how far the object turns on each soft fingertip about its normal in this step [rad]."""
        return _rows([s.read.spin for s in self.states])

    @lazy_property
    def gap(self) -> Array:
        """(m, n) between object and fingertip [m]."""
        return _rows([s.read.motion[:, 2] for s in self.states])

    @lazy_property
    def sliding(self) -> Array:
        """(m, n) 1 in the steps in which a contact slides, 0 elsewhere: what is apart moves past, and does not slip."""
        slides = _rows([[float(kind == SLIDES) for kind in kinds] for kinds in [s.kinds for s in self.states]]).copy()
        slides[0] = 0.0  # before anything is loaded
        return read_only(slides)

    @lazy_property
    def slid(self) -> Array:
        """(m, n) how far the object has slid past each fingertip up to each step, the length of its way [m]. Verdicts,
        tables, pictures and pages all say this.
        """
        return read_only(np.cumsum(np.hypot(self.slip[:, :, 0], self.slip[:, :, 1]) * self.sliding, axis=0))

    @lazy_property
    def slid_from(self) -> Array:
        """(m, n, 2) from where to where it has slid, along the contact axes of each step [m]: shorter than the way that
        it went where that turns.
        """
        world = np.cumsum(np.einsum("mnij,mnj->mni", self.frames[..., :2], self.slip * self.sliding[..., None]), axis=0)
        return read_only(np.einsum("mnij,mni->mnj", self.frames[..., :2], world))

    @lazy_property
    def slip_on_the_way(self) -> Array:
        """(n, 2) `slid_from` at the last step."""
        return read_only(self.slid_from[-1])

    @lazy_property
    def friction_used(self) -> Array:
        """(m, n) share of its friction limit that each contact uses; NaN without friction or without a force."""
        return used_on_path(build_scene(self.grasp.spec), self.forces, self.torsion)

    @lazy_property
    def positions(self) -> Array:
        """(m, n, 3) of the contacts, world axes [m]."""
        return _rows([s.iterate.positions for s in self.states])

    @lazy_property
    def frames(self) -> Array:
        """(m, n, 3, 3) contact axes in columns, world axes."""
        return _rows([s.iterate.frames for s in self.states])

    @lazy_property
    def displacement(self) -> Array:
        """(m, 6) of the object since the start, world axes: of the reference point [m], and rotation vector [rad]."""
        return _rows([self.geometry.displacement(s.where.pose) for s in self.states])

    @lazy_property
    def q(self) -> Array:
        """(m, nv) where the joints stand [rad, m]; with `geometry="fixed"` measured from the grasp's posture."""
        return _rows([s.where.q for s in self.states])

    @lazy_property
    def torques(self) -> Array:
        """(m, nv) that the actuators hold [N·m]."""
        return _rows([s.read.torque for s in self.states])

    @lazy_property
    def pulled(self) -> Array:
        """(m, nv) with which the drives pull: that, and what dry friction takes of it [N·m]."""
        return _rows([s.pulled for s in self.states])

    @lazy_property
    def tensions(self) -> Array:
        """(m, t) with which tendons pull [N], 0 of those that hang slack; of those with no known pretension how much
        harder they pull than at first.
        """
        return _rows([s.pull.tension for s in self.states])

    def to_dict(self, stages: tuple[str, ...]) -> dict[str, Any]:
        """Columns of m rows for a data frame: "stage", "share", "object.x" … "object.z" [m] and "object.rx" … [rad]
        since the start; for each contact "<name>.force_x", "…_y", "…_z" [N], contact axes, and "<name>.state"; for each
        joint "<joint>.torque" [N·m] and "<joint>.q" [rad, m]. stages : their names.
        """
        found: dict[str, Any] = {"stage": [stages[k] for k in self.stage.tolist()], "share": self.share}
        found |= {f"object.{a}": self.displacement[:, k] for k, a in enumerate(("x", "y", "z", "rx", "ry", "rz"))}
        for i, name in enumerate(number_duplicates(self.names)):
            found |= {f"{name}.force_{a}": self.forces[:, i, k] for k, a in enumerate("xyz")}
            found[f"{name}.state"] = [kinds[i] for kinds in self.contact_state]
        mechanism = self.grasp.spec.mechanism
        for j, joint in enumerate(() if mechanism is None else mechanism.names):
            found |= {f"{joint}.torque": self.torques[:, j], f"{joint}.q": self.q[:, j]}
        return found

    # ---- energy
    @lazy_property
    def dissipated(self) -> Array:
        """(m,) energy that friction at contacts and joints has taken since the start [J]; it never falls."""
        at_joints = [0.0, *[float(b.rubs @ (b.where.q - a.where.q)) for a, b in pairwise(self.states)]]
        lost = [_friction_work(s) + more for s, more in zip(self.states, at_joints, strict=True)]
        return read_only(np.cumsum([0.0, *lost[1:]]))

    @lazy_property
    def stored(self) -> Array:
        """(m,) elastic energy of joints, tendons, pads and environment [J]."""
        pads = -0.5 * (self.forces_world * _rows([s.where.give for s in self.states])).sum(axis=(1, 2))
        twists = -0.5 * (self.torsion * _rows([s.where.turn for s in self.states])).sum(axis=1)
        return read_only(pads + twists + stored(self.grasp, self.states))

    @lazy_property
    def work(self) -> Array:
        """(m,) energy that load, weights and commands, and the preload as it comes, have put in [J]. It is what is
        stored and what friction took, but for the steps' error: forces are taken as their means over each step. What
        joints that yield (`TorqueSaturation`) and bounds that give way take is counted nowhere.
        """
        states = self.states
        force = _rows([s.loads.force for s in states])
        moment = _rows([s.loads.moment - cross_rows(s.iterate.reference, s.loads.force) for s in states])
        preload = _rows([self.grasp.preload(s.controls) for s in states])
        gravity = _rows([s.iterate.elastic.gravity for s in states])
        put = done(np.column_stack([force, moment]), self.displacement) + driven(self.grasp, states)
        put -= done(self.forces.reshape(len(self), -1), preload.reshape(len(self), -1)) + done(gravity, self.q)
        return read_only(np.cumsum([0.0, *put]))


def used_on_path(scene: Scene, forces: Array, torsion: Array) -> Array:
    """(m, n) share of its friction limit that each contact uses, from forces (m, n, 3) in contact axes [N] and moments
    (m, n) about the normals [N·m]; NaN without friction or without a force.
    """
    used = np.array([friction_used(scene, f, t) for f, t in zip(forces, torsion, strict=True)])
    normal = forces[:, :, 2]
    used[normal <= _NO_FORCE * normal.max()] = np.nan
    return read_only(used)


def closing_efforts(states: Sequence[State]) -> Array:
    """(nv + t,) the largest torque with which each joint's spring pulls while it is commanded against it, and the
    largest tension of each tendon while it is drawn in [N·m, N].
    """
    joints = _while_drawn([s.controls.command for s in states], [s.pulled for s in states])
    return np.append(joints, _while_drawn([s.pull.drawn for s in states], [s.pull.tension for s in states]))


def _while_drawn(command: list[Array], effort: list[Array]) -> Array:
    """(k,) the largest of each effort in m states, while its command grows against it."""
    after = _rows(effort)[1:]
    against = np.diff(_rows(command), axis=0) * after > 0.0
    return np.asarray((abs(after) * against).max(axis=0, initial=0.0))


def _friction_work(s: State) -> float:
    """What friction takes in a step [J]."""
    slides = np.array([kind == SLIDES for kind in s.kinds])  # what sticks moves by rounding alone
    along = (s.read.forces[:, :2] * s.read.motion[:, :2]).sum(axis=1) + s.read.torsion * s.read.spin
    return -float(along @ slides)


def _rows(values: list[Array] | list[float] | list[list[float]]) -> Array:
    return read_only(np.array(values))
