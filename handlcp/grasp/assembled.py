"""What an assembled problem with friction as a set knows of its unknowns, whatever form a solver wants it in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

import numpy as np

from handlcp.check import Array
from handlcp.grasp.candidate import Candidate, decode, encode
from handlcp.grasp.effects import Effect
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["Assembled", "picked"]


class Assembled:
    """groups : the unknowns of all effects. effects : what was stamped. scene : what was assembled."""

    groups: tuple[Unknown, ...]
    effects: tuple[Effect, ...]
    scene: Scene
    _system: System

    def of(self, scene: Scene, system: System, effects: tuple[Effect, ...]) -> Self:
        """Told what it was assembled from."""
        self.groups, self.effects, self._system, self.scene = system.layout.groups, effects, system, scene
        return self

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every unknown, such as "r_T[2]"."""
        return tuple(f"{g.name}[{k}]" for g in self.groups for k in range(g.count))

    def candidate(self, x: Array) -> Candidate:
        """Forces and motion from x (n,) in natural units."""
        return decode(self.scene, self._system, self.effects, x)

    def natural(self, candidate: Candidate) -> Array:
        """(n,) x with these forces, motion and unknowns of further effects, the way back from `candidate`."""
        return encode(self.scene, self._system, candidate)


def picked(every: Callable[[Array], Array], there: System, here: System) -> Callable[[Array], Array]:
    """How the z of a problem with multipliers, whose unknowns `every` lists, becomes an x of one without them."""

    def back(z: Array) -> Array:
        full, x = every(z), np.empty(len(here.q))
        for name, at in here.at.items():
            x[at] = full[there.at[name]]
        return x

    return back
