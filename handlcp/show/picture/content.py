"""What the picture of a solved grasp shows: solids, arrows and their scale, colours, text."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution
from handlcp.show.picture.bodies import environment_bodies, hand_bodies, object_body, stub_bodies
from handlcp.show.picture.overlay import nice
from handlcp.show.picture.panel import Entry
from handlcp.show.style import BLUE, PURPLE, RED

__all__ = ["ESCAPE", "LOAD", "SLIP", "Content"]

STATE = {"sticking": BLUE, "sliding": RED, "separated": "#6E6E6E"}
UNKNOWN, LOAD, SLIP, ESCAPE = "#6E6E6E", "#1A1A1A", PURPLE, RED
LONGEST = 0.8  # the longest force arrow, in sizes of the grasp
_NO_MOMENT = 5e-6  # [N·m] moments below are not written


class Content:
    """All vectors are in world axes; an arrow that is not drawn is zero. around : the grasp whose environment is drawn;
    None: this one.

    solids, glass : opaque bodies, and the translucent object or None. colours : (n) by contact state.
    per_newton : length of a force arrow [m/N]. forces (n, 3) : their arrows [m]. load [N] and its arrow `pull` [m].
    escape : arrow of the motion in which the object escapes [m]. acts_at (3,) : where the arrows on the object start.
    slips : contact → arrow of its slip [m], where it slides. slip_note : their line in the legend.
    """

    def __init__(self, grasp: Grasp, solution: GraspSolution, obj: Any, around: Grasp | None = None) -> None:
        self.grasp, self.solution, scene, s = grasp, solution, grasp.scene, solution
        state, size = getattr(grasp, "state", None), scene.units.length
        solids = hand_bodies(state) if state is not None else stub_bodies(grasp)
        self.solids = [*solids, *environment_bodies(grasp if around is None else around)]
        self.glass = object_body(grasp, obj)
        self.colours = [STATE[state] if s.held else UNKNOWN for state in s.contact_state]
        self.acts_at = grasp.reference
        if obj is None and getattr(grasp, "target", None) is None:
            self.acts_at = scene.positions.mean(0)
            if self.glass is not None:
                self.acts_at = self.glass.triangles.reshape(-1, 3).mean(0)
        self.load = float(np.linalg.norm(scene.force))
        forces = s.forces_world if s.held else np.zeros((scene.n, 3))
        strongest = float(np.linalg.norm(forces, axis=1).max(initial=0.0))
        self.per_newton = LONGEST * size / (max(strongest, 0.6 * self.load) or 1.0)
        self.forces, self.pull = forces * self.per_newton, scene.force * self.per_newton
        self.escape = np.zeros(3)
        if s.certificate is not None and (move := float(np.linalg.norm(s.certificate[:3]))) > 0:
            self.escape = s.certificate[:3] / move * 1.2 * size
        self.slips, self.slip_note = self._slips()

    def _slips(self) -> tuple[dict[int, Array], str]:
        """Slips of the object on the fingers, magnified."""
        s, amount = self.solution, np.hypot(*self.solution.slip.T)
        moving = [i for i, state in enumerate(s.contact_state) if state == "sliding" and amount[i] > words.NOTHING]
        if not moving or not s.held:
            return {}, ""
        largest = float(amount[moving].max())
        factor = nice(0.45 * self.grasp.scene.units.length / largest)
        times = f"× {factor:g}" if factor >= 1 else f"÷ {1 / factor:g}"
        arrows = {i: self.grasp.frames[i][:, :2] @ s.slip[i] * factor for i in moving}
        return arrows, f"slip of the object, {times}\n(up to {words.length(largest)})"

    def marks(self) -> Array:
        """(k, 3) points that should lie apart in the picture."""
        positions = self.grasp.scene.positions
        return np.vstack([positions, [self.acts_at, self.acts_at + self.pull]]) if self.load > 0 else positions

    def reach(self) -> Array:
        """(k, 3) points that the picture must contain: both ends of all arrows."""
        positions = self.grasp.scene.positions
        on_object = [self.acts_at + self.pull, self.acts_at + self.escape]
        return np.vstack([positions, positions + self.forces, on_object])

    def cone_height(self, i: int) -> float:
        """Height of a friction cone [m], whose rim is the friction limit of the drawn force; 0: no cone."""
        scene, s, size = self.grasp.scene, self.solution, self.grasp.scene.units.length
        height = float(s.forces[i, 2]) * self.per_newton if s.held else 0.5 * size
        return height if scene.mu[i] > 0 and height > 0.02 * size else 0.0

    def detail(self, i: int) -> str:
        """What a contact's label says below its name."""
        s = self.solution
        if not s.held:
            return f"μ = {self.grasp.contacts[i].mu:g}" if self.grasp.contacts[i].mu else "frictionless"
        if s.contact_state[i] == "separated":
            return f"lets go, gap {words.length(float(s.gap[i]))}"
        push = words.force(float(np.linalg.norm(s.forces[i])))
        # A moment is written in place of the state, which the colour shows: a longer line would shrink the picture
        if s.torsion is not None and abs(s.torsion[i]) > _NO_MOMENT:
            return f"{push}, {words.torque(abs(float(s.torsion[i])))}"
        return f"{push}, {'sticks' if s.contact_state[i] == 'sticking' else 'slides'}"

    def entries(self) -> list[Entry]:
        s, grasp, out = self.solution, self.grasp, []
        who = "contact" if grasp.scene.environment else "finger"
        if self.glass is not None:
            out.append(("patch", "#C08A2B", self.glass.label))
        for state in ("sticking", "sliding"):
            if s.held and state in s.contact_state:
                out.append(("line", STATE[state], f"{who} force, {state}"))
        if s.held and "separated" in s.contact_state:
            out.append(("dot", STATE["separated"], f"{who} that lets go"))
        if (grasp.scene.mu > 0).any():
            sense = "moments take their part of it" if s.torsion is not None else "an arrow at its rim slides"
            text = f"friction cone, to the forces' scale:\n{sense}" if s.held else "friction cone"
            out.append(("cone", STATE["sticking"] if s.held else UNKNOWN, text))
        moment = float(np.linalg.norm(grasp.scene.moment - np.cross(grasp.reference, grasp.scene.force)))
        twist = f"torque of {words.torque(moment)}"
        if self.load > 0:
            also = f"\nand a {twist}" if moment > 1e-9 else ""
            out.append(("line", LOAD, f"load on the object, {words.force(self.load)}{also}"))
        elif moment > 1e-9:
            out.append(("line", "white", f"load on the object: a {twist}"))
        if self.slip_note:
            out.append(("line", SLIP, self.slip_note))
        if s.certificate is not None:
            out.append(("dashed", ESCAPE, "the way the object escapes"))
        return out
