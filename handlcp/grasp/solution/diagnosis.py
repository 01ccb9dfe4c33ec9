"""`DiagnosisText`: what a solution means, in one sentence with the fingers' names.

Nothing here decides anything: status, proof and free directions come from the certifier, and a sentence never says more
than they do. UNDECIDED speaks of the solver only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools
from handlcp.grasp.model.status import SEPARATED, SLIDING, ContactStatus
from handlcp.grasp.solution.uniqueness import Uniqueness
from handlcp.tolerances import ACTIVE_TOLERANCE

UNDECIDED_SENTENCE = "the solver spent its budget without an answer, which says nothing about the grasp"

_MINOR_SHARE = 1e-3  # a shift or a swing below this share of the other goes unmentioned
_ON_AXIS_SHARE = 1e-3  # of the grasp's size: a contact this near to an axis is on it
_MAX_NAMES = 4  # names listed


class DiagnosisText:
    """What there is to say of one grasp's answers, without full stops.

    names (n,), positions (n, 3) m of the contacts, of which the last ones, `environment` in number, are no finger's.
    reference (3,) m: the point that twists refer to. faces : of pyramids inside the friction cones; 0: the cones.
    who : what each of the contacts is called.
    """

    def __init__(
        self,
        names: Sequence[str],
        positions: Array,
        reference: Array,
        environment: int = 0,
        faces: int = 0,
        who: str = "finger",
    ) -> None:
        if len(set(names)) < len(names):  # with each one's number: "finger 1 (a)"
            names = [f"finger {i} ({n})" if names.count(n) > 1 else n for i, n in enumerate(names, 1)]
        self._names, self._fingers = names, names[: len(names) - environment]
        self._who = who
        self._within = f"within {faces}-face pyramids inside the friction cones" if faces else "within friction"
        self._arms, self._reference = positions - reference, reference
        spread = positions - positions.mean(axis=0)
        rms = float(np.sqrt((spread**2).sum(axis=1).mean()))  # as the grasp measures itself [m]
        self._size = rms or float(np.linalg.norm(positions[0])) or 1.0

    def describe_held(self, forces: Array, states: Sequence[ContactStatus], free: Uniqueness | None) -> str:
        """Of a SOLVED solution: forces (n, 3) N in contact axes, states (n,) of the contacts, what it leaves free."""
        apart, slides = (np.array([state == s for state in states]) for s in (SEPARATED, SLIDING))
        # What has friction slides only against a force on its limit; what has none is called sliding even at rest, as
        # nothing keeps it from it
        smooth = slides & (np.hypot(forces[:, 0], forces[:, 1]) <= ACTIVE_TOLERANCE * forces[:, 2])
        parts = self._name_those(slides & ~smooth, "slides", "slide")
        parts += self._name_those(smooth, "pushes without friction", "push without friction")
        parts += [f"no {self._who} pushes"] if apart.all() else self._name_those(apart, "does not push", "do not push")
        parts = parts or [f"all {self._who}s stick"]
        if free is not None:
            parts += self._describe_loose(free.directions)
            if not free.forces_determined:
                given = "the smallest" if free.smallest else "those of the loading"
                parts.append(f"other forces satisfy the same conditions ({given} are given)")
            if free.others:
                parts.append("it can also be held in other ways (grasp.equilibria() lists them)")
        # What rounding leaves of a force that is nothing beside the scene's counts for nothing
        at_rest = (apart | ~forces.any(axis=1)).all()
        return "; ".join(["in balance without any contact force" if at_rest else "held", *parts])

    def describe_not_holdable(self, escape: Array) -> str:
        """With the motion (6,) in which the object escapes."""
        way = self.motion(escape, "slides out", "turns out")
        return f"no {self._who} forces {self._within} balance the load: the object {way}"

    def describe_no_equilibrium(self, offset: Array, required: float | None, known: str, proven: bool) -> str:
        """With the cause, and what would help.

        offset (n,) m along the normals: says which contacts are not squeezed. required: squeeze [m] on every finger
        that would hold; known: a cause, if one is. proven: that no forces and motions are an equilibrium.
        """
        create = "cannot" if proven else "do not"
        cannot = f"forces within friction could balance the load, but these {self._who}s {create} create them"
        names, squeeze = self._fingers, offset[: len(self._fingers)]
        noise = ACTIVE_TOLERANCE * float(abs(squeeze).max())
        bare = [name for name, gap in zip(names, squeeze, strict=True) if gap >= -noise]
        everyone = len(bare) == len(names)
        if everyone and len(names) > 1:
            cause = "no finger squeezes the object before the load comes"
        elif bare:
            squeezes = "does" if len(bare) == 1 else "do"
            cause = f"{_list_names(bare)} {squeezes} not squeeze the object before the load comes"
        else:
            cause = "" if required is None else "the squeeze is too small"
        if required is not None:
            more = "of" if everyone else "more"
            return f"{cannot}: {cause}; {_round_up(required)} {more} squeeze on each finger would hold it"
        if cause or known:
            return f"{cannot}: {'; '.join(c for c in (cause, known) if c)}"
        return f"{cannot}, although {names[0] if len(names) == 1 else 'every finger'} squeezes the object"

    def motion(self, twist: Array, slide: str, turn: str) -> str:
        """Describe a motion of the object in words: "slides out along (0, 0, -1)", "turns about (1, 0, 0) through (0,
        0, 0.1) m", or a screw.

        twist (6,) m, rad. A motion is a translation when no contact notices its turn, and a turn about an axis when the
        points of that axis stay where they are, both within a thousandth.
        """
        u, omega, centre, size = twist[:3], twist[3:], self._arms.mean(axis=0), self._size
        rate, at_centre = float(np.linalg.norm(omega)), u + np.cross(omega, centre)
        speed = float(np.linalg.norm(at_centre))
        if rate * size <= _MINOR_SHARE * speed:
            return f"{slide} along {_format_vector(at_centre / (speed or 1.0))}"
        axis = omega / rate
        pitch = float(u @ axis)  # translation along the axis: the same at every point
        foot = np.cross(axis, u) / rate  # nearest point of the axis to the reference
        foot = foot + axis * float(axis @ (centre - foot))  # … and then to the contacts' centre
        along = (
            ""
            if abs(pitch) <= _MINOR_SHARE * rate * size
            else f" and {slide} along {_format_vector(axis * np.sign(pitch))}"
        )
        near = np.linalg.norm(np.cross(axis, self._arms - foot), axis=1) <= _ON_AXIS_SHARE * size
        on = [name for name, is_on in zip(self._names, near, strict=True) if is_on]
        if len(on) >= 2:
            return f"{turn} about the line through {_list_names(on)}{along}"
        through = on[0] if on else f"{_format_vector(foot + self._reference, size)} m"
        return f"{turn} about {_format_vector(axis)} through {through}{along}"

    def _name_those(self, which: Bools, one: str, many: str) -> list[str]:
        """What those do, if there are any."""
        names = [name for name, does in zip(self._names, which, strict=True) if does]
        if not names:
            return []
        subject = f"all {self._who}s" if len(names) == len(self._names) > 1 else _list_names(names)
        return [f"{subject} {one if len(names) == 1 else many}"]

    def _describe_loose(self, directions: Array) -> list[str]:
        """One direction in words, several as a number and what kind they are."""
        if len(directions) >= 6:
            return ["the object is free to move in every direction"]
        if len(directions) == 1:
            return [f"the object can still {self.motion(directions[0], 'slide', 'spin')}"]
        u, omega = np.linalg.norm(directions[:, :3], axis=1), np.linalg.norm(directions[:, 3:], axis=1)
        kind = "slide" if (omega * self._size <= _MINOR_SHARE * u).all() else "move"
        return [f"the object can still {kind} in {len(directions)} directions"] if len(directions) else []


def _format_vector(v: Array, size: float = 1.0) -> str:
    """Three digits, with what is nothing beside `size` as 0."""
    return "(" + ", ".join("0" if abs(x) < 5e-4 * size else f"{x:.3g}" for x in v) + ")"


def _round_up(metres: float) -> str:
    """Two digits, rounded up: what is called enough has to be."""
    if not metres > 0.0:
        return "0 mm"
    step = 10.0 ** (np.floor(np.log10(metres)) - 1)
    return words.format_length(float(np.ceil(metres / step * (1 - 1e-12)) * step))


def _list_names(names: Sequence[str]) -> str:
    """For "finger 1", "finger 2" it says "fingers 1 and 2"; otherwise the names; at most four."""
    few, rest = list(names[:_MAX_NAMES]), len(names) - _MAX_NAMES
    heads = {n.rpartition(" ")[0] for n in few}
    if len(few) > 1 and len(heads) == 1 and (head := heads.pop()) and all(n.rpartition(" ")[2].isdigit() for n in few):
        few = [f"{head}s {few[0].rpartition(' ')[2]}", *(n.rpartition(" ")[2] for n in few[1:])]
    if rest > 0:
        return f"{', '.join(few)} and {rest} more"
    return few[0] if len(few) == 1 else f"{', '.join(few[:-1])} and {few[-1]}"
