"""One picture of a solved grasp: hand, object, friction cones, forces, slips, load, verdict.

An orthographic view; a planar scene is seen along its normal. The cones stand to the scale of the forces: a finger
slides when its arrow reaches the rim. (matplotlib's 3D axes clip, sort whole collections and draw nothing over them, so
projection and hidden surfaces are made here.)
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution
from handlcp.hand import HandGrasp
from handlcp.show import labels, units
from handlcp.show.bodies import Body, environment_bodies, hand_bodies, object_body, stub_bodies
from handlcp.show.camera import Camera, choose, facing, frame
from handlcp.show.file import checked, figure_type, write
from handlcp.show.overlay import COLOUR, ESCAPE, LOAD, SLIP, Overlay, nice, rim
from handlcp.show.painter import paint
from handlcp.show.panel import Entry, headline, legend, torque_bars

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw", "save"]

WIDTH, HEIGHT, DPI = 10.0, 6.6, 160
SCENE = 0.70  # of the width; the rest is the panel
LONGEST = 0.8  # the longest force arrow, in sizes of the grasp


def save(grasp: Grasp, solution: GraspSolution, path: Any, obj: Any = None, title: str = "") -> Path:
    """Draw and write a file; see `draw`. Raises InputError for a format or a place that will not do."""
    file = checked(path)
    return write(draw(grasp, solution, obj, title), file, DPI)


def draw(grasp: Grasp, solution: GraspSolution, obj: Any = None, title: str = "") -> Figure:
    """The figure. obj : what to draw as the object when the grasp does not know it; None: the hull of the contacts.

    Raises Unsupported when matplotlib is not installed.
    """
    figure: Figure = figure_type()(figsize=(WIDTH, HEIGHT))
    head = headline(figure, grasp, solution, title)
    entries = _Scene(figure, grasp, solution, obj, head).entries()
    bottom = legend(figure, 0.722, head - 0.03, entries)
    if solution.held and (check := getattr(solution, "torque_check", None)) is not None:
        torque_bars(figure, (0.725, 0.25), bottom - 0.055, check)
    return figure


class _Scene:
    """The picture proper, drawn when made."""

    def __init__(self, figure: Figure, grasp: Grasp, solution: GraspSolution, obj: Any, head: float) -> None:
        self.grasp, self.solution, s, scene = grasp, solution, solution, grasp.scene
        state, size = getattr(grasp, "state", None), scene.units.length
        solids = hand_bodies(state) if state is not None else stub_bodies(grasp)
        solids = [*solids, *environment_bodies(grasp)]
        self.glass = object_body(grasp, obj)
        self.load = float(np.linalg.norm(scene.force))
        described = obj is not None or getattr(grasp, "target", None) is not None
        middle = scene.positions.mean(0)
        self.centre = middle if self.glass is None else self.glass.triangles.reshape(-1, 3).mean(0)
        self.acts_at = grasp.reference if described else self.centre
        self.colours = [COLOUR[state if s.held else "unknown"] for state in s.contact_state]
        self.forces = s.forces_world if s.held else np.zeros((scene.n, 3))
        strength = np.linalg.norm(self.forces, axis=1)
        self.per_newton = LONGEST * size / (max(float(strength.max(initial=0.0)), 0.6 * self.load) or 1.0)
        escape = np.zeros(3)
        if s.certificate is not None and (move := float(np.linalg.norm(s.certificate[:3]))) > 0:
            escape = s.certificate[:3] / move * 1.2 * size
        pull = scene.force * self.per_newton
        tips = scene.positions + self.forces * self.per_newton
        reach = np.vstack([scene.positions, tips, [self.acts_at + pull, self.acts_at + escape]])

        marks = np.vstack([scene.positions, [self.acts_at, self.acts_at + pull]]) if self.load > 0 else scene.positions
        camera = _camera(grasp, solids, self.glass, marks)
        ax = figure.add_axes((0.005, 0.01, SCENE, head - 0.02))
        inches = (WIDTH * SCENE, HEIGHT * (head - 0.02))
        margin = min(0.30 + labels.width(figure, s.names, [self._detail(i) for i in range(scene.n)]), 0.35 * inches[0])
        view = frame(camera, solids, self.glass, reach, inches, margin)
        ax.axis("off")
        paint(ax, camera, solids, self.glass, view, DPI)
        over = Overlay(ax, camera, view.inch)
        self._cones(over)
        if self.load > 0:
            over.arrow(self.acts_at, pull, LOAD, 1.15)
        for p, f, colour in zip(scene.positions, self.forces, self.colours, strict=True):
            over.arrow(p, f * self.per_newton, colour)
            over.dot(p, colour)
        self.slip_note = self._slips(over) if s.held else ""
        if escape.any():
            over.arrow(self.acts_at, escape, ESCAPE, 1.5, dashed=True)
        self._labels(ax, camera, view)
        corner = np.array([view.box[0], view.box[2]])
        over.triad(corner + np.array([0.56, 0.42]) * view.inch)
        bar = nice(1.1 * view.inch)
        over.scale_bar(corner + np.array([1.25, 0.22]) * view.inch, bar, units.length(bar))
        if s.held or self.load > 0:
            amount = nice(0.65 * view.inch / self.per_newton)
            start = corner + np.array([1.65 * view.inch + bar, 0.22 * view.inch])
            over.force_scale(start, amount * self.per_newton, units.force(amount))
        ax.set_xlim(view.box[:2])
        ax.set_ylim(view.box[2:])

    def _cones(self, over: Overlay) -> None:
        """As high as the normal force is long, so that the rim is the friction limit."""
        scene, s, size = self.grasp.scene, self.solution, self.grasp.scene.units.length
        for i, p in enumerate(scene.positions):
            height = float(s.forces[i, 2]) * self.per_newton if s.held else 0.5 * size
            if scene.mu[i] > 0 and height > 0.02 * size:
                edge = rim(p, scene.frames[i], height, float(scene.mu[i]), scene.plane is not None)
                over.cone(p, edge, self.colours[i])

    def _slips(self, over: Overlay) -> str:
        """Arrows of the object's slip on the fingers, exaggerated; returns what the legend says about them."""
        s, scene = self.solution, self.grasp.scene
        amount = np.hypot(*s.slip.T)
        moving = [i for i, state in enumerate(s.contact_state) if state == "sliding" and amount[i] > units.NOTHING]
        if not moving:
            return ""
        largest = float(amount[moving].max())
        factor = nice(0.45 * scene.units.length / largest)
        for i in moving:
            over.arrow(scene.positions[i], self.grasp.frames[i][:, :2] @ s.slip[i] * factor, SLIP, 0.85)
        times = f"× {factor:g}" if factor >= 1 else f"÷ {1 / factor:g}"
        return f"slip of the object, {times}\n(up to {units.length(largest)})"

    def _labels(self, ax: Any, camera: Camera, view: Any) -> None:
        points = camera.project(self.grasp.scene.positions)
        rows = zip(points, self.solution.names, self.colours, strict=True)
        labels.place(ax, [labels.Label(p, n, self._detail(i), c) for i, (p, n, c) in enumerate(rows)], view)

    def _detail(self, i: int) -> str:
        s = self.solution
        if not s.held:
            return f"μ = {self.grasp.contacts[i].mu:g}" if self.grasp.contacts[i].mu else "frictionless"
        if s.contact_state[i] == "separated":
            return f"lets go, gap {units.length(float(s.gap[i]))}"
        push = units.force(float(np.linalg.norm(s.forces[i])))
        # A moment takes the place of the state, which the colour says: a longer line costs the picture
        if s.torsion is not None and abs(s.torsion[i]) > _NO_MOMENT:
            return f"{push}, {units.torque(abs(float(s.torsion[i])))}"
        return f"{push}, {'sticks' if s.contact_state[i] == 'sticking' else 'slides'}"

    def entries(self) -> list[Entry]:
        """The legend."""
        s, grasp, out = self.solution, self.grasp, []
        who = "contact" if grasp.scene.environment else "finger"
        if self.glass is not None:
            out.append(("patch", "#C08A2B", self.glass.label))
        for state in ("sticking", "sliding"):
            if s.held and state in s.contact_state:
                out.append(("line", COLOUR[state], f"{who} force, {state}"))
        if s.held and "separated" in s.contact_state:
            out.append(("dot", COLOUR["separated"], f"{who} that lets go"))
        if (grasp.scene.mu > 0).any():
            sense = "moments take their part of it" if s.torsion is not None else "an arrow at its rim slides"
            text = f"friction cone, to the forces' scale:\n{sense}" if s.held else "friction cone"
            out.append(("cone", COLOUR["sticking" if s.held else "unknown"], text))
        moment = float(np.linalg.norm(grasp.scene.moment - np.cross(grasp.reference, grasp.scene.force)))
        twist = f"torque of {units.torque(moment)}"
        if self.load > 0:
            also = f"\nand a {twist}" if moment > 1e-9 else ""
            out.append(("line", LOAD, f"load on the object, {units.force(self.load)}{also}"))
        elif moment > 1e-9:
            out.append(("line", "white", f"load on the object: a {twist}"))
        if self.slip_note:
            out.append(("line", SLIP, self.slip_note))
        if s.certificate is not None:
            out.append(("dashed", ESCAPE, "the way the object escapes"))
        return out


_NO_MOMENT = 5e-6  # [N·m] what a label does not mention


def _camera(grasp: Grasp, solids: list[Body], glass: Body | None, marks: Array) -> Camera:
    scene = grasp.scene
    pull = float(np.linalg.norm(scene.force))
    if scene.plane is not None:
        normal = scene.plane * (1.0 if scene.plane[int(np.argmax(abs(scene.plane)))] > 0 else -1.0)
        up = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
        above = _upwards(-scene.force / pull) if pull > 0 else up
        return facing(normal, up if abs(above @ normal) > 0.9 else above)  # an askew load's z may be where we look from
    down = scene.force
    if isinstance(grasp, HandGrasp) and grasp.target is not None and grasp.target.mass > 0.0:
        down = grasp.given_gravity if grasp.given_gravity.any() else down  # what hangs, hangs, however it is pushed
    pull = float(np.linalg.norm(down))
    up = _upwards(-down / pull) if pull > 0 else np.array([0.0, 0.0, 1.0])
    return choose(marks, scene.frames[:, :, 2], solids, glass, up, scene.units.length)


def _upwards(up: Array) -> Array:
    """Loads along an axis point down the page, whatever the hand calls that axis; askew ones do not tilt the hand."""
    axis = int(np.argmax(abs(up)))
    return np.asarray(np.eye(3)[axis] * np.sign(up[axis])) if abs(up[axis]) > 0.95 else np.array([0.0, 0.0, 1.0])
