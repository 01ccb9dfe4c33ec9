"""The exact-cone equilibrium next to an answer, in extended precision: what force errors are measured against.

Newton's method on the laws of the model as projections, with residuals in numpy's longdouble (eps 1e-19 on x86) and
steps from double least squares, so that each step gains some digits until the residual is down to the longdouble's
own rounding. It starts from the scene's raw data and shares no code with the package's estimate:

    balance   Σ R f + w = 0            normal    f_N = max(f_N - ρ v_N, 0)            v = Rᵀ(u + ω × a) + E f + d
    friction  f_T = P(f_T - ρ v_T), P the projection on the disc of radius μ f_N (in a plane: on the interval)
    total     z̄ = max(z̄ - (limit - Σ f_N), 0), and z̄ opens every gap

Where motions or forces are not determined, the steps of least norm lead to the nearest member.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import handlcp as hl
from tests.support.grasp import arrays

__all__ = ["Truth", "force_error", "refine"]

L = np.longdouble
_RANK = 1e-10  # singular values below this share of the largest leave something free
# Residual in units of the scene that counts as none: most end at 1e-19. Two fingers can't balance what rounding leaves
# of a load's moment about the line through them, so no answer to those scenes is exact.
_EXACT = 1e-15
_STEPS = 40


@dataclass(frozen=True)
class Truth:
    """forces (n, 3) longdouble [N], contact axes. unit : size of load and squeeze [N]. residual : relative, 1e-18 or so
    where it was found to the end.
    """

    forces: np.ndarray
    unit: float
    residual: float

    @property
    def found(self) -> bool:
        """Whether it is exact beyond double precision."""
        return self.residual < _EXACT


def force_error(forces: np.ndarray, truth: Truth) -> float:
    """max_i |f_i - f*_i| / max_i |f*_i|; over load and squeeze where no finger pushes."""
    size = np.sqrt((truth.forces**2).sum(1)).max()
    off = np.sqrt(((forces.astype(L) - truth.forces) ** 2).sum(1)).max()
    return float(off / (size if size > 1e-7 * truth.unit else truth.unit))


def refine(grasp: hl.Grasp, solution: hl.GraspSolution) -> Truth:
    """From a solution's forces, motion and further unknowns; of what several scales ρ lead to, the nearest.

    Where forces are not determined, ρ decides which member Newton's method finds.
    """
    found = [_newton(_Laws(grasp, rho), solution) for rho in (1.0, 0.1, 10.0)]
    exact = [t for t in found if t.found]
    if exact:
        return min(exact, key=lambda t: force_error(solution.forces, t))
    return min(found, key=lambda t: t.residual)


def _newton(laws: _Laws, solution: hl.GraspSolution) -> Truth:
    x = laws.start(solution)
    best, least = x, np.inf
    for _ in range(_STEPS):
        F, J = laws(x)
        rows = abs(J).max(1)
        rows[rows == 0] = 1.0
        r = float((abs(F) / rows).max() / max(1.0, float(abs(x).max())))
        if r > 0.5 * least and least < _EXACT:  # the extended precision's own rounding
            break
        if r < least:
            best, least = x, r
        U, s, Vt = np.linalg.svd(J / rows[:, None])
        keep = s > _RANK * s[0]
        x = x - (Vt[keep].T @ ((U[:, keep].T @ (F / rows).astype(float)) / s[keep])).astype(L)
    return Truth((best[: laws.k] * L(laws.force)).reshape(-1, 3), laws.force, least)


class _Laws:
    """F (N,) longdouble and its derivative (N, N) double, unknowns (forces 3n, motion 6, z̄) in units of the scene."""

    def __init__(self, grasp: hl.Grasp, rho: float) -> None:
        s = self.scene = arrays(grasp)
        u = s.units
        self.force, self.motion, self.length, n = u.force_unit, u.motion_unit, u.length_unit, s.n
        self.reference, self.centre = grasp.reference, u.centre
        self.k = 3 * n
        R = s.frames.astype(L)
        a = (s.positions.astype(L) - u.centre.astype(L)) / L(u.length_unit)
        G = np.zeros((6, 3 * n), L)
        for i in range(n):
            G[:3, 3 * i : 3 * i + 3] = R[i]
            G[3:, 3 * i : 3 * i + 3] = np.cross(a[i], R[i].T).T
        F, m, c = s.force.astype(L), s.moment.astype(L), u.centre.astype(L)
        self.load = np.r_[F, (m - np.cross(c, F)) / L(u.length_unit)] / L(u.force_unit)
        if s.plane is not None:  # forces in the plane, the moment about its normal
            W = s.freedom.astype(L)
            G, self.load = W @ G, W @ self.load
        self.G, self.dof = G, len(G)
        self.E = s.flexibility.astype(L) * L(u.force_unit) / L(u.motion_unit)
        self.d = s.offset.astype(L).ravel() / L(u.motion_unit)
        own = np.array([max(float(np.trace(self.E[i : i + 3, i : i + 3])) / 3, 0) for i in range(0, 3 * n, 3)])
        self.rho = rho / np.where(own > 0, np.maximum(own, 1e-6 * own.max()), 1.0)
        bounds = [e for e in grasp.effects if isinstance(e, hl.TotalForceBound)]
        self.limit = L(bounds[0].limit) / L(u.force_unit) if bounds else None
        self.given = {e.contact: e.force.astype(L) / L(u.force_unit) for e in grasp.effects if hasattr(e, "contact")}

    def start(self, solution: hl.GraspSolution) -> np.ndarray:
        """(N,) the unknowns of a solution."""
        t, arm = solution.object_displacement.astype(L), (self.centre - self.reference).astype(L)
        t = np.r_[t[:3] + np.cross(t[3:], arm), t[3:] * L(self.length)] / L(self.motion)
        if self.scene.plane is not None:
            t = self.scene.freedom.astype(L) @ t
        x = np.r_[solution.forces.astype(L).ravel() / L(self.force), t]
        return x if self.limit is None else np.r_[x, solution.extra["z̄"].astype(L) / L(self.motion)]

    def __call__(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s, k, dof = self.scene, self.k, self.dof
        N = len(x)
        f, t = x[:k], x[k : k + dof]
        V = np.zeros((k, N))
        V[:, :k], V[:, k : k + dof] = self.E, self.G.T
        v = self.E @ f + self.G.T @ t + self.d
        if self.limit is not None:
            normals = [3 * i + 2 for i in range(s.n) if s.force_unknown[i]]
            v[normals] += x[-1]
            V[normals, -1] = 1.0
        F, J = np.zeros(N, L), np.zeros((N, N))
        F[k : k + dof], J[k : k + dof, :k] = self.G @ f + self.load, self.G
        J[np.arange(k), np.arange(k)] = 1.0  # of f itself; what the projections take away follows
        for i in range(s.n):
            at = slice(3 * i, 3 * i + 3)
            if i in self.given:
                F[at] = f[at] - self.given[i]
                continue
            g, rho = 3 * i + 2, L(self.rho[i])
            push = f[g] - rho * v[g]
            F[g] = f[g] - max(push, L(0))
            unit = np.zeros((3, N))
            unit[:, at] = np.eye(3)
            trial = unit - float(rho) * V[at]  # derivative of f - ρ v
            if push > 0:
                J[g] -= trial[2]
            mu, x0, y0 = L(s.mu[i]), f[3 * i] - rho * v[3 * i], f[3 * i + 1] - rho * v[3 * i + 1]
            a, slope = (mu * f[g], float(mu)) if f[g] > 0 else (L(0), 0.0)
            if s.plane is not None:
                y0, trial[1] = L(0), 0.0
            r = np.sqrt(x0 * x0 + y0 * y0)
            if mu > 0 and r <= a:
                P, D = np.array([x0, y0]), trial[:2]
            elif mu > 0:
                e = np.array([x0, y0]) / r
                P, h = a * e, e.astype(float)
                D = float(a / r) * (trial[:2] - np.outer(h, h @ trial[:2])) + slope * np.outer(h, unit[2])
            else:
                P, D = np.zeros(2, L), np.zeros((2, N))
            F[3 * i : 3 * i + 2] = f[3 * i : 3 * i + 2] - P
            J[3 * i : 3 * i + 2] -= D
        if self.limit is not None:
            slack = self.limit - f[normals].sum()
            open_ = x[-1] - slack > 0
            F[-1] = slack if open_ else x[-1]
            J[-1, normals if open_ else -1] = -1.0 if open_ else 1.0
        return F, J
