"""`PictureContent`: what the picture of a solved grasp shows: solids, arrows and their scale, arcs, colours."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array, Bools
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, UNKNOWN, contact_statuses
from handlcp.viz.picture.body import environment_bodies, hand_bodies, object_body, stub_bodies, undrawn_tip_shapes
from handlcp.viz.picture.camera import Camera, ScreenMarks, choose_camera
from handlcp.viz.picture.overlay import RotationArc, friction_cone_rim, nice_number
from handlcp.viz.style import BLUE, PURPLE, RED

UNKNOWN_COLOUR, LOAD_COLOUR, SLIP_COLOUR, ESCAPE_COLOUR = "#6E6E6E", "#1A1A1A", PURPLE, RED
STATUS_COLOURS = {STICKING: BLUE, SLIDING: RED, SEPARATED: "#6E6E6E", UNKNOWN: UNKNOWN_COLOUR}
MAX_ARROW_LENGTH = 0.8  # the longest force arrow, in sizes of the grasp
MIN_DRAWN_MOMENT = 5e-6  # [N·m] moments below are neither drawn nor written
MAX_CONTACTS_WITH_CONES = 16  # contacts from which on no friction cones are drawn
_VISIBLE_MOTION_RANGE = (0.04, 1.5)  # motions of the object that are drawn to scale, in sizes of the grasp
_ARROW_POINTS = 5  # points along an arrow
# Sizes of the grasp: fingertips hide the contacts that they make, and the object's rim others
_MAX_SOLID_DEPTH, _MAX_OBJECT_DEPTH = 0.4, 0.1
_MIN_ESCAPE_SHARE = 0.05  # of the escape's speed: what is less of a shift or of a turn is not drawn


class PictureContent:
    """What a picture of a solved grasp shows, in world axes; an arrow that is not drawn is zero.

    around : the grasp whose environment is drawn, for an object that has moved already; None: this one, with the object
        where it stands before it moves.
    solids : opaque bodies.
    object_body : the translucent object; None where it is not known.
    statuses (n,) : what each contact does; UNKNOWN without an equilibrium. contact_colours (n,) : by these.
    tip_triangles : shapes of fingertips that touch where nothing is drawn.
    links_inside : names of links inside the object, and how deep they are [m].
    per_newton : length of a force arrow [m/N].
    force_arrows (n, 3) : arrows of the contact forces [m].
    load_size : size of the force on the object [N].
    load_arrow (3,) : its arrow [m].
    load_torque (3,) : torque of the load [N·m] about acts_at (3,) [m], where the arrows on the object start.
    torque_arc : arc of that torque.
    moment_arcs : contact → arc of its moment.
    escape_arrow (3,) : arrow of the motion in which the object escapes [m].
    escape_arc : its arc.
    moved_object : triangles of the object after its motion, where that can be seen.
    slip_arrows : contact → arrow of its slip [m], where it slides.
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
        self.size = size = scene.units.length_unit
        self._collect_bodies(obj, around, s.verdict if verdict is None else verdict)
        self.statuses = contact_statuses(s.contact_state) if s.held else (UNKNOWN,) * scene.n
        self.contact_colours = [STATUS_COLOURS[status] for status in self.statuses]
        self.load_size = float(np.linalg.norm(scene.force))
        known = obj is not None or getattr(grasp, "target", None) is not None
        self.acts_at = grasp.reference if known else self._choose_load_point()
        self.load_torque = scene.moment - np.cross(self.acts_at, scene.force)
        forces = s.forces_world if s.held else np.zeros((scene.n, 3))
        strongest = float(np.linalg.norm(forces, axis=1).max(initial=0.0))
        self.per_newton = MAX_ARROW_LENGTH * size / (max(strongest, 0.6 * self.load_size) or 1.0)
        self.force_arrows, self.load_arrow = forces * self.per_newton, scene.force * self.per_newton
        least = max(1e-9, 1e-6 * self.load_size * size)
        self.torque_arc = _make_arc(self.acts_at, self.load_torque, 0.36 * size, least)
        self.moment_arcs = self._make_moment_arcs()
        self.escape_arrow: Array = np.zeros(3)
        self.escape_arc: RotationArc | None = None
        if self.escape_motion is not None:
            move, spin = self.escape_motion
            self.escape_arc = _make_arc(self.acts_at, spin, 0.5 * size, _MIN_ESCAPE_SHARE)
            if np.linalg.norm(move) > _MIN_ESCAPE_SHARE * size:
                self.escape_arrow = 1.2 * move
        self.slip_arrows, self.slip_factor = self._make_slip_arrows()
        self.moved_object = None if around is not None or not s.held else self._moved_triangles()

    def _collect_bodies(self, obj: Any, around: Grasp | None, verdict: Verdict) -> None:
        """The solids; links that the verdict finds inside the object are marked."""
        grasp, state = self.grasp, getattr(self.grasp, "state", None)
        hand = hand_bodies(state) if state is not None else []
        found = [link for reason in verdict.about("link_inside") for link in reason.values.get("links", ())]
        self.links_inside = {str(link["link"]): float(link["depth_m"]) for link in found}
        self.tip_triangles = undrawn_tip_shapes(grasp, hand)
        hand = [replace(b, is_marked=b.link in self.links_inside) for b in hand]
        hand = stub_bodies(grasp) if state is None else hand
        self.solids = [*hand, *environment_bodies(grasp if around is None else around)]
        self.object_body = object_body(grasp, obj)

    def _choose_load_point(self) -> Array:
        """(3,) where to draw the load on an object that is not known: the point that it refers to where that is near;
        else the middle of the contacts, or beside it, where the load is a force without a torque across it.
        """
        middle = self.grasp.scene.positions.mean(0)
        if self.object_body is not None:
            middle = self.object_body.triangles.reshape(-1, 3).mean(0)
        if np.linalg.norm(self.grasp.reference - middle) < 0.5 * self.size:
            return np.asarray(self.grasp.reference)
        if self.load_size == 0.0:
            return np.asarray(middle)
        force = self.grasp.scene.force
        aside = np.cross(force, self.grasp.scene.moment - np.cross(middle, force)) / self.load_size**2
        return np.asarray(middle + aside if np.linalg.norm(aside) < self.size else middle)

    def _make_moment_arcs(self) -> dict[int, RotationArc]:
        """Of soft fingers on the object, about their normals, behind the contact."""
        s, scene = self.solution, self.grasp.scene
        if not s.held or s.torsion is None:
            return {}
        largest, turns = float(abs(s.torsion).max(initial=0.0)), {}
        for i in np.flatnonzero(abs(s.torsion) > max(MIN_DRAWN_MOMENT, 1e-3 * largest)).tolist():
            normal, m = scene.frames[i, :, 2] / np.linalg.norm(scene.frames[i, :, 2]), float(s.torsion[i])
            centre = scene.positions[i] - 0.22 * self.size * normal
            turns[i] = RotationArc(centre, normal * np.sign(m), 0.2 * self.size, abs(m) / largest)
        return turns

    @cached_property
    def escape_motion(self) -> tuple[Array, Array] | None:
        """Shift [m] and turn [rad] of the object as it escapes, so large that it is seen, where the load acts; None
        where no such motion is known.
        """
        twist, at = self.solution.certificate, self.acts_at
        if twist is None or not np.isfinite(twist).all() or not twist.any():
            return None
        move, turn = twist[:3] + np.cross(twist[3:], at - self.grasp.reference), twist[3:]
        far = max(float(np.linalg.norm(move)), self.size * float(np.linalg.norm(turn)))
        return move * self.size / far, turn * self.size / far

    def _make_slip_arrows(self) -> tuple[dict[int, Array], float]:
        """Slips of the object on the fingers, magnified."""
        s, amount = self.solution, np.hypot(*self.solution.slip.T)
        moving = [i for i in self.sliding_contacts if amount[i] > words.NEGLIGIBLE_LENGTH]
        if not moving:
            return {}, 1.0
        factor = nice_number(0.7 * self.size / float(amount[moving].max()))
        return {i: self.grasp.frames[i][:, :2] @ s.slip[i] * factor for i in moving}, factor

    def _moved_triangles(self) -> Array | None:
        """Triangles of the object after its motion; None where that is too small to be seen, or not a small one."""
        if self.object_body is None:
            return None
        u, at = self.solution.object_displacement, self.grasp.reference
        before = self.object_body.triangles.reshape(-1, 3)
        after = (before - at) @ pin.exp3(u[3:]).T + at + u[:3]
        far = float(np.linalg.norm(after - before, axis=1).max()) / self.size
        return after.reshape(-1, 3, 3) if _VISIBLE_MOTION_RANGE[0] < far < _VISIBLE_MOTION_RANGE[1] else None

    @cached_property
    def camera(self) -> Camera:
        """From where most can be seen."""
        return choose_camera(self.grasp, self.solids, self.object_body, self.screen_marks())

    @property
    def sliding_contacts(self) -> list[int]:
        """Contacts that slide, in an equilibrium."""
        return [i for i, status in enumerate(self.statuses) if status == SLIDING]

    @cached_property
    def drawn_contacts(self) -> list[int]:
        """Contacts that are drawn: all, but of those on links the ones that press. Many never touch."""
        return [i for i, status in enumerate(self.statuses) if status != SEPARATED or not self.grasp.spec.links]

    def screen_marks(self) -> ScreenMarks:
        """What should lie apart in the picture."""
        positions = self.grasp.scene.positions
        share = np.linspace(0.0, 1.0, _ARROW_POINTS)[:, None]
        forces = positions[:, None] + 0.5 * share * self.force_arrows[:, None]
        if self.load_size == 0.0:
            return ScreenMarks(positions, np.zeros((0, 3)), forces)
        pull = self.acts_at + share * self.load_arrow
        return ScreenMarks(np.vstack([positions, pull[[0, -1]]]), pull, forces)

    def extent_points(self) -> Array:
        """(k, 3) points that the picture must contain: arrows, arcs, cones, fingertips."""
        scene = self.grasp.scene
        points = [scene.positions, scene.positions + self.force_arrows]
        points += [self.acts_at + self.load_arrow, self.acts_at + self.escape_arrow]
        points += [self.cone_rim(i) for i in range(scene.n) if self.cone_height(i) > 0.0]
        arcs = self.torque_arc, self.escape_arc, *self.moment_arcs.values()
        points += [arc.extent_points() for arc in arcs if arc is not None]
        points += [scene.positions[i] + slip for i, slip in self.slip_arrows.items()]
        points += [t.reshape(-1, 3) for t in (self.moved_object, *self.tip_triangles) if t is not None]
        return np.vstack(points)

    def are_hidden(self, before: Array) -> Bools:
        """(n,) which contact points the viewer sees through the object, or not at all. before (n, 2) : how far before
        them the nearest solid is, and the object [m].
        """
        known = (
            self.object_body is not None and self.object_body.label == "object"
        )  # the hull of the contacts hides none
        most = self.size * np.array([_MAX_SOLID_DEPTH, _MAX_OBJECT_DEPTH if known else np.inf])
        return np.asarray((before > most).any(axis=1))

    def cone_rim(self, i: int) -> Array:
        """(k, 3) of a contact's friction cone."""
        scene, height = self.grasp.scene, self.cone_height(i)
        mu, planar = float(scene.mu[i]), scene.plane is not None
        return friction_cone_rim(scene.positions[i], scene.frames[i], height, mu, planar)

    def cone_height(self, i: int) -> float:
        """Height of a friction cone [m], whose rim is the friction limit of the drawn force; 0: no cone."""
        scene, s = self.grasp.scene, self.solution
        height = float(s.forces[i, 2]) * self.per_newton if s.held else 0.5 * self.size
        return height if scene.mu[i] > 0 and height > 0.02 * self.size and scene.n <= MAX_CONTACTS_WITH_CONES else 0.0


def _make_arc(centre: Array, vector: Array, radius: float, least: float) -> RotationArc | None:
    """About a vector (3,) [N·m, or rad]; None where it is no longer than `least`."""
    much = float(np.linalg.norm(vector))
    return RotationArc(centre, vector / much, radius) if much > least else None
