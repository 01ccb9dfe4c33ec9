"""The page of an envelope: the hand, and around the object the surface of what it holds, to turn and to point at."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.show.envelope.sight import facing
from handlcp.show.envelope.surface import Surface, borders, surface_of, wires
from handlcp.show.page import file
from handlcp.show.page.content import packed, view_of
from handlcp.show.page.document import Own, document, web_files
from handlcp.show.page.frames import Frames
from handlcp.show.page.meshes import Meshes, notes_of, parts_of
from handlcp.show.page.snapshot import of_solution
from handlcp.show.picture.bodies import HAND
from handlcp.show.picture.content import Content
from handlcp.study.envelope import Envelope, Extreme
from handlcp.study.envelope.printed import amount, direction, geometry, given_away, headline

_OWN = ("stage.html", "tables.html", "envelope.css", "ball.js", "envelope.js")
_SHARED = ("solids.js", "marks.js", "labels.js", "view.js", "panel.js")
_REACH = 2.2  # of the surface, in sizes of the grasp
_AROUND = {
    "force": "How large a force on the object the grasp holds, in each direction.",
    "torque": "How large a torque on the object the grasp holds, about each direction.",
    "gravity": "How heavy the object may be, with gravity in each direction.",
}  # fmt: skip


def save(env: Envelope, path: Any, title: str = "") -> Path:
    """Write the page. Raises InputError for a file that cannot be written, and for directions that do not lie all
    around; Unsupported without trimesh.
    """
    target = file.checked(path)
    if not len(env.triangles):
        raise InputError("directions", "directions all around, for a page", f"{len(env.factors)} that do not lie so")
    stage, tables, style, *scripts = web_files(*_OWN, package="handlcp.show.envelope")
    own = Own(stage, tables, style, [*web_files(*_SHARED), *scripts, *web_files("opened.js")])
    text = document(title, _said(env), _content(env), own)
    return file.write(text, target)


def _said(env: Envelope) -> str:
    """Weakest direction, and what compliance gives away."""
    lines = [headline(env), given_away(env), geometry(env)]
    items = "".join(f"<li>{escape(f'{line[:1].upper()}{line[1:]}.')}</li>" for line in lines if line)
    return f'<ul class="reasons">{items}</ul>'


def _content(env: Envelope) -> dict[str, Any]:
    """What the viewer reads."""
    grasp, s = env.grasp, surface_of(env)
    solution = grasp.solve(throw=False)
    drawn, state = Content(grasp, solution, None), getattr(grasp, "state", None)
    of_hand = (None, None) if state is None else (state.hand.model, state.hand.kinematics)
    frame = Frames([of_solution(grasp, solution, drawn.acts_at)], grasp.scene.units.length, *of_hand).to_list()[0]
    meshes, parts = Meshes(), parts_of(drawn)
    layers = {p.layer: HAND if p.layer == "hand" else p.colour for p in parts}
    names = {"hand": "hand", "object": "object", "environment": "environment", "inside": "links inside the object",
             "tips": "fingertip that finds the contact"}  # fmt: skip
    legend = [[layer, "patch", list(colour), names[layer]] for layer, colour in layers.items()]
    surface = _surface(env, s, drawn)
    keys = [[f"key{k}", "patch", key.colour, f"{key.says}, {words.percent(key.share)}"] for k, key in enumerate(s.keys)]
    if len(surface["wires"]):
        keys.append(["bound", "wire", "#222222", "without compliance: friction and torque limits alone"])
    notes = [_AROUND[env.of], *notes_of(drawn, parts)]
    if s.cut:
        notes.append(f"The surface is cut at {s.reach:g} {env.unit}: what reaches farther is drawn there.")
    return {
        "size": grasp.scene.units.length, "parts": [packed(p, meshes) for p in parts], "packed": meshes.packed(),
        "view": _view(env, s, drawn, view_of(drawn, parts, frame["joints"])),
        "frame": {k: frame[k] for k in ("joints", "object")},
        "legend": [*keys, *legend, ["labels", "text", "#5f5f5f", "the weakest direction, and axes"]],
        "surface": surface, "notes": notes, "colours": {}, "frames": [],
    }  # fmt: skip


def _view(env: Envelope, s: Surface, drawn: Content, usual: dict[str, Any]) -> dict[str, Any]:
    """The usual view, turned so that the weakest direction is seen."""
    factor = env.weakest.factor
    if not 0.0 < factor < np.inf:
        return usual
    centre, scale = _placed(env, s, drawn)
    points = scale * s.points
    solids = [b.triangles for b in drawn.solids] + [centre + points[s.cells]]
    axes = facing(points[env.weakest.number], usual["axes"], usual["up"], centre, np.concatenate(solids))
    return usual | {"axes": axes}


def _placed(env: Envelope, s: Surface, drawn: Content) -> tuple[Array, float]:
    """Centre of the surface (3,) [m], and metres for a unit of the factors."""
    at = env.question.load.at
    return (at if np.isfinite(at).all() else drawn.acts_at), _REACH * drawn.size / s.reach


def _surface(env: Envelope, s: Surface, drawn: Content) -> dict[str, Any]:
    """Lengths in metres about the centre; what each direction says."""
    centre, scale = _placed(env, s, drawn)
    lines = wires(s) if s.bound_beyond else np.zeros((0, 2, 3))
    return {
        "centre": centre, "scale": scale, "reach": _REACH * drawn.size, "points": scale * s.points, "cells": s.cells,
        "key": s.key, "colours": [key.colour for key in s.keys], "wires": (scale * lines).reshape(-1, 6),
        "borders": (scale * borders(s)).reshape(-1, 6),
        "directions": env.directions, "cause": env.cause, "causes": [cause.says for cause in env.causes],
        "held": [_short(env, x) for x in env.factors], "bound": [_short(env, x) for x in env.bound],
        "rows": _rows(env), "row_colours": _colours(s, len(env.causes)),
        "columns": ["gives out first", "share", f"least\n{env.unit}", f"median\n{env.unit}"],
        "weakest": _mark(env, env.weakest, scale * s.points), "strongest": _mark(env, env.strongest, scale * s.points),
    }  # fmt: skip


def _rows(env: Envelope) -> list[list[str]]:
    """Of the table of causes."""
    return [[c.says, words.percent(c.share), _number(c.least), _number(c.median)] for c in env.causes]


def _colours(s: Surface, causes: int) -> list[str]:
    """Of each cause."""
    of = {k: key.colour for key in s.keys for k in key.causes}
    return [of[k] for k in range(causes)]


def _mark(env: Envelope, extreme: Extreme, points: Array) -> dict[str, Any]:
    says = f"{amount(env, extreme.factor)} along {direction(extreme.direction)}"
    return {"at": points[extreme.number], "says": says}


def _short(env: Envelope, factor: float) -> str:
    return _number(factor) if not np.isfinite(factor) else f"{factor:.3g} {env.unit}"


def _number(factor: float) -> str:
    return "any" if np.isinf(factor) else "undecided" if np.isnan(factor) else f"{factor:.3g}"
