"""A second opinion on the exact cone that shares no code with the package: Pinocchio's ADMM in a proximal loop.

ADMM knows contacts only: given a compliance W and an offset g it finds forces r in the cone and motions v = W r + g as
friction wants them. The object's twist u is the multiplier of balance G r + w = 0, found by the method of multipliers:
solve with W = E + GᵀG / k and g = d + Gᵀ(u + w / k), then let u grow by (G r + w) / k, until balance holds. A smaller k
means fewer but harder solves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

STRENGTHS = (0.1, 0.01, 0.001)  # k, natural units, tried in turn
Inner = Callable[[np.ndarray], tuple[bool, np.ndarray]]


class Equilibrium(NamedTuple):
    """converged: ADMM says so and the load is balanced. forces (3n,), twist (6,), steps of the outer loop."""

    converged: bool
    forces: np.ndarray
    twist: np.ndarray
    steps: int


class ForceLaw:
    """Forces of n contacts from their offset, for one compliance W (3n, 3n) and friction mu (n,) > 0."""

    def __init__(self, W: np.ndarray, mu: np.ndarray, tolerance: float = 1e-14) -> None:
        model = pin.buildSampleModelManipulator()  # any: the constraints ask for one and do not use it here
        self._models, self._datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        for m in mu.tolist():
            point = pin.PointContactConstraintModel(model, 1)
            point.setFriction(m)
            constraint = pin.ConstraintModel(point)
            self._models.append(constraint)
            self._datas.append(constraint.createData())
        self._W, self._solver = W, pin.ADMMConstraintSolver(len(W))
        self._settings, self._result = pin.ADMMSolverSettings(), pin.ADMMSolverResult()
        s = self._settings
        s.absolute_feasibility_tol = s.absolute_complementarity_tol = tolerance
        s.relative_feasibility_tol = s.relative_complementarity_tol = 0.0
        s.max_iterations = 5000
        s.admm_update_rule = pin.ADMMUpdateRule.SPECTRAL

    def start(self, r: np.ndarray) -> None:
        """Let the next call start from r (3n,)."""
        self._result.setConstraintImpulseGuess(r)

    def __call__(self, g: np.ndarray) -> tuple[bool, np.ndarray]:
        """(whether ADMM calls it converged, r (3n,)); each call starts from the last answer."""
        delassus = pin.DelassusOperatorDense(self._W)
        said = self._solver.solve(delassus, g, self._models, self._datas, self._settings, self._result)
        r = np.array(self._result.retrieveConstraintImpulses())  # tangents, normal: our own order
        if np.isfinite(r).all():
            self.start(r)
        return bool(said), r


def equilibrium(
    G: np.ndarray, E: np.ndarray, w: np.ndarray, d: np.ndarray, mu: np.ndarray,
    tolerance: float = 1e-12, most: int = 300, start: tuple[np.ndarray, np.ndarray] | None = None,
) -> Equilibrium:  # fmt: skip
    """The elastic equilibrium in natural units: G (6, 3n), E (3n, 3n), w (6,), d (3n,), mu (n,), order (x, y, z).

    A contact without friction is given a unit compliance of its own along its tangents, which keeps them free of force.
    tolerance : on |G r + w|. most : outer steps for each k. start : forces and twist to begin with, zero when None;
    a scene can have several equilibria, and this asks for the one nearby.
    """
    rough = np.repeat(mu > 0, 3) | (np.arange(len(d)) % 3 == 2)
    best, least = Equilibrium(False, np.full(len(d), np.nan), np.full(6, np.nan), 0), np.inf
    for k in STRENGTHS:
        W = np.where(np.outer(rough, rough), E + G.T @ G / k, 0.0) + np.diag(1.0 - rough)
        law, u = ForceLaw(W, np.where(mu > 0, mu, 1.0)), np.zeros(6) if start is None else start[1]
        if start is not None:
            law.start(start[0])
        for step in range(most):
            said, r = law(np.where(rough, d + G.T @ (u + w / k), 0.0))
            lost = G @ r + w
            if not np.isfinite(lost).all():
                break
            u, gap = u + lost / k, float(np.linalg.norm(lost))
            if gap < least:
                best, least = Equilibrium(False, r, u, step + 1), gap
            if gap <= tolerance:
                return Equilibrium(said, r, u, step + 1)
    return best
