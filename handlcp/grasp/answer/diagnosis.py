"""What a solution means, in one sentence with the fingers' names.

Nothing here decides anything: status, proof and free directions come from the certifier, and a sentence never says more
than they do. UNDECIDED speaks of the solver only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp.check import Array
from handlcp.lcp.status import Status
from handlcp.tolerances import ACTIVE

__all__ = ["describe_motion", "diagnose"]

_SHARE = 1e-3  # a shift or a swing below this share of the other goes unmentioned
_NEAR = 1e-3  # of the grasp's size: a contact this near to an axis is on it
_MOST = 4  # names listed


def diagnose(
    status: Status,
    names: Sequence[str],
    positions: Array,
    *,
    reference: Array,
    forces: Array | None = None,
    states: Sequence[str] = (),
    offset: Array | None = None,
    escape: Array | None = None,
    loose: Array | None = None,
    forces_determined: bool = True,
    others: bool = False,
    required_preload: float | None = None,
    bounds: tuple[float, float] | None = None,
    cause: str = "",
    environment: int = 0,
) -> str:
    """One sentence, without a full stop.

    names (n,), positions (n, 3) m of the contacts. reference (3,) m: the point that twists refer to.
    forces (n, 3) N in contact axes, states (n,) of a SOLVED solution ("sticking", "sliding", "separated").
    offset (n, 3) m, contact axes: says which contacts carry no preload. escape (6,): the certificate of NOT_HOLDABLE.
    loose (k, 6), forces_determined: what a SOLVED solution leaves free; others: whether other equilibria are known.
    required_preload: squeeze [m] on every contact that would hold (NO_EQUILIBRIUM), if known. bounds: forces [N] and
    motions [m] within which NO_EQUILIBRIUM was proven; cause: of it, where known. environment: how many contacts, the
    last ones, are no finger's.
    """
    names = _distinct(names)
    p, c = np.asarray(positions, dtype=float).reshape(-1, 3), np.asarray(reference, dtype=float)
    who = "contact" if environment else "finger"
    if status is Status.SOLVED:
        return _solved(names, p, c, forces, states, loose, forces_determined, others, who)
    if status is Status.NOT_HOLDABLE:
        way = (
            "" if escape is None else f": the object {describe_motion(escape, p, c, names, 'slides out', 'turns out')}"
        )
        return f"no {who} forces within friction balance the load{way}"
    if status is Status.NO_EQUILIBRIUM:
        k = len(names) - environment  # preload is the fingers'
        squeeze = None if offset is None else np.asarray(offset, dtype=float)[:k, 2]
        return _no_equilibrium(names[:k], squeeze, required_preload, cause, _within(who, bounds))
    if status is Status.INFEASIBLE:
        return "the conditions contradict each other, whatever the complementarity"
    return "the solver spent its budget without an answer, which says nothing about the grasp"


def describe_motion(
    twist: Array, positions: Array, reference: Array, names: Sequence[str], slide: str, turn: str
) -> str:
    """E.g. "slides out along (0, 0, -1)", "turns about (1, 0, 0) through (0, 0, 0.1) m", or both (a screw).

    twist (6,) m, rad about `reference` (3,) m. A motion is a translation when no contact notices its turn, and a turn
    about an axis when the points of that axis stay where they are, both within a thousandth.
    """
    names = _distinct(names)
    u, omega = np.asarray(twist[:3], dtype=float), np.asarray(twist[3:], dtype=float)
    arms = positions - reference
    centre = arms.mean(axis=0) if len(arms) else np.zeros(3)
    size = _size(positions)
    rate = float(np.linalg.norm(omega))
    at_centre = u + np.cross(omega, centre)
    if rate * size <= _SHARE * float(np.linalg.norm(at_centre)):
        return f"{slide} along {_vector(_unit(at_centre))}"
    axis = omega / rate
    pitch = float(u @ axis)  # translation along the axis: the same at every point
    foot = np.cross(axis, u) / rate  # nearest point of the axis to the reference
    foot = foot + axis * float(axis @ (centre - foot))  # … and then to the contacts' centre
    along = "" if abs(pitch) <= _SHARE * rate * size else f" and {slide} along {_vector(axis * np.sign(pitch))}"
    on = [
        name
        for name, a in zip(names, arms, strict=True)
        if float(np.linalg.norm(np.cross(axis, a - foot))) <= _NEAR * size
    ]
    if len(on) >= 2:
        return f"{turn} about the line through {_listed(on)}{along}"
    through = on[0] if on else f"{_vector(foot + reference, size)} m"
    return f"{turn} about {_vector(axis)} through {through}{along}"


def _solved(
    names: Sequence[str],
    p: Array,
    c: Array,
    forces: Array | None,
    states: Sequence[str],
    loose: Array | None,
    forces_determined: bool,
    others: bool,
    who: str,
) -> str:
    groups = {s: [n for n, state in zip(names, states, strict=True) if state == s] for s in dict.fromkeys(states)}
    idle = set(groups.get("separated", ()))
    parts = []
    slippery = _slippery(names, forces, states)
    if sliding := [n for n in groups.get("sliding", ()) if n not in slippery]:
        every = len(sliding) == len(names) > 1
        parts.append(f"all {who}s slide" if every else f"{_listed(sliding)} {_plural(sliding, 'slides', 'slide')}")
    if slippery:
        some = f"all {who}s" if len(slippery) == len(names) > 1 else _listed(slippery)
        parts.append(f"{some} {_plural(slippery, 'pushes', 'push')} without friction")
    if idle:
        apart = [n for n in names if n in idle]
        few = f"{_listed(apart)} {_plural(apart, 'does', 'do')} not push"
        parts.append(f"no {who} pushes" if len(apart) == len(names) else few)
    if not parts and len(names):
        parts.append(f"all {who}s stick")
    if loose is not None and len(loose):
        parts.append(_loose(np.asarray(loose, dtype=float), p, c, names))
    if not forces_determined:
        parts.append("other forces satisfy the same conditions (the smallest are given)")
    if others:
        parts.append("it can also be held in other ways (grasp.equilibria() lists them)")
    if forces is not None and len(names) and _at_rest(np.asarray(forces), states):
        return "; ".join(["in balance without any contact force", *parts])
    return "; ".join(["held", *parts])


def _slippery(names: Sequence[str], forces: Array | None, states: Sequence[str]) -> list[str]:
    """Who pushes without friction: what has friction slides only against a force on its limit. Such a contact is called
    sliding even at rest, as nothing keeps it from it.
    """
    if forces is None:
        return []
    f = np.asarray(forces, dtype=float)
    smooth = np.hypot(f[:, 0], f[:, 1]) <= ACTIVE * f[:, 2]
    return [n for n, state, s in zip(names, states, smooth.tolist(), strict=True) if state == "sliding" and s]


def _at_rest(forces: Array, states: Sequence[str]) -> bool:
    """Whether no contact has a force. A contact is "separated" when it has none beside the scene's natural force: what
    rounding left of it counts for nothing.
    """
    return all(state == "separated" or not f.any() for f, state in zip(forces, states, strict=True))


def _loose(loose: Array, p: Array, c: Array, names: Sequence[str]) -> str:
    """One direction in words, several as a number and what kind they are."""
    if len(loose) == 1:
        way = describe_motion(loose[0], p, c, names, "slide", "spin")
        return f"the object can still {way}"
    size = _size(p)
    shifts = [np.linalg.norm(t[3:]) * size <= _SHARE * np.linalg.norm(t[:3]) for t in loose]
    if len(loose) >= 6:
        return "the object is loose in every direction"
    kind = "slide" if all(shifts) else "move"
    return f"the object can still {kind} in {len(loose)} directions"


def _within(who: str, bounds: tuple[float, float] | None) -> str:
    """That there is no equilibrium, and how far it was looked for."""
    within = "" if bounds is None else f" (none up to {_number(bounds[0])} N and motions of {_number(bounds[1])} m)"
    return f"forces within friction could balance the load, but these {who}s do not create them{within}"


def _no_equilibrium(
    names: Sequence[str], squeeze: Array | None, required: float | None, known: str, cannot: str
) -> str:
    """With the cause, and what would help; squeeze (n,) [m]: offset along the normals."""
    bare: list[str] = []
    if squeeze is not None:
        noise = ACTIVE * float(abs(squeeze).max(initial=0.0))
        bare = [name for name, gap in zip(names, squeeze, strict=True) if gap >= -noise]
    if len(bare) == len(names) > 1:
        cause = "no finger carries preload"
    elif bare:
        cause = f"{_listed(bare)} {_plural(bare, 'carries', 'carry')} no preload"
    else:
        cause = "the preload is too small" if required is not None else ""
    if required is not None:
        more = "" if len(bare) == len(names) else " more"
        return f"{cannot}: {cause}; {_enough(required)} m{more} on each finger would hold it"
    if cause or known:
        return f"{cannot}: {'; '.join(c for c in (cause, known) if c)}"
    return cannot if squeeze is None else f"{cannot}, although {_every(names)} carries preload"


def _every(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else "every finger"


def _distinct(names: Sequence[str]) -> Sequence[str]:
    """Names that several fingers have, with each one's number: "finger 1 (a)"."""
    if len(set(names)) == len(names):
        return names
    return [f"finger {i} ({n})" if names.count(n) > 1 else n for i, n in enumerate(names, 1)]


def _size(p: Array) -> float:
    """Rms distance of the contacts from their centre, as the grasp measures itself [m]."""
    if not len(p):
        return 1.0
    arms = p - p.mean(axis=0)
    size = float(np.sqrt((arms**2).sum(axis=1).mean()))
    return size or float(np.linalg.norm(p[0])) or 1.0


def _unit(v: Array) -> Array:
    length = float(np.linalg.norm(v))
    return v / length if length > 0.0 else v


def _vector(v: Array, size: float = 1.0) -> str:
    """Three digits, with what is nothing beside `size` as 0."""
    return "(" + ", ".join("0" if abs(x) < 5e-4 * size else f"{x:.3g}" for x in v) + ")"


def _number(x: float) -> str:
    mantissa, e, exponent = f"{x:.2g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if e else mantissa


def _enough(x: float) -> str:
    """Two digits, rounded up: what is called enough has to be."""
    if not x > 0.0:
        return "0"
    unit = 10.0 ** (np.floor(np.log10(x)) - 1)
    return _number(float(np.ceil(x / unit * (1 - 1e-12)) * unit))


def _listed(names: Sequence[str]) -> str:
    """For "finger 1", "finger 2" it says "fingers 1 and 2"; otherwise the names; at most four."""
    few, rest = list(names[:_MOST]), len(names) - _MOST
    heads = {n.rpartition(" ")[0] for n in few}
    if len(few) > 1 and len(heads) == 1 and (head := heads.pop()) and all(n.rpartition(" ")[2].isdigit() for n in few):
        few = [f"{head}s {few[0].rpartition(' ')[2]}", *(n.rpartition(" ")[2] for n in few[1:])]
    if rest > 0:
        return f"{', '.join(few)} and {rest} more"
    return few[0] if len(few) == 1 else f"{', '.join(few[:-1])} and {few[-1]}"


def _plural(names: Sequence[str], one: str, many: str) -> str:
    return one if len(names) == 1 else many
