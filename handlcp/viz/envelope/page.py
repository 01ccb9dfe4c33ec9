"""`write_envelope_page`: the page of an envelope, the surface of what a hand holds around the object."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.studies.envelope import Envelope, Extreme
from handlcp.studies.envelope.result import format_direction, format_factor
from handlcp.viz.envelope.figure import envelope_sentences
from handlcp.viz.envelope.surface import EnvelopeSurface, border_lines, bound_lines, make_surface
from handlcp.viz.output_file import check_page_path
from handlcp.viz.page.document import legend_layers, solid_data, view_data, write_viewer_page
from handlcp.viz.page.frame import PageFrames, snapshot_of_solution
from handlcp.viz.page.mesh import MeshPack, drawing_notes, make_parts
from handlcp.viz.picture import camera
from handlcp.viz.picture.content import PictureContent

# ----------------------------------------------------------------
# From where the page is seen at first: so that the weakest direction is in sight.
#
# The surface has one point along each direction. So no part of it hides a point from a viewer far out along its own
# direction. A little from the side one also sees how far out the point is; there parts of the surface may hide it, and
# the hand may do so anywhere.

_VIEW_TILTS = (15.0, 30.0, 45.0)  # [degrees] from the direction itself
_VIEWS_AROUND = 12
_MAX_ELEVATION = 78.0  # [degrees] above or below: seen from the very top nothing is upright
_OCCLUSION_MARGIN = 1.03  # of the point's distance: the surface beside it does not count as before it


def choose_view_axes(point: Array, axes: Array, up: Array, centre: Array, solids: Array) -> Array:
    """(3, 3) axes of a camera, as `Camera` has them, that sees a point (3,) of the surface, from the centre of it.

    axes (3, 3) : of the usual camera, to which this one is as near as may be. up (3,) : stays upright. solids
    (k, 3, 3) : triangles that may hide the point.
    """
    distance = float(np.linalg.norm(point))
    if not distance > 0.0:
        return axes
    way = point / distance
    usual = np.arcsin(np.clip(axes[2] @ up, -1.0, 1.0))

    def unlike(towards: Array) -> float:
        """How far from the usual height above the horizon, and half as much from the direction itself."""
        height = np.arcsin(np.clip(towards @ up, -1.0, 1.0))
        return float(abs(height - usual) + 0.5 * np.arccos(np.clip(towards @ way, -1.0, 1.0)))

    aside = np.cross(way, np.eye(3)[int(abs(way).argmin())])
    aside /= np.linalg.norm(aside)
    turns = 2.0 * np.pi * np.arange(_VIEWS_AROUND) / _VIEWS_AROUND
    around = [np.cos(turn) * aside + np.sin(turn) * np.cross(way, aside) for turn in turns]
    tilted = [np.cos(tilt) * way + np.sin(tilt) * a for tilt in np.radians(_VIEW_TILTS) for a in around]
    for towards in sorted(tilted, key=unlike):
        here = _upright_axes(towards, up)
        if here[2] @ way > 0.5 and not _is_hidden(centre + _OCCLUSION_MARGIN * point, here[2], solids):
            return here
    return _upright_axes(way, up)


def _upright_axes(towards: Array, up: Array) -> Array:
    """Axes that look against `towards`, no steeper than may be."""
    flat: Array = towards - (towards @ up) * up
    size = float(np.linalg.norm(flat))
    level = flat / size if size > 1e-9 else np.eye(3)[int(abs(up).argmin())]
    steepest = np.radians(_MAX_ELEVATION)
    angle = np.clip(np.arcsin(np.clip(towards @ up, -1.0, 1.0)), -steepest, steepest)
    return camera.camera_against(np.cos(angle) * level + np.sin(angle) * up, up).axes


def _is_hidden(point: Array, towards: Array, triangles: Array) -> bool:
    """Whether the ray from a point to the viewer meets one of the triangles (k, 3, 3) (Möller and Trumbore)."""
    a = triangles[:, 0]
    one, two = triangles[:, 1] - a, triangles[:, 2] - a
    across = np.cross(towards, two)
    det = (one * across).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        from_a = point - a
        u = (from_a * across).sum(axis=1) / det
        side = np.cross(from_a, one)
        v = side @ towards / det
        far = (two * side).sum(axis=1) / det
        met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (far > 0.0)
    return bool(met.any())


# ----------------------------------------------------------------

_SURFACE_REACH = 2.2  # of the surface, in sizes of the grasp
_LOAD_NOTES = {
    "force": "How large a force on the object the grasp holds, in each direction.",
    "torque": "How large a torque on the object the grasp holds, about each direction.",
    "gravity": "How heavy the object may be, with gravity in each direction.",
}


def write_envelope_page(env: Envelope, path: Any, title: str = "") -> Path:
    """Write the page of an envelope and return its file.

    path : a file name that ends in .html. title : heading of the page; "" for none.

    Raises InputError for a file that cannot be written, and for directions that do not lie all around; Unsupported
    without trimesh.
    """
    target = check_page_path(path)
    if not len(env.triangles):
        raise InputError("directions", "directions all around, for a page", f"{len(env.factors)} that do not lie so")
    items = "".join(f"<li>{escape(line)}</li>" for line in envelope_sentences(env))
    said, scripts = f'<ul class="reasons">{items}</ul>', ("ball.js", "envelope.js")
    return write_viewer_page(target, title, said, _envelope_data(env), "envelope", scripts)


def _envelope_data(env: Envelope) -> dict[str, Any]:
    """What the viewer reads."""
    grasp, s = env.grasp, make_surface(env)
    solution = grasp.solve(throw=False)
    drawn = PictureContent(grasp, solution, None)
    frame = PageFrames([snapshot_of_solution(grasp, solution, drawn.acts_at)], grasp).to_list()[0]
    meshes, parts = MeshPack(), make_parts(drawn)
    legend = legend_layers(parts, {"inside": "links inside the object"})
    surface = _surface_data(env, s, drawn)
    view, factor = view_data(drawn, parts, frame["joints"]), env.weakest.factor
    if 0.0 < factor < np.inf:  # turned so that the weakest direction is seen
        points, centre = surface["points"], surface["centre"]
        solids = np.concatenate([*[b.triangles for b in drawn.solids], centre + points[s.cells]])
        view["axes"] = choose_view_axes(points[env.weakest.number], view["axes"], view["up"], centre, solids)
    keys = list[list[str]]()
    for k, key in enumerate(s.keys):
        keys.append([f"key{k}", "patch", key.colour, f"{key.says}, {words.format_percent(key.share)}"])
    if len(surface["wires"]):
        keys.append(["bound", "wire", "#222222", "without compliance: friction and torque limits alone"])
    notes = [_LOAD_NOTES[env.of], *drawing_notes(drawn, parts)]
    if s.cut:
        notes.append(f"The surface is cut at {s.reach:g} {env.unit}: what reaches farther is drawn there.")
    return {
        "size": grasp.scene.units.length_unit,
        "parts": [solid_data(p, meshes) for p in parts],
        "packed": meshes.to_base64(),
        "view": view,
        "frame": {k: frame[k] for k in ("joints", "object")},
        "legend": [*keys, *legend, ["labels", "text", "#5f5f5f", "the weakest direction, and axes"]],
        "surface": surface,
        "notes": notes,
        "colours": {},
        "frames": [],
    }


def _surface_data(env: Envelope, s: EnvelopeSurface, drawn: PictureContent) -> dict[str, Any]:
    """Lengths in metres about the centre; what each direction says."""
    at, scale = env.question.load.at, _SURFACE_REACH * drawn.size / s.reach  # metres for a unit of the factors
    of = {k: key.colour for key in s.keys for k in key.causes}
    lines = bound_lines(s) if s.has_visible_bound else np.zeros((0, 2, 3))
    rows = list[list[str]]()
    for c in env.causes:
        rows.append([c.says, words.format_percent(c.share), _format_number(c.least), _format_number(c.median)])
    return {
        "centre": at if np.isfinite(at).all() else drawn.acts_at,
        "scale": scale,
        "reach": _SURFACE_REACH * drawn.size,
        "points": scale * s.points,
        "cells": s.cells,
        "key": s.cell_keys,
        "colours": [key.colour for key in s.keys],
        "wires": (scale * lines).reshape(-1, 6),
        "borders": (scale * border_lines(s)).reshape(-1, 6),
        "directions": env.directions,
        "cause": env.cause,
        "causes": [cause.says for cause in env.causes],
        "held": [_format_with_unit(env, x) for x in env.factors],
        "bound": [_format_with_unit(env, x) for x in env.bound],
        "rows": rows,
        "row_colours": [of[k] for k in range(len(env.causes))],
        "columns": ["gives out first", "share", f"least\n{env.unit}", f"median\n{env.unit}"],
        "weakest": _extreme_data(env, env.weakest, scale * s.points),
        "strongest": _extreme_data(env, env.strongest, scale * s.points),
    }


def _extreme_data(env: Envelope, extreme: Extreme, points: Array) -> dict[str, Any]:
    says = f"{format_factor(env, extreme.factor)} along {format_direction(extreme.direction)}"
    return {"at": points[extreme.number], "says": says}


def _format_with_unit(env: Envelope, factor: float) -> str:
    return _format_number(factor) if not np.isfinite(factor) else f"{factor:.3g} {env.unit}"


def _format_number(factor: float) -> str:
    return "any" if np.isinf(factor) else "undecided" if np.isnan(factor) else f"{factor:.3g}"
