"""What the panels of a loading show: curves over the steps, with the names and colours of what they belong to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.grasp import Grasp, GraspSolution
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.follow import Loading
from handlcp.hand.hand_grasp import make_grasp
from handlcp.show.style import BLUE, GREEN, PURPLE, RED, shortened, turns

# ----------------------------------------------------------------
# The last step of a loading as a grasp of its own, for pictures and tables of what is known of one solve.


def grasp_at_end(loading: Loading) -> Grasp:
    """The grasp at the last step of a loading: its contacts, its load and the hand's posture there."""
    last = loading.last
    return make_grasp(loading.steps.grasp.made(last.iterate, last.loads))


def solution_at_end(loading: Loading) -> GraspSolution:
    """The solution at the last step of a loading, with the slips of the whole way.

    Each slip leads to where the object is, and is as long as the way on which it slid.
    """
    way, slip = loading.steps.slid[-1], loading.steps.slip_on_the_way
    straight = np.hypot(*slip.T)
    ahead = np.where(straight[:, None] > 0.0, slip, (1.0, 0.0)) / np.where(straight > 0.0, straight, 1.0)[:, None]
    return replace(loading.solution, slip=read_only(way[:, None] * ahead))


# ----------------------------------------------------------------

COLOURS = (BLUE, RED, GREEN, PURPLE, "#B87800", "#3A9BD8", "#7A3E00", "#8C8C00")
OTHERS = "#B9BEC4"
LETTERS = 28  # of a curve's name
_MOST = 6  # joints with a name in their panel: those nearest to their limits


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve of a panel over the steps of a loading.

    name : at its end; "" for none. colour : "#rrggbb". values (m,) : at each step, NaN where there is none.
    """

    name: str
    colour: str
    values: Array


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of the figure of a loading: curves of one quantity over the steps.

    title : the quantity with its unit.
    every : what to call all curves when they lie on each other, such as "all 5 fingers".
    limit : value of the line across; None without one.
    least : curves that span less than this, in the panel's unit, show rounding alone.
    """

    title: str
    curves: tuple[Curve, ...]
    every: str
    limit: float | None = None
    least: float = 1e-6


def panels(spec: GraspSpec, forces: Array, used: Array | None, displacement: Array, torques: Array) -> list[Panel]:
    """Normal forces, friction, motion and turn of the object, joint torques: those that this grasp has.

    forces (m, n, 3) [N], displacement (m, 6) [m, rad], torques (m, nv) [N·m] : at m places. used (m, n) : shares of the
    friction limits; None: not known, and no friction is shown.
    """
    scene, mechanism = Grasp(spec).scene, spec.mechanism
    n, names = scene.n, shortened(spec.names, LETTERS)
    colours = [COLOURS[i % len(COLOURS)] for i in range(n)]
    every = f"all {n} {spec.who}s"
    out = [Panel("Normal force [N]", _curves(names, colours, forces[:, :, 2]), every)]
    if used is not None and (scene.mu > 0).any():
        out.append(Panel("Friction [% of its limit]", _curves(names, colours, 100.0 * used), every, 100.0))
    out += _motion_panels(displacement)
    if mechanism is not None:
        out.append(_torque_panel(mechanism.names, torques, mechanism.limits))
    return out


def _curves(names: Sequence[str], colours: Sequence[str], values: Array) -> tuple[Curve, ...]:
    return tuple([Curve(*each) for each in zip(names, colours, values.T, strict=True)])


def _motion_panels(displacement: Array) -> Iterator[Panel]:
    """Of the object since the start, along the world's axes; and its turn, where it turns."""
    colours, move, turn = (RED, GREEN, BLUE), displacement[:, :3], displacement[:, 3:]
    unit = words.length_unit(move.ravel().tolist())
    yield Panel(f"Motion of the object [{unit.name}]", _curves("xyz", colours, move / unit.size), "x, y, z")
    if turns(turn):
        yield Panel("Turn of the object [°]", _curves("xyz", colours, np.degrees(turn)), "x, y, z")


def _torque_panel(names: Sequence[str], torques: Array, limits: Array) -> Panel:
    """Against their limits where these are known; the nearest to them are named."""
    known = np.flatnonzero(np.isfinite(limits) & (limits > 0.0))
    shown = known if len(known) else np.arange(len(names))
    names = shortened(names, LETTERS)
    values = 100 * abs(torques[:, known]) / limits[known] if len(known) else torques
    most = abs(values).max(axis=0)
    ranked = np.argsort(-np.round(most, 6), kind="stable")
    curves = [Curve("", OTHERS, values[:, j]) for j in ranked[_MOST:]]
    curves += [Curve(names[shown[j]], COLOURS[k], values[:, j]) for k, j in enumerate(ranked[:_MOST])]
    title = "Joint torque [% of its limit]" if len(known) else "Joint torque [N·m]"
    if len(ranked) > _MOST:
        title += f", the {_MOST} largest of {len(ranked)} in colour"
    every = f"all {len(curves)} joints"
    near = bool(len(known)) and float(most.max(initial=0.0)) > 50.0
    return Panel(title, tuple(curves), every, 100.0 if near else None)
