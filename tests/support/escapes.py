"""Whether a motion proves by its signs that nothing holds an object: no contact resists it, and the load drives it."""

import numpy as np

from tests.support.friction_sets import corners, reach
from tests.support.laws import spread


def escapes(case, twist):
    """Of `case` (as in `laws.of_case`) with a twist (6,) about its reference: no contact's force resists it beyond
    rounding. Exact cone: the least work of a force in it is v_N - μ|v_T|.
    """
    t = np.asarray(twist, float)
    centre, L = case.p.mean(0), spread(case.p)
    at_c = t[:3] + np.cross(t[3:], centre - case.reference)
    moment = case.w[3:] - np.cross(centre, case.w[:3])
    size = np.hypot(np.linalg.norm(at_c), L * np.linalg.norm(t[3:]))
    load = np.hypot(np.linalg.norm(case.w[:3]), np.linalg.norm(moment) / L)
    if not (np.isfinite(t).all() and size > 0 and load > 0):
        return False
    gain = (case.w[:3] @ at_c + moment @ t[3:]) / (load * size)
    faces = 2 if case.plane is not None else case.faces
    resisting = 0.0
    for p, R, mu in zip(case.p, case.R, case.mu, strict=True):
        v = R.T @ (at_c + np.cross(t[3:], p - centre)) / size
        r = reach(mu, faces)
        if faces == "cone":
            least = v[2] - r * np.hypot(v[0], v[1])
        elif faces == 2:
            least = v[2] - r * abs(v[0])
        else:
            least = v[2] + r * (corners(faces) @ v[:2]).min() if r > 0 else v[2]
        resisting = max(resisting, -least)
    return bool(gain > 1e-9 and resisting < 1e-3 * gain and resisting < 1e-6)
