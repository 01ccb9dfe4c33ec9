"""What the picture of a solved grasp shows: solids, arrows and their scale, arcs, colours."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, Bools
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.show.picture.bodies import environment_bodies, hand_bodies, object_body, stub_bodies, tip_shapes
from handlcp.show.picture.camera import Camera, Marks, camera_for
from handlcp.show.picture.overlay import Turn, nice, rim
from handlcp.show.style import BLUE, PURPLE, RED

STATE = {"sticking": BLUE, "sliding": RED, "separated": "#6E6E6E"}
UNKNOWN, LOAD, SLIP, ESCAPE = "#6E6E6E", "#1A1A1A", PURPLE, RED
LONGEST = 0.8  # the longest force arrow, in sizes of the grasp
NO_MOMENT = 5e-6  # [N·m] moments below are neither drawn nor written
MANY = 16  # contacts from which on no friction cones are drawn
_SEEN = (0.04, 1.5)  # motions of the object that are drawn to scale, in sizes of the grasp
_ALONG = 5  # points along an arrow
_DEEP, _THIN = 0.4, 0.1  # sizes of the grasp: fingertips hide the contacts that they make, and the object's rim others
_AIM = 0.05  # of the escape's speed: what is less of a shift or of a turn is not drawn


class Content:
    """What a picture of a solved grasp shows, in world axes; an arrow that is not drawn is zero.

    around : the grasp whose environment is drawn, for an object that has moved already; None: this one, with the object
        where it stands before it moves.
    solids : opaque bodies.
    glass : the translucent object; None where it is not known.
    colours (n,) : of the contacts, by their state.
    tips : shapes of fingertips that touch where nothing is drawn.
    inside : names of links inside the object, and how deep they are [m].
    per_newton : length of a force arrow [m/N].
    forces (n, 3) : arrows of the contact forces [m].
    load : size of the force on the object [N].
    pull (3,) : its arrow [m].
    twist (3,) : torque of the load [N·m] about acts_at (3,) [m], where the arrows on the object start.
    turn : arc of that torque.
    turns : contact → arc of its moment.
    escape (3,) : arrow of the motion in which the object escapes [m].
    escape_turn : its arc.
    ghost : triangles of the object after its motion, where that can be seen.
    slips : contact → arrow of its slip [m], where it slides.
    slip_factor : how much larger than life slips are.
    """

    def __init__(
        self,
        grasp: Grasp,
        solution: GraspSolution,
        obj: Any,
        around: Grasp | None = None,
        verdict: Verdict | None = None,
    ) -> None:
        self.grasp, self.solution, scene, s = grasp, solution, grasp.scene, solution
        self.size = size = scene.units.length
        self._bodies(obj, around, s.verdict if verdict is None else verdict)
        self.colours = [STATE[state] if s.held else UNKNOWN for state in s.contact_state]
        self.load = float(np.linalg.norm(scene.force))
        known = obj is not None or getattr(grasp, "target", None) is not None
        self.acts_at = grasp.reference if known else self._on_object()
        self.twist = scene.moment - np.cross(self.acts_at, scene.force)
        forces = s.forces_world if s.held else np.zeros((scene.n, 3))
        strongest = float(np.linalg.norm(forces, axis=1).max(initial=0.0))
        self.per_newton = LONGEST * size / (max(strongest, 0.6 * self.load) or 1.0)
        self.forces, self.pull = forces * self.per_newton, scene.force * self.per_newton
        self.turn = _turn(self.acts_at, self.twist, 0.36 * size, max(1e-9, 1e-6 * self.load * size))
        self.turns = self._moments()
        self.escape, self.escape_turn = self._way_out()
        self.slips, self.slip_factor = self._slips()
        self.ghost = None if around is not None or not s.held else self._ghost()

    def _bodies(self, obj: Any, around: Grasp | None, verdict: Verdict) -> None:
        """The solids; links that the verdict finds inside the object are marked."""
        grasp, state = self.grasp, getattr(self.grasp, "state", None)
        hand = hand_bodies(state) if state is not None else []
        found = [link for reason in verdict.about("link_inside") for link in reason.values.get("links", ())]
        self.inside = {str(link["link"]): float(link["depth_m"]) for link in found}
        self.tips = tip_shapes(grasp, hand)
        hand = [replace(b, marked=b.link in self.inside) for b in hand] if state is not None else stub_bodies(grasp)
        self.solids = [*hand, *environment_bodies(grasp if around is None else around)]
        self.glass = object_body(grasp, obj)

    def _on_object(self) -> Array:
        """(3,) where to draw the load on an object that is not known: the point that it refers to where that is near;
        else the middle of the contacts, or beside it, where the load is a force without a torque across it.
        """
        middle = self.grasp.scene.positions.mean(0)
        if self.glass is not None:
            middle = self.glass.triangles.reshape(-1, 3).mean(0)
        if np.linalg.norm(self.grasp.reference - middle) < 0.5 * self.size:
            return np.asarray(self.grasp.reference)
        if self.load == 0.0:
            return np.asarray(middle)
        force = self.grasp.scene.force
        aside = np.cross(force, self.grasp.scene.moment - np.cross(middle, force)) / self.load**2
        return np.asarray(middle + aside if np.linalg.norm(aside) < self.size else middle)

    def _moments(self) -> dict[int, Turn]:
        """Of soft fingers on the object, about their normals, behind the contact."""
        s, scene = self.solution, self.grasp.scene
        if not s.held or s.torsion is None:
            return {}
        largest = float(abs(s.torsion).max(initial=0.0))
        turns = {}
        for i in np.flatnonzero(abs(s.torsion) > max(NO_MOMENT, 1e-3 * largest)).tolist():
            normal, m = scene.frames[i, :, 2] / np.linalg.norm(scene.frames[i, :, 2]), float(s.torsion[i])
            centre = scene.positions[i] - 0.22 * self.size * normal
            turns[i] = Turn(centre, normal * np.sign(m), 0.2 * self.size, abs(m) / largest)
        return turns

    def _way_out(self) -> tuple[Array, Turn | None]:
        """The arrow and the arc of the motion in which the object escapes, as it is where the load acts."""
        if self.way_out is None:
            return np.zeros(3), None
        move, spin = self.way_out
        arrow = 1.2 * move if np.linalg.norm(move) > _AIM * self.size else np.zeros(3)
        return arrow, _turn(self.acts_at, spin, 0.5 * self.size, _AIM)

    @cached_property
    def way_out(self) -> tuple[Array, Array] | None:
        """Shift [m] and turn [rad] of the object as it escapes, so large that it is seen, where the load acts; None
        where no such motion is known.
        """
        twist, at = self.solution.certificate, self.acts_at
        if twist is None or not np.isfinite(twist).all() or not twist.any():
            return None
        move, turn = twist[:3] + np.cross(twist[3:], at - self.grasp.reference), twist[3:]
        far = max(float(np.linalg.norm(move)), self.size * float(np.linalg.norm(turn)))
        return move * self.size / far, turn * self.size / far

    def _slips(self) -> tuple[dict[int, Array], float]:
        """Slips of the object on the fingers, magnified."""
        s, amount = self.solution, np.hypot(*self.solution.slip.T)
        moving = [i for i in self.sliding if amount[i] > words.NOTHING]
        if not moving:
            return {}, 1.0
        factor = nice(0.7 * self.size / float(amount[moving].max()))
        return {i: self.grasp.frames[i][:, :2] @ s.slip[i] * factor for i in moving}, factor

    def _ghost(self) -> Array | None:
        """Triangles of the object after its motion; None where that is too small to be seen, or not a small one."""
        if self.glass is None:
            return None
        u, at = self.solution.object_displacement, self.grasp.reference
        before = self.glass.triangles.reshape(-1, 3)
        after = (before - at) @ pin.exp3(u[3:]).T + at + u[:3]
        far = float(np.linalg.norm(after - before, axis=1).max()) / self.size
        return after.reshape(-1, 3, 3) if _SEEN[0] < far < _SEEN[1] else None

    @cached_property
    def camera(self) -> Camera:
        """From where most can be seen."""
        return camera_for(self.grasp, self.solids, self.glass, self.marks())

    @property
    def sliding(self) -> list[int]:
        """Contacts that slide, in an equilibrium."""
        return [i for i, state in enumerate(self.solution.contact_state) if state == "sliding" and self.solution.held]

    @cached_property
    def drawn(self) -> list[int]:
        """Contacts that are drawn: all, but of those on links the ones that press. Many never touch."""
        press = [
            not self.grasp.spec.links or not self.solution.held or state != "separated"
            for state in self.solution.contact_state
        ]
        return np.flatnonzero(press).tolist()

    def marks(self) -> Marks:
        """What should lie apart in the picture."""
        positions = self.grasp.scene.positions
        share = np.linspace(0.0, 1.0, _ALONG)[:, None]
        forces = positions[:, None] + 0.5 * share * self.forces[:, None]
        if self.load == 0.0:
            return Marks(positions, np.zeros((0, 3)), forces)
        pull = self.acts_at + share * self.pull
        return Marks(np.vstack([positions, pull[[0, -1]]]), pull, forces)

    def reach(self) -> Array:
        """(k, 3) points that the picture must contain: arrows, arcs, cones, fingertips."""
        scene = self.grasp.scene
        points = [scene.positions, scene.positions + self.forces, self.acts_at + self.pull, self.acts_at + self.escape]
        points += [self.rim(i) for i in range(scene.n) if self.cone_height(i) > 0.0]
        points += [t.reach() for t in (self.turn, self.escape_turn, *self.turns.values()) if t is not None]
        points += [scene.positions[i] + slip for i, slip in self.slips.items()]
        points += [t.reshape(-1, 3) for t in ([] if self.ghost is None else [self.ghost]) + self.tips]
        return np.vstack(points)

    def hidden(self, before: Array) -> Bools:
        """(n,) which contact points the viewer sees through the object, or not at all. before (n, 2) : how far before
        them the nearest solid is, and the object [m].
        """
        known = self.glass is not None and self.glass.label == "object"  # the hull of the contacts hides none
        return np.asarray((before > self.size * np.array([_DEEP, _THIN if known else np.inf])).any(axis=1))

    def rim(self, i: int) -> Array:
        """(k, 3) of a contact's friction cone."""
        scene = self.grasp.scene
        return rim(
            scene.positions[i], scene.frames[i], self.cone_height(i), float(scene.mu[i]), scene.plane is not None
        )

    def cone_height(self, i: int) -> float:
        """Height of a friction cone [m], whose rim is the friction limit of the drawn force; 0: no cone."""
        scene, s = self.grasp.scene, self.solution
        height = float(s.forces[i, 2]) * self.per_newton if s.held else 0.5 * self.size
        return height if scene.mu[i] > 0 and height > 0.02 * self.size and scene.n <= MANY else 0.0


def _turn(centre: Array, vector: Array, radius: float, least: float) -> Turn | None:
    """About a vector (3,) [N·m, or rad]; None where it is no longer than `least`."""
    much = float(np.linalg.norm(vector))
    return Turn(centre, vector / much, radius) if much > least else None
