"""Samples of a grasp whose hand varies by the names of `Hand.vary`: each is made anew, and all else varied after it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp.check import Array, Bools
from handlcp.errors import NoGraspFound
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.request import GraspSpec
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.study.reliability.arrays import Arrays
from handlcp.study.reliability.place import Placer
from handlcp.study.reliability.spread import NUMBER, Dimension
from handlcp.study.varied import vary_grasp


class NumberPlacer(Placer):
    """Makes samples of a hand's grasp where some dimensions are numbers of the hand."""

    def __init__(self, grasp: Grasp, dimensions: tuple[Dimension, ...]) -> None:
        super().__init__(grasp, dimensions)
        self._numbers = np.array([d.parameter == NUMBER for d in dimensions])
        self._others = tuple([d for d in dimensions if d.parameter != NUMBER])

    def arrays(self, values: Array) -> Arrays:
        """What others write, for what is read off arrays; the grasps themselves are made one by one."""
        found = Placer(self.grasp, self._others).arrays(values[:, ~self._numbers])
        made = [self._made(row) for row in values]

        def of(_: GraspSpec, k: float) -> GraspSpec:
            spec = made[int(k)]
            return self.spec if spec is None else spec

        found.samples.remade.append((of, np.arange(len(values), dtype=float)))
        lost = np.array([spec is None for spec in made])
        return replace(found, past=found.past | lost[:, None])

    def _made(self, row: Array) -> GraspSpec | None:
        """The grasp of one sample with values row (d,); None where the fingertips do not come to touch."""
        assert isinstance(self.grasp, HandGrasp)
        numbers = [d.name for d in self.dimensions if d.parameter == NUMBER]
        try:
            grasp = vary_grasp(self.grasp, dict(zip(numbers, row[self._numbers].tolist(), strict=True)))
        except NoGraspFound:
            return None
        others = Placer(grasp, self._others)
        return others.grasp_of(others.arrays(row[None, ~self._numbers]), 0).spec

    def why_not(self, past: Bools) -> str | None:
        """What is wrong with a sample."""
        return "the fingertips of such a hand do not come to touch the object again" if past.any() else None


def placer_of(grasp: Grasp, dimensions: tuple[Dimension, ...]) -> Placer:
    """What makes samples of these dimensions."""
    by_number = any(d.parameter == NUMBER for d in dimensions)
    return NumberPlacer(grasp, dimensions) if by_number else Placer(grasp, dimensions)
