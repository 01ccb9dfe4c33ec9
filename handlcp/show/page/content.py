"""Everything that a page shows besides its words: solids, frames, legend, view."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array
from handlcp.geometry.distance import outermost_points, spread_directions
from handlcp.grasp import Grasp, Loading
from handlcp.grasp.path.events import summary
from handlcp.show.page.frames import Frames, Snapshot, steps_shown
from handlcp.show.page.meshes import FIXED, Meshes, Part, notes_of, parts_of
from handlcp.show.picture.bodies import HAND, Body
from handlcp.show.picture.camera import camera_for
from handlcp.show.picture.content import ESCAPE, LOAD, NO_MOMENT, SLIP, STATE, UNKNOWN, Content
from handlcp.show.picture.shapes import hull_of, placed


def content(
    drawn: Content,
    shown: Sequence[Snapshot],
    path: dict[str, Any] | None,
    escape: dict[str, Any] | None,
    meshes: Meshes | None = None,
) -> dict[str, Any]:
    """What the viewer reads; numbers are in SI units, vectors in world axes.

    drawn : what a picture of the grasp shows. shown : one solve, then the steps. path, escape : as `path_of` and
    `escape_of` have them. meshes : where solids go, of a page of several grasps, which packs them itself.
    """
    grasp = drawn.grasp
    scene, state = grasp.scene, getattr(grasp, "state", None)
    hand = None if state is None else state.hand
    frames = Frames(shown, grasp)
    own, parts, told = meshes or Meshes(), parts_of(drawn), frames.to_list()
    return {
        "size": scene.units.length,
        "planar": scene.plane is not None,
        "perNewton": frames.per_newton,
        "slipFactor": frames.slip_factor,
        "view": view_of(drawn, parts, told[0]["joints"]),
        "parts": [packed(p, own) for p in parts],
        "packed": own.packed() if meshes is None else "",
        "frames": told,
        "columns": frames.columns,
        "contacts": _contacts(grasp),
        "joints": _joints(shown, hand),
        "colours": {**STATE, "": UNKNOWN, "load": LOAD, "slip": SLIP, "escape": ESCAPE},
        "legend": _legend(drawn, parts, shown, frames, escape is not None),
        "path": path,
        "escape": escape,
        "first": _first(told, path, escape),
        "notes": notes_of(drawn, parts),
    }


def path_of(loading: Loading, first: int) -> dict[str, Any]:
    """Stages and events beside the slider. first : number of the frame of the first step."""
    steps, kept = loading.steps, np.array(steps_shown(loading))
    stage, share = steps.stage[kept], steps.share[kept]
    told = [
        {
            "frame": first + _reached(stage, share, s.number, s.share),
            "where": s.where,
            "says": s.sentence,
            "lost": False,
        }
        for s in summary(loading.events, steps.grasp.spec)
    ]
    if not loading.reached:
        at = words.percent(loading.lost_at or 0.0)
        why = loading.why.removeprefix(f"lost in stage {loading.lost_stage!r} at {at}: ")
        end = {"frame": first + len(kept) - 1, "where": f"{loading.lost_stage}, {at}", "says": f"lost: {why}"}
        told.append(end | {"lost": True})
    ends = [first + _reached(stage, share, k, 1.0) for k in range(len(loading.stages))]
    stages = [{"name": n, "end": e} for n, e in zip(loading.stages, ends, strict=True)]
    return {"first": first, "stages": stages, "events": told, "held": loading.held}


def escape_of(drawn: Content) -> dict[str, Any] | None:
    """The motion in which the object escapes; None where none is known."""
    if drawn.way_out is None:
        return None
    move, turn = drawn.way_out
    return {"at": drawn.acts_at, "move": move, "turn": turn}


def _first(frames: Sequence[Any], path: dict[str, Any] | None, escape: dict[str, Any] | None) -> int:
    """The frame that is shown first: the end of the loading, which the verdict is about; else the one solve."""
    return 0 if path is None or (path["first"] == 1 and escape is not None) else len(frames) - 1


def _reached(stage: Any, share: Any, number: int, where: float) -> int:
    """The first kept step at or behind a place; the last one where there is none."""
    behind = np.flatnonzero((stage > number) | ((stage == number) & (share >= where - 1e-9)))
    return int(behind[0]) if len(behind) else len(stage) - 1


def packed(p: Part, meshes: Meshes) -> dict[str, Any]:
    """A solid as the viewer reads it."""
    return {**meshes.add(p.triangles), "colour": p.colour, "layer": p.layer, "joint": p.joint}


def _contacts(grasp: Grasp) -> list[dict[str, Any]]:
    """Names, and the half-axes of the friction cones."""
    fingers = grasp.scene.n - grasp.scene.environment
    found = []
    for i, (name, contact) in enumerate(zip(grasp.names, grasp.contacts, strict=True)):
        mu, scale = float(grasp.scene.mu[i]), (1.0, 1.0)
        if grasp.scene.plane is None:
            mu, scale = contact.mu, contact.friction.scale
        found.append({"name": name, "mu": [mu * scale[0], mu * scale[1]], "environment": i >= fingers})
    return found


def _joints(shown: Sequence[Snapshot], hand: Any) -> list[dict[str, Any]]:
    """Names and limits of the joints: None for one that is not known; no joints where there are no torques."""
    if hand is None or all(s.torques is None for s in shown):
        return []
    limits = np.where(np.isfinite(hand.torque_limits), hand.torque_limits, np.nan)
    return [{"name": n, "limit": x} for n, x in zip(hand.joint_names, limits.tolist(), strict=True)]


def view_of(drawn: Content, parts: Sequence[Part], joints: list[list[float]] | None) -> dict[str, Any]:
    """The direction of the pictures; up: the axis about which the view turns. joints : their poses at first."""
    moved = [pin.XYZQUATToSE3(np.array(m)) for m in joints or ()]
    hulls = [(p, _hull(p.triangles)) for p in parts]
    bodies = [(p, Body(h if p.joint == FIXED else placed(h, moved[p.joint]), p.colour)) for p, h in hulls]
    hiding = [body for p, body in bodies if p.layer != "object"]
    glass = next((body for p, body in bodies if p.layer == "object"), None)
    camera = camera_for(drawn.grasp, hiding, glass, drawn.marks())
    axis = int(np.argmax(abs(camera.axes[1])))
    return {"axes": camera.axes, "up": np.eye(3)[axis] * np.sign(camera.axes[1][axis])}


def _hull(triangles: Array) -> Array:
    """(k, 3, 3) a convex hull of the outermost points in 60 directions; the triangles where these lie in a plane."""
    made = hull_of(outermost_points(triangles.reshape(-1, 3), spread_directions(60, 0.5)))
    return triangles if made is None else made


def layers_of(parts: Sequence[Part], names: dict[str, str]) -> list[Any]:
    """A line of the legend for each layer of solids. names : of layers that are called otherwise than themselves."""
    colours = {p.layer: HAND if p.layer == "hand" else p.colour for p in parts}
    names = {"tips": "shape that finds the contact"} | names
    return [[layer, "patch", list(colour), names.get(layer, layer)] for layer, colour in colours.items()]


def _legend(
    drawn: Content, parts: Sequence[Part], shown: Sequence[Snapshot], frames: Frames, escapes: bool
) -> list[Any]:
    """Lines of (layer, kind, colour, text); each layer can be switched off."""
    grasp = drawn.grasp
    who = grasp.spec.who
    states = {state for s in shown for state in s.states}
    deep, links = words.length(max(drawn.inside.values(), default=0.0)), list(drawn.inside)
    inside = f"inside the object: {f'{links[0]},' if len(links) == 1 else f'{len(links)} links, up to'} {deep}"
    names = {
        "hand": "hand" if hasattr(grasp, "state") else "fingers",
        "inside": inside,
        "object": "object" if drawn.glass is None else drawn.glass.label,
    }
    out = layers_of(parts, names)
    if (grasp.scene.mu > 0).any():
        sense = "friction cones, to the forces’ scale: an arrow at the rim slides"
        out.append(["cones", "cone", STATE["sticking"], sense if states != {""} else "friction cones"])
    for state in ("sticking", "sliding"):
        if state in states:
            out.append(["forces", "arrow", STATE[state], f"{who} force, {state}"])
    if "separated" in states:
        out.append(["forces", "dot", STATE["separated"], f"{who} that does not touch"])
    if frames.turns:
        out.append(["forces", "turn", STATE["sticking"], f"moment of a {who} about its normal"])
    if any(s.load.any() for s in shown):
        out.append(["load", "arrow", LOAD, "load on the object, weight included"])
    if any(float(np.linalg.norm(s.moment)) > NO_MOMENT for s in shown):
        out.append(["load", "turn", LOAD, "torque of the load"])
    if frames.slip_factor:
        times = frames.slip_factor
        text = f"× {times:g}" if times >= 1 else f"÷ {1 / times:g}"
        far = f" (it slides up to {words.length(frames.slides)})" if frames.slides > words.NOTHING else ""
        out.append(["slips", "arrow", SLIP, f"slip of the object, {text}{far}"])
    if escapes:
        out.append(["escape", "dashed", ESCAPE, "the way the object escapes"])
    out.append(["labels", "text", UNKNOWN, "names; normal force + friction"])
    return out
