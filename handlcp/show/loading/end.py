"""The last step of a loading as a grasp of its own, for pictures and tables of what is known of one solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution
from handlcp.grasp.path.follow import Loading
from handlcp.hand.hand_grasp import grasp_of

STILL = 1e-4  # [rad] an object that turns less is not said to turn


def grasp_at_end(loading: Loading) -> Grasp:
    """With the contacts and the load of the last step, the hand in its posture there."""
    last = loading.last
    return grasp_of(loading.steps.grasp.made(last.look, last.loads))


def solution_at_end(loading: Loading) -> GraspSolution:
    """Of that grasp, with the slips of the whole way."""
    return replace(loading.solution, slip=slipped(loading))


def slipped(loading: Loading) -> Array:
    """(n, 2) of the object past each fingertip on the whole way, along the contact axes of the last step [m]."""
    steps = loading.steps
    world = np.einsum("mnij,mnj->ni", steps.frames[..., :2], steps.slip)
    return np.asarray(np.einsum("nij,ni->nj", steps.frames[-1][..., :2], world))


def moved(loading: Loading) -> str:
    """Such as "moved 2.9 mm and turned 0.49°"."""
    u = loading.displacement
    far = f"moved {words.length(float(np.linalg.norm(u[:3])))}"
    turned = float(np.linalg.norm(u[3:]))
    return f"{far} and turned {words.angle(turned)}" if turned > STILL else far
