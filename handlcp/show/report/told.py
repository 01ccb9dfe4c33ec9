"""What a report of several hands says in words: what was asked, how the hands differ, which is better at what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.contact.friction import as_law
from handlcp.design.brief import Brief
from handlcp.design.evaluation import Evaluation, shown
from handlcp.geometry import YCB, Box, Cylinder, Ellipsoid, Object, Sphere
from handlcp.hand import Hand
from handlcp.show.report.differing import differing

_ALIKE = 0.01  # numbers that differ by a smaller share are alike

# What hands are compared by: attribute of an evaluation, what the better one does, unit, and whether more is better
_BETTER = (
    ("payload", "carries more", "kg", True),
    ("factor", "holds its loads more times", "×", True),
    ("force", "presses less hard", "N", False),
    ("torque_used", "uses less of its torque limits", "%", False),
    ("motion", "lets objects move less", "mm", False),
)
SCALES = {"%": 100.0, "mm": 1e3}


def asked(brief: Brief) -> list[str]:
    """The brief, a sentence for each thing."""
    objects = [f"{name}, {_shape(obj)} of {obj.mass:g} kg" for name, obj in brief.objects.items()]
    ways = "in six directions" if brief.orientations == 6 else "in any direction"
    said = [f"Objects: {'; '.join(objects)}", f"Gravity pulls {ways}"]
    if brief.acceleration:
        said.append(f"The hand speeds up by {brief.acceleration:g} m/s²")
    for name, load in brief.loads.items():
        size = f"{_vector(load[:3], 'N')}{_and_torque(load[3:])}"
        said.append(f"Load “{name}”: {size} beside the weight, the hand upright")
    said.append(f"Friction: {_friction(brief)}")
    said.append(f"The weight, and each load, is to be held {brief.safety:g} times")
    if brief.motion is not None:
        said.append(f"An object may move {words.length(brief.motion)} under it")
    if brief.most_force is not None:
        said.append(f"An object bears {words.force(brief.most_force)} at a contact")
    kinds = {"pinch": "fingertips alone", "power": "the whole hand", "any": "fingertips or the whole hand"}
    return [*said, f"Held by {kinds[brief.kind]}"]


def _shape(obj: Object) -> str:
    """With its sizes in millimetres."""
    match obj:
        case Sphere():
            return f"a ball {2e3 * obj.radius:g} mm across"
        case Box():
            return f"a box of {' × '.join(f'{1e3 * x:g}' for x in obj.size)} mm"
        case Cylinder():
            return f"a cylinder {2e3 * obj.radius:g} mm across and {1e3 * obj.length:g} mm long"
        case Ellipsoid():
            return f"an ellipsoid of {' × '.join(f'{2e3 * x:g}' for x in obj.radii)} mm"
        case YCB():
            return f"the YCB object {obj.name}"
    return "a mesh"


def _vector(vector: Any, unit: str) -> str:
    return f"({', '.join(f'{x:g}' for x in vector)}) {unit}"


def _and_torque(torque: Any) -> str:
    return f" and {_vector(torque, 'N·m')}" if np.any(torque) else ""


def _friction(brief: Brief) -> str:
    law = as_law(brief.friction)
    return f"coefficient {law.mu:g}" if type(law).__name__ == "Coulomb" else repr(law)


def differences(hands: Mapping[str, Hand]) -> list[tuple[str, ...]]:
    """What differs in all: joints, fingertips, mass, size; then a row for each number, by its name for `vary`, in which
    hands differ, and for how joints stand and turn, with its value in each hand.
    """
    described = [hand.describe() for hand in hands.values()]
    more = [
        ("joints", *[str(len(d.joints)) for d in described]),
        ("fingertips", *[str(sum(tip.taken for tip in d.fingertips)) for d in described]),
        ("mass", *[f"{d.mass:.3g} kg" for d in described]),
        ("size", *[" × ".join(f"{1e3 * x:.0f}" for x in d.size) + " mm" for d in described]),
    ]
    return [*[row for row in more if len(set(row[1:])) > 1], *differing(hands)]


def better(found: Mapping[str, Evaluation]) -> list[str]:
    """Which hand is better at what, a sentence for each number; the others beside it. Forces, torques and motion are
    those of the same loads only where these are held: a hand that drops them sooner is not better.
    """
    said, names, holds = list[str](), list(found), [done.holds for done in found.values()]
    for attribute, what, unit, more in _BETTER:
        values = [SCALES.get(unit, 1.0) * float(getattr(done, attribute)) for done in found.values()]
        known = [k for k, value in enumerate(values) if not np.isnan(value) and (more or holds[k])]
        if len(known) < (1 if more else 2):
            continue
        best = (max if more else min)(known, key=lambda k: values[k])
        least = [more and not done.gives_out for done in found.values()]
        cells = [f"{names[k]} {shown(values[k], least[k])} {unit}".rstrip() for k in known]
        apart = max(abs(values[k] - values[best]) for k in known)
        if len(known) > 1 and not apart > _ALIKE * abs(values[best]):
            said.append(f"None {what}: {words.listed(cells)}")
        else:
            said.append(f"{names[best]} {what}: {words.listed(cells)}")
    return said


def best_of(values: Sequence[float], more: bool) -> list[bool]:
    """Which of these numbers are the best, where they are not all alike; NaN is none."""
    known = [v for v in values if not np.isnan(v)]
    if len(known) < 2 or not max(known) - min(known) > _ALIKE * max(map(abs, known)):
        return [False] * len(values)
    best = max(known) if more else min(known)
    return [v == best for v in values]
