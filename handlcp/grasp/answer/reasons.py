"""Why an answer holds or does not, in reasons of a verdict: status, friction, motions that are not small."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.grasp.answer.small_motions import Motions, motions
from handlcp.grasp.answer.uniqueness import Uniqueness
from handlcp.grasp.answer.verdict import Reason
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.lcp.problem import Status

# ---------------------------------------------------------------- How much of its friction a contact uses.
#
# used = |r̂_T| / (μ r_N)        margin = μ r_N - |r̂_T|
#
# r̂_T are the tangential forces in the coordinates of the friction law (`grasp/friction/law.py`), the moment of a soft
# finger among them, so that used = 1 is the limit of every law.


def friction_used(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) from forces (n, 3) in contact axes [N] and moments (n,) about the normals [N·m]; NaN where there is no
    friction, or no normal force.
    """
    tangential, limit = _against(scene, forces, torsion)
    return read_only(tangential / np.where(limit > 0.0, limit, np.nan))


def friction_margin(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) N, arguments as above; NaN where there is no friction."""
    tangential, limit = _against(scene, forces, torsion)
    return read_only(np.where(scene.mu > 0.0, limit - tangential, np.nan))


def _against(scene: Scene, forces: Array, torsion: Array | None) -> tuple[Array, Array]:
    """(|r̂_T|, μ r_N), (n,) each."""
    soft = list(scene.soft)
    moments = np.zeros(scene.n) if torsion is None else torsion[soft]
    lawful, turning = np.split(scene.lawful(np.append(forces, moments if soft else [])), [3 * scene.n])
    moment = np.zeros(scene.n)
    moment[soft] = turning
    x, y, z = lawful.reshape(-1, 3).T
    return np.hypot(np.hypot(x, y), moment), scene.mu * z


# ----------------------------------------------------------------
# What one solution says about holding the object, as the reasons of a verdict.

HARDLY = 0.95  # of the friction limit: a contact that uses more has hardly any margin
_LITTLE = 5e-4  # of the friction limit: less is not worth a word
_STILL = 1e-7  # [m] an object that moves less is not said to move
_FEW = 4  # contacts that are named one by one
_TWIST = 1e-4  # [rad] a soft finger that turns less on the object is not said to twist
_CODES = {Status.NOT_HOLDABLE: "not_holdable", Status.NO_EQUILIBRIUM: "no_equilibrium"}


def reasons_of(s: Any) -> Iterator[Reason]:
    """Of a `GraspSolution`, which imports this file."""
    if not s.held:
        yield equilibrium_reason(s.status, s.diagnosis)
    elif s.spec is not None and s.scene is not None:
        yield from no_load(s.spec)
        for e in s.spec.effects:  # which bounds are reached, and how far they give way
            for part in e.words(s.scene, s.names, s.extra):
                yield Reason("effect", "note", part, {"effect": e.title})
        yield _contacts(s)
        yield from friction_reasons(s.names, s.friction_used, s.contact_state)
        yield motion_reason(s.object_displacement, s.scene.force, s.scene.units.length)
        yield from open_reasons(s.uniqueness)
        yield from large_motion(motions(s))


def equilibrium_reason(status: Status, diagnosis: str) -> Reason:
    """Why there is no answer."""
    if status is Status.UNDECIDED:
        why = "the solver stopped before it found an answer, which says nothing about the grasp"
        return Reason("solver_stopped", "decides", f"{why}; try another seed or number of faces")
    return Reason(_CODES.get(status, "solver_stopped"), "decides", diagnosis, {"status": status.name})


def large_motion(found: Motions) -> Iterator[Reason]:
    """Of motions that are too large for the equations of small ones."""
    if text := found.sentence:
        severity = "decides" if found.too_large else "warning"
        values = {
            "move_m": found.move, "turn_rad": found.turn, "slip_m": found.slip, "squeeze_m": found.squeeze,
            "size_m": found.size, "yield_rad": found.yielded, "force_error": found.share, "adrift": found.adrift,
        }  # fmt: skip
        yield Reason("large_motion", severity, text, values)


def _contacts(s: Any) -> Reason:
    """What the contacts of a `GraspSolution` do."""
    slips = np.hypot(*s.slip.T).tolist()
    spins = np.zeros(len(slips)) if s.spin is None else abs(s.spin)
    sliding = {n: d for n, state, d in zip(s.names, s.contact_state, slips, strict=True) if state == "sliding"}
    turns = {n: float(a) for n, a in zip(s.names, spins, strict=True) if a > _TWIST}
    apart = [n for n, state in zip(s.names, s.contact_state, strict=True) if state == "separated"]
    return contacts_reason(s.spec, sliding, turns, apart)


def contacts_reason(
    spec: GraspSpec, sliding: Mapping[str, float], turns: Mapping[str, float], apart: Sequence[str]
) -> Reason:
    """Which contacts of a grasp slide [m], twist on the object [rad] or let go; "all stick" where none does."""
    parts, who, count = [], f"{spec.who}s", spec.n
    if sliding and len(sliding) == count > 1:
        parts.append(f"all {who} slide, up to {words.length(max(sliding.values()))}")
    elif sliding:
        parts.append(_slide({n: d for n, d in sliding.items() if d > words.NOTHING or not turns}, spec))
    if turns and len(sliding) < max(count, 2):
        parts.append(", ".join(f"{n} twists by {words.angle(a)} on the object" for n, a in turns.items()))
    if apart:
        gone = words.by_link(apart, spec.links) if len(apart) > _FEW else apart
        parts.append(f"{words.listed(gone)} {'let' if len(apart) > 1 else 'lets'} go")
    text = "; ".join(p for p in parts if p) or f"all {who} stick"
    values = {"sliding_m": dict(sliding), "twisting_rad": dict(turns), "separated": list(apart)}
    return Reason("contacts", "note", text, values)


def _slide(sliding: Mapping[str, float], spec: GraspSpec) -> str:
    """How far each of a few contacts slides [m]; of many those of one link together, or how many there are."""
    if len(sliding) <= _FEW:
        ways = words.lengths(sliding.values())
        return ", ".join(f"{n} slides {way}" for n, way in zip(sliding, ways, strict=True))
    farthest = dict[str, list[float]]()
    for name, far in sliding.items():
        farthest.setdefault(spec.links.get(name, name), []).append(far)
    if len(farthest) > _FEW:
        most = max(sliding, key=lambda name: sliding[name])
        return f"{len(sliding)} of {spec.n} {spec.who}s slide, up to {words.length(sliding[most])} ({most})"
    ways = words.lengths([max(far) for far in farthest.values()])
    named = zip(words.by_link(list(sliding), spec.links), farthest.values(), ways, strict=True)
    return ", ".join(f"{who} {'slides' if len(far) == 1 else 'slide up to'} {way}" for who, far, way in named)


def friction_reasons(names: Sequence[str], used: Array, states: Sequence[str], when: str = "") -> Iterator[Reason]:
    """How near the contacts are to sliding; a warning where hardly any friction is left. used, states (n,). when : such
    as " at the end".
    """
    every = list(zip(names, used.tolist(), states, strict=True))
    sticks = [(x, n) for n, x, state in every if state == "sticking" and x >= 0.0]
    slides = [n for n, x, state in every if state == "sliding" and x > 0.0]
    values = {"used": {n: x for n, x, _ in every if np.isfinite(x)}}
    if not sticks and slides:
        text = "friction is used up at every contact that pushes: nothing is left for a disturbance"
        yield Reason("friction", "warning", text, values)
    elif sticks and (most := max(x for x, _ in sticks)) > _LITTLE:
        who = next(n for x, n in sticks if x >= (1.0 - 1e-6) * most)  # the first of equals
        others = "of those that stick " if slides else ""
        text = f"friction {others}is used up to {words.percent(most)}{when} ({who})"
        if most >= HARDLY:
            warning = f"{who} uses {words.percent(most)} of its friction: a little more load makes it slide"
            yield Reason("friction", "warning", warning, values)
        else:
            yield Reason("friction", "note", text, values)


def motion_reason(displacement: Array, load: Array, size: float) -> Reason:
    """How far the object moves (6,), how much of that along the load (3,), and how far it turns; size of the grasp."""
    u = displacement
    move, turn = float(np.linalg.norm(u[:3])), float(np.linalg.norm(u[3:]))
    strength, values = float(np.linalg.norm(load)), {"move_m": move, "turn_rad": turn}
    if max(move, turn * size) < words.NOTHING:
        return Reason("motion", "note", "the object stays where it is", values)
    if max(move, turn * size) < _STILL:
        return Reason("motion", "note", "the object does not move noticeably", values)
    along = float(u[:3] @ load) / strength if strength > 0 else 0.0
    moves, part = words.lengths([move, abs(along)])
    text = f"the object moves {moves}"
    if strength > 0:
        way = "along" if along >= 0 else "against"
        text += f" {way} the load" if part == moves else f", {part} of it {way} the load,"
    text = f"{text} and turns {words.angle(turn)}" if turn > 1e-4 else text.removesuffix(",")
    return Reason("motion", "note", text, values)


def no_load(spec: Any) -> Iterator[Reason]:
    """Of a grasp whose object nothing loads: a mass may have been forgotten."""
    if not spec.wrench.any():
        text = "no load: no weight acts on the object, and no wrench was given"
        yield Reason("no_load", "note", text)


def open_reasons(free: Uniqueness | None) -> Iterator[Reason]:
    """What the equations leave open."""
    if free is None:
        return
    if not free.forces_determined:
        given = "the smallest" if free.smallest else "those that the loading led to"
        text = f"other forces satisfy the same conditions; {given} are given"
        yield Reason("forces_open", "warning", text)
    if k := free.loose_motions:
        given = "the smallest motion is given" if free.smallest else "what the loading led to is given"
        text = f"the object can move freely in {k} direction{'s' if k > 1 else ''}; {given}"
        yield Reason("loose", "warning", text, {"directions": k})
    if free.others:
        text = "friction can hold the object in other ways, too; grasp.equilibria() lists them"
        yield Reason("others", "warning", text)
