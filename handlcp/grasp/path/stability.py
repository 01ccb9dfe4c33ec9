"""Whether a held object stays where it is: pushed a little, does it return?

Under a small push contacts and fingers follow, and the object meets a wrench that is linear in its motion, S u. Moving
against dampers, u̇ = S u: the push dies away where every eigenvalue of S has a negative real part, and grows where one
has not, as in a column that buckles. Newton's method walks through such states. What grows is asked again: a small push
is made, in the motion that grows, and the object moves as it will (`flow`). A contact that slides may stick when it is
pushed back, and S does not know that.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.state import State
from handlcp.lcp.kernels.compile import kernel

# Of the fingers' stiffness: an object that may roll freely stays where it is pushed, which is 0. One whose weight lies
# a hair off the line through two contacts would turn about it, were they points; no fingertip is one.
GROWS = 1e-4


def growth(state: State) -> float:
    """How fast a small push grows: the largest real part of S's eigenvalues, over the fingers' stiffness, or `GROWS`
    where it is no larger and that takes no eigenvalues to see. NaN where it was not measured: no force turns.
    """
    if not len(state.met) or not np.isfinite(state.met).all():
        return np.nan
    if shrinks(state.met, GROWS):
        return GROWS
    return float(np.linalg.eigvals(state.met).real.max())


@kernel
def shrinks(S: Array, most: float) -> bool:
    """Whether the symmetric part of S (k, k) has eigenvalues below `most` alone: then those of S have real parts below
    it, too. `most` times the unit matrix less that part then has a Cholesky factor, by more than rounding.
    """
    k, largest = len(S), 0.0
    L = np.zeros((k, k))
    for i in range(k):
        for j in range(k):
            largest = max(largest, abs(S[i, j]))
    for i in range(k):
        for j in range(i + 1):
            total = (most if i == j else 0.0) - 0.5 * (S[i, j] + S[j, i])
            for a in range(j):
                total -= L[i, a] * L[j, a]
            if i != j:
                L[i, j] = total / L[j, j]
            elif total > 1e-12 * largest:
                L[i, i] = np.sqrt(total)
            else:
                return False
    return True


def growing(state: State, freedom: Array, placement: Array) -> Array:
    """(6,) unit motion that grows, world axes, moments over the contacts' distance. The way along the object's own axes
    (placement (3, 3)) is the one that counts: of two that are as likely, always the same is taken.
    """
    values, vectors = np.linalg.eig(state.met)
    motion: Array = np.real(vectors[:, int(values.real.argmax())]) @ freedom
    own = np.concatenate([placement.T @ motion[:3], placement.T @ motion[3:]])
    largest = own[int(np.argmax(abs(own) >= (1.0 - 1e-6) * abs(own).max()))]
    return np.asarray(np.sign(largest) * motion / np.linalg.norm(motion))
