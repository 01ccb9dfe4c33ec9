"""`page_data`: everything that a page shows besides its words: solids, frames, legend, view."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import check_call
from handlcp.errors import InputError, shorten_repr
from handlcp.geometry.distance import outermost_points, spread_directions
from handlcp.geometry.object import Object
from handlcp.grasp import Grasp, GraspSolution, Loading, Verdict
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, UNKNOWN
from handlcp.grasp.path.events import summary
from handlcp.hand.hand_grasp import make_grasp
from handlcp.record import to_plain
from handlcp.viz.loading.figure import describe_object_motion
from handlcp.viz.output_file import (
    check_page_path,
    read_three_js,
    read_web_files,
    script_data,
    word_class,
    write_page,
)
from handlcp.viz.page.frame import (
    PageFrames,
    Snapshot,
    choose_steps,
    snapshot_of_solution,
    snapshots_of_loading,
    status_word,
)
from handlcp.viz.page.mesh import NO_JOINT, MeshPack, PagePart, drawing_notes, make_parts
from handlcp.viz.picture.body import HAND_COLOUR, Body, convex_hull, place_triangles
from handlcp.viz.picture.camera import choose_camera
from handlcp.viz.picture.content import (
    ESCAPE_COLOUR,
    LOAD_COLOUR,
    MIN_DRAWN_MOMENT,
    SLIP_COLOUR,
    STATUS_COLOURS,
    UNKNOWN_COLOUR,
    PictureContent,
)
from handlcp.viz.solution_output import grasp_of_solution


def page_data(
    drawn: PictureContent,
    shown: Sequence[Snapshot],
    path: dict[str, Any] | None,
    escape: dict[str, Any] | None,
    meshes: MeshPack | None = None,
) -> dict[str, Any]:
    """What the viewer reads; numbers are in SI units, vectors in world axes.

    drawn : what a picture of the grasp shows. shown : one solve, then the steps. path : as `path_data` has it.
    escape : the motion in which the object escapes; None where none is known.
    meshes : where solids go, of a page of several grasps, which packs them itself.
    """
    grasp = drawn.grasp
    scene, state = grasp.scene, getattr(grasp, "state", None)
    joints = []  # with None for a limit that is not known
    if state is not None and any(s.torques is not None for s in shown):
        limits = np.where(np.isfinite(state.hand.torque_limits), state.hand.torque_limits, np.nan).tolist()
        joints = [{"name": n, "limit": x} for n, x in zip(state.hand.joint_names, limits, strict=True)]
    frames = PageFrames(shown, grasp)
    own, parts, told = meshes or MeshPack(), make_parts(drawn), frames.to_list()
    # First comes the end of the loading, which the verdict is about; else the one solve
    one_solve = path is None or (path["first"] == 1 and escape is not None)
    return {
        "size": scene.units.length_unit,
        "planar": scene.plane is not None,
        "perNewton": frames.per_newton,
        "slipFactor": frames.slip_factor,
        "view": view_data(drawn, parts, told[0]["joints"]),
        "parts": [solid_data(p, own) for p in parts],
        "packed": own.to_base64() if meshes is None else "",
        "frames": told,
        "columns": frames.columns,
        "contacts": _contact_data(grasp),
        "joints": joints,
        "colours": {
            **{status_word(status): colour for status, colour in STATUS_COLOURS.items()},
            "load": LOAD_COLOUR,
            "slip": SLIP_COLOUR,
            "escape": ESCAPE_COLOUR,
        },
        "legend": _legend_lines(drawn, parts, shown, frames, escape is not None),
        "path": path,
        "escape": escape,
        "first": 0 if one_solve else len(told) - 1,
        "notes": drawing_notes(drawn, parts),
    }


def path_data(loading: Loading, first: int) -> dict[str, Any]:
    """Stages and events beside the slider. first : number of the frame of the first step."""
    steps, kept = loading.steps, np.array(choose_steps(loading))
    stage, share = steps.stage[kept], steps.share[kept]
    told = list[dict[str, Any]]()
    for s in summary(loading.events, steps.grasp.spec):
        frame = first + _step_at(stage, share, s.number, s.share)
        told.append({"frame": frame, "where": s.where, "says": s.sentence, "lost": False})
    if not loading.reached:
        at = words.format_percent(loading.lost_at or 0.0)
        why = loading.why.removeprefix(f"lost in stage {loading.lost_stage!r} at {at}: ")
        where, end = f"{loading.lost_stage}, {at}", first + len(kept) - 1
        told.append({"frame": end, "where": where, "says": f"lost: {why}", "lost": True})
    ends = [first + _step_at(stage, share, k, 1.0) for k in range(len(loading.stages))]
    stages = [{"name": n, "end": e} for n, e in zip(loading.stages, ends, strict=True)]
    return {"first": first, "stages": stages, "events": told, "held": loading.in_place}


def _step_at(stage: Any, share: Any, number: int, where: float) -> int:
    """The first kept step at or behind a place; the last one where there is none."""
    behind = np.flatnonzero((stage > number) | ((stage == number) & (share >= where - 1e-9)))
    return int(behind[0]) if len(behind) else len(stage) - 1


def solid_data(p: PagePart, meshes: MeshPack) -> dict[str, Any]:
    """A solid as the viewer reads it."""
    return {**meshes.add(p.triangles), "colour": p.colour, "layer": p.layer, "joint": p.joint}


def _contact_data(grasp: Grasp) -> list[dict[str, Any]]:
    """Names, and the half-axes of the friction cones."""
    fingers = grasp.scene.n - grasp.scene.environment
    found = []
    for i, (name, contact) in enumerate(zip(grasp.names, grasp.contacts, strict=True)):
        mu, scale = float(grasp.scene.mu[i]), (1.0, 1.0)
        if grasp.scene.plane is None:
            mu, scale = contact.mu, contact.friction.scale
        found.append({"name": name, "mu": [mu * scale[0], mu * scale[1]], "environment": i >= fingers})
    return found


def view_data(drawn: PictureContent, parts: Sequence[PagePart], joints: list[list[float]] | None) -> dict[str, Any]:
    """The direction of the pictures; up: the axis about which the view turns. joints : their poses at first."""
    moved = [pin.XYZQUATToSE3(np.array(m)) for m in joints or ()]
    hiding, glass = list[Body](), None
    for p in parts:
        hull = convex_hull(outermost_points(p.triangles.reshape(-1, 3), spread_directions(60, 0.5)))
        coarse = p.triangles if hull is None else hull  # these lie in a plane
        body = Body(coarse if p.joint == NO_JOINT else place_triangles(coarse, moved[p.joint]), p.colour)
        if p.layer == "object":
            glass = body
        else:
            hiding.append(body)
    camera = choose_camera(drawn.grasp, hiding, glass, drawn.screen_marks())
    axis = int(np.argmax(abs(camera.axes[1])))
    return {"axes": camera.axes, "up": np.eye(3)[axis] * np.sign(camera.axes[1][axis])}


def legend_layers(parts: Sequence[PagePart], names: dict[str, str]) -> list[Any]:
    """A line of the legend for each layer of solids. names : of layers that are called otherwise than themselves."""
    colours = {p.layer: HAND_COLOUR if p.layer == "hand" else p.colour for p in parts}
    names = {"tips": "shape that finds the contact"} | names
    return [[layer, "patch", list(colour), names.get(layer, layer)] for layer, colour in colours.items()]


def _legend_lines(
    drawn: PictureContent, parts: Sequence[PagePart], shown: Sequence[Snapshot], frames: PageFrames, escapes: bool
) -> list[Any]:
    """Lines of (layer, kind, colour, text); each layer can be switched off."""
    grasp, who = drawn.grasp, drawn.grasp.spec.who
    statuses = {status for s in shown for status in s.statuses}
    deep, links = words.format_length(max(drawn.links_inside.values(), default=0.0)), list(drawn.links_inside)
    inside = f"inside the object: {f'{links[0]},' if len(links) == 1 else f'{len(links)} links, up to'} {deep}"
    names = {
        "hand": "hand" if hasattr(grasp, "state") else "fingers",
        "inside": inside,
        "object": "object" if drawn.object_body is None else drawn.object_body.label,
    }
    out = legend_layers(parts, names)
    if (grasp.scene.mu > 0).any():
        sense = "friction cones, to the forces’ scale: an arrow at the rim slides"
        out.append(["cones", "cone", STATUS_COLOURS[STICKING], sense if statuses != {UNKNOWN} else "friction cones"])
    for status in (STICKING, SLIDING):
        if status in statuses:
            out.append(["forces", "arrow", STATUS_COLOURS[status], f"{who} force, {status_word(status)}"])
    if SEPARATED in statuses:
        out.append(["forces", "dot", STATUS_COLOURS[SEPARATED], f"{who} that does not touch"])
    if frames.has_moments:
        out.append(["forces", "turn", STATUS_COLOURS[STICKING], f"moment of a {who} about its normal"])
    if any(s.load.any() for s in shown):
        out.append(["load", "arrow", LOAD_COLOUR, "load on the object, weight included"])
    if any(float(np.linalg.norm(s.moment)) > MIN_DRAWN_MOMENT for s in shown):
        out.append(["load", "turn", LOAD_COLOUR, "torque of the load"])
    if frames.slip_factor:
        times = frames.slip_factor
        text = f"× {times:g}" if times >= 1 else f"÷ {1 / times:g}"
        if frames.largest_slide > words.NEGLIGIBLE_LENGTH:
            text += f" (it slides up to {words.format_length(frames.largest_slide)})"
        out.append(["slips", "arrow", SLIP_COLOUR, f"slip of the object, {text}"])
    if escapes:
        out.append(["escape", "dashed", ESCAPE_COLOUR, "the way the object escapes"])
    out.append(["labels", "text", UNKNOWN_COLOUR, "names; normal force + friction"])
    return out


# ----------------------------------------------------------------
# The page: one HTML file that needs nothing else, and asks the network for nothing; what it says in words.


_FIRST_SCRIPTS, _LAST_SCRIPT = ("solids.js", "marks.js", "labels.js", "view.js", "panel.js"), "opened.js"
_DATA_DIGITS = 6


@check_call("obj")  # anything with a surface of triangles is drawn
def write_solution_page(
    solution: GraspSolution,
    path: Any,
    obj: Object | None = None,
    title: str = "",
    verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:
    """Write the page of a solution: see `GraspSolution.page`."""
    if obj is not None and not hasattr(obj, "triangles"):
        raise InputError("obj", "an object, such as hl.Sphere(0.03)", shorten_repr(obj))
    return write_grasp_page(grasp_of_solution(solution), solution, path, obj, title, verdict, loading)


def write_grasp_page(
    grasp: Grasp,
    solution: GraspSolution,
    path: Any,
    obj: Any = None,
    title: str = "",
    verdict: Verdict | None = None,
    loading: Loading | None = None,
) -> Path:
    """Write the page of a solved grasp. obj : what to draw as the object where the grasp knows none.

    loading : of the same grasp, for the slider; None: the one that the verdict is about. verdict : of `check`; None:
    whether the loading holds the object, or without one what the solution says.

    Raises InputError for a file that cannot be written, or another grasp's loading; Unsupported without trimesh.
    """
    target = check_page_path(path)
    if loading is None and verdict is not None:
        loading = verdict.loading
    if loading is not None and loading.steps.names != solution.names:
        raise InputError("loading", "one of the same grasp: grasp.follow()", f"contacts {loading.steps.names}")
    said = solution.verdict if verdict is None else verdict
    drawn = PictureContent(grasp, solution, obj, verdict=said)
    told = _verdict_html(said) if verdict is not None or loading is None else _loading_html(loading)
    shown, steps, way_out = [snapshot_of_solution(grasp, solution, drawn.acts_at)], None, None
    if drawn.escape_motion is not None:
        move, turn = drawn.escape_motion
        way_out = {"at": drawn.acts_at, "move": move, "turn": turn}
    if loading is not None:
        steps = path_data(loading, 1)
        shown += snapshots_of_loading(loading, drawn.acts_at, getattr(grasp, "state", None))
    return write_viewer_page(target, title, told, page_data(drawn, shown, steps, way_out))


@check_call()
def write_loading_page(
    loading: Loading, path: Any, title: str = "", obj: Object | None = None, verdict: Verdict | None = None
) -> Path:
    """Write the page of a loading alone, which begins at its last step.

    obj : as in `write_grasp_page`, where it stands at the start.
    verdict : of `check`; None: whether the loading holds the object.

    Raises as `write_grasp_page`.
    """
    target = check_page_path(path)
    grasp = make_grasp(loading.steps.grasp.spec)
    drawn = PictureContent(grasp, loading.solution, obj, verdict=verdict)
    shown = snapshots_of_loading(loading, drawn.acts_at, getattr(grasp, "state", None))
    told = _loading_html(loading) if verdict is None else _verdict_html(verdict)
    return write_viewer_page(target, title, told, page_data(drawn, shown, path_data(loading, 0), None))


def write_viewer_page(
    target: Path,
    title: str,
    said: str,
    found: Mapping[str, Any],
    kind: str = "page",
    scripts: Sequence[str] = ("player.js", "page.js"),
) -> Path:
    """Write one HTML file that holds words, data and scripts of a page, and return it.

    target : the file, checked already. title : not yet HTML; "" for none. said : the verdict, as HTML.
    found : what the page's scripts read, with `notes` for the reader.
    kind : the package of `handlcp.viz` whose web files are the HTML of the side with the picture, that beside the
    legend, a style named as itself, and these scripts, which run between those that all pages have.

    Raises InputError for a file that cannot be written.
    """
    first, last = read_web_files(*_FIRST_SCRIPTS), read_web_files(_LAST_SCRIPT)
    package = f"handlcp.viz.{kind}"
    stage, tables, *own = read_web_files("stage.html", "tables.html", *scripts, package=package)
    style = "" if kind == "page" else read_web_files(f"{kind}.css", package=package)[0]  # beside that of all pages
    parts = {
        "heading": f"<h1>{escape(title)}</h1>" if title else "",
        "stage": stage,
        "tables": tables,
        "verdict": said,
        "notes": "".join(f"<li>{escape(str(note))}</li>" for note in found["notes"]),
        "data": script_data(_round_numbers(to_plain(found))),
        "three": read_three_js(),
        "scripts": "\n".join([*first, *own, *last]),
    }
    return write_page(target, read_web_files("frame.html")[0], title or "A grasp", style, parts)


def _round_numbers(value: Any) -> Any:
    """The same data with six digits for each number."""
    if isinstance(value, dict):
        return {k: _round_numbers(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_round_numbers(v) for v in value]
    if isinstance(value, float):
        short = float(f"{value:.{_DATA_DIGITS}g}")
        return int(short) if abs(short) < 1e9 and short == int(short) else short
    return value


# ----------------------------------------------------------------
# What a page says in words, as HTML: every text is escaped.

_SEVERITY_HEADS = {"warning": "Warning", "advice": "Advice"}


def _verdict_html(v: Verdict) -> str:
    """A verdict as HTML: its word and its reasons."""
    lines = ((_SEVERITY_HEADS.get(r.severity, ""), r.severity, f"{r.sentence}.") for r in v.reasons)
    return _reasons_html(v.word, lines)


def _loading_html(loading: Loading) -> str:
    """Whether the object is held, and how far it has moved; what happens on the way is beside the slider."""
    lines = ("", "decides", f"{loading.sentence}."), ("", "note", f"{describe_object_motion(loading)}.")
    return _reasons_html(loading.word, lines)


def _reasons_html(word: str, lines: Iterable[tuple[str, str, str]]) -> str:
    """A word and a list of sentences as HTML. lines : (head, severity, sentence) of each."""
    items = ""
    for head, severity, text in lines:
        if text.split(" ", 1)[0].isalpha():  # else it begins with a name that is written otherwise
            text = text[:1].upper() + text[1:]
        items += f'<li class="{escape(severity)}">{f"<b>{head}:</b> " if head else ""}{escape(text)}</li>'
    return f'<p class="word {word_class(word)}">{escape(word)}</p><ul class="reasons">{items}</ul>'
