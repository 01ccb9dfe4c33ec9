"""An oracle that shares no code with the solvers: every active set of a small problem, one after the other."""

import itertools

import numpy as np


def every_solution(M, q, free=None, tolerance=1e-9):
    """All solutions found by solving M_AA z_A = -q_A for each of the 2^k active sets A (least squares where singular).

    M (n, n), q (n,), free (n,) bool. Isolated solutions are all found; of a continuum, one member per active set.
    """
    M, q = np.asarray(M, float), np.asarray(q, float)
    n = len(q)
    free = np.zeros(n, bool) if free is None else np.asarray(free)
    pairs = np.flatnonzero(~free)
    out = []
    for choice in itertools.product((False, True), repeat=len(pairs)):
        on = free.copy()
        on[pairs[list(choice)]] = True
        z = np.zeros(n)
        if on.any():
            z[on] = np.linalg.lstsq(M[np.ix_(on, on)], -q[on], rcond=None)[0]
        w = M @ z + q
        size = tolerance * max(1.0, abs(z).max(initial=0.0))
        fits = (abs(w[free]) <= size).all() and (np.minimum(z, w)[~free] >= -size).all()
        if fits and (abs(np.minimum(z, w)[~free]) <= size).all() and not any(np.allclose(z, y, atol=1e-7) for y in out):
            out.append(z)
    return out
