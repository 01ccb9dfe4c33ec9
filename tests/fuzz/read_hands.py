"""Child of `test_urdf`: reads every URDF of a folder and says in one line each what became of it.

Runs apart so that a crash of the interpreter inside a parser written in C++ is seen, and which file it was.
"""

import contextlib
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import handlcp as hl


def read(path):
    """A typed error by its name, "hand" for a hand that can be used, or what went wrong."""
    for look in (hl.audit_urdf, hl.describe_urdf):
        with contextlib.suppress(hl.HandLCPError):
            str(look(path))
    hand = hl.Hand.from_urdf(path, joint_stiffness=2.0, tip_radius=0.01)
    state = hand.at(hand.neutral)
    numbers = [state.jacobian, state.flexibility, state.tip_positions]
    if not all(np.isfinite(a).all() for a in numbers):
        return "NAN in a posture"
    if np.isnan(hand.torque_limits).any() or np.isnan(hand.lower).any() or np.isnan(hand.upper).any():
        return "NAN in limits"
    str(hand.audit())
    str(hand.describe().to_dict())
    tips = state.tip_positions
    contacts = [hl.Contact(p, (1.0, 0, 0)) for p in tips[:3]]
    s = state.grasp(contacts, wrench=(-1, 0, 0, 0, 0, 0), gravity=(0, 0, -9.81)).solve(4, throw=False)
    if s.held and not (np.isfinite(s.forces).all() and np.isfinite(s.torques).all()):
        return "NAN in an answer"
    return f"hand, {s.status.name}"


def main(folder):
    """One line a file, the name first, so that the last one names a file that never came back."""
    warnings.simplefilter("error")
    contacts = [hl.Contact((-0.01, 0, 0), (1, 0, 0)), hl.Contact((0.01, 0, 0), (-1, 0, 0))]
    for load in (1.0, 100.0):  # kernels compile before the clock runs
        grasp = hl.Grasp(contacts, (0, 0, -load, 0, 0, 0), flexibility=1e-4, preload=1e-3)
        grasp.solve(4, throw=False)
    for path in sorted(Path(folder).glob("*.urdf")):
        print(path.name, end=": ", flush=True)
        start = time.monotonic()
        try:
            what = read(path)
        except hl.HandLCPError as error:
            what = f"refused, {type(error).__name__}"
        except BaseException as error:
            what = f"WRONG {type(error).__name__}: {error}"
        took = time.monotonic() - start
        print(what.replace("\n", " "), f"SLOW {took:.0f} s" if took > 10 else "", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
