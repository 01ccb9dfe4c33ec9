"""Forces that statics leaves open, beside MuJoCo: pads of power grasps that are known within a factor of two.

`python -m tests.mujoco power pads [word ...]` computes with MuJoCo what contacts press under the weight, a few seconds
each, where every pad is up to twice as soft or half as soft as it is, along each axis by a factor of its own, and keeps
it in `power_pads.json`. handlcp knows nothing of these factors: `force_bounds(pads=(0.5, 2))` of its own solution says
between what and what every force lies as long as contacts do the same, and MuJoCo's have to lie there, but for what
both differ by where nothing is open. Where MuJoCo's contacts do something else with other pads, bounds promise nothing;
such grasps are named where their forces are outside.
"""

from __future__ import annotations

import pathlib
from typing import NamedTuple

import numpy as np

from handlcp.simulator.object_body import pad_name
from handlcp.simulator.simulation_run import SimulationRun
from tests.mujoco.case import read_rows, write_rows
from tests.mujoco.find_power_grasps import FILE as GRASPS, made

FILE = pathlib.Path(__file__).with_name("power_pads.json")
FACTOR, SEED = 2.0, 7
NOISE = 0.01  # of the largest force: by how much MuJoCo may be outside
SECONDS, SETTLE = 1.0, 0.5  # of squeeze and weight
SLIDES, GONE = 0.97, 1e-3  # share of the friction limit from which a contact slides; of the largest force, below which
# it is gone


def theirs(grasp, seed):
    """(n, 3) forces on the object of MuJoCo with other pads [N], world axes; None where it is lost."""
    run, random = SimulationRun(grasp, None, None), np.random.default_rng(seed)
    model = run.model
    for name in grasp.names:
        body = model.body(pad_name(name))
        for joint in range(int(body.jntadr[0]), int(body.jntadr[0] + body.jntnum[0])):
            times = FACTOR ** random.uniform(-1.0, 1.0)
            dof = model.jnt_dofadr[joint]
            model.jnt_stiffness[joint] *= times
            model.dof_damping[dof] *= times
            model.dof_armature[dof] *= times
    held = all(run.run_stage(stage, SECONDS, SETTLE) for stage in run.with_own_stages(("squeeze", "weight")))
    return run.track.readings[-1].forces if held else None


class Found(NamedTuple):
    """Of one grasp, as shares of the largest force. out : by how much MuJoCo's forces are outside of bounds at most.
    moved : by how much they differ from those of the grasp with its own pads. wide : of bounds, in the median. other :
    contacts that do something else in MuJoCo.
    """

    out: float
    moved: float
    wide: float
    other: tuple[str, ...]


def outside(grasp, forces):
    """Of forces (n, 3) of MuJoCo with other pads."""
    solution = grasp.follow().solution
    bounds = solution.force_bounds(pads=(1.0 / FACTOR, FACTOR)).forces
    own = np.einsum("nji,nj->ni", solution.spec.frames, forces)
    sizes = np.linalg.norm(forces, axis=1)
    out = np.maximum(bounds[..., 0] - own, own - bounds[..., 1]).max()
    moved = np.linalg.norm(solution.forces_world - forces, axis=1).max()
    mu = np.array([contact.friction.mu for contact in solution.spec.contacts])
    slides = np.linalg.norm(own[:, :2], axis=1) >= SLIDES * mu * own[:, 2]
    does = np.where(sizes <= GONE * sizes.max(), "separated", np.where(slides, "sliding", "sticking"))
    pairs = zip(solution.names, solution.contact_state, does, strict=True)
    other = tuple([name for name, ours, its in pairs if ours != its])
    return Found(
        max(float(out), 0.0) / sizes.max(), moved / sizes.max(), np.median(np.ptp(bounds, -1)) / sizes.max(), other
    )


def stored():
    """Forces by the titles of grasps; nothing without the file."""
    return read_rows(FILE)


def summary(grasps):
    """Print how many of the grasps are inside; whether all are of those that are stored."""
    rows, known = stored(), read_rows(GRASPS)
    found = {name: outside(made(known[name]), np.array(rows[name])) for name in grasps if name in rows}
    if not found:
        print("pads within a factor of two: none stored")
        return False
    far = {name: f for name, f in found.items() if f.out > NOISE}
    for name, f in far.items():
        does = f"; {', '.join(f.other)} do something else there" if f.other else ""
        print(f"{name}: outside of force_bounds by {100 * f.out:.1f} % of the largest force{does}")
    wrong = [f.out for f in far.values() if not f.other]
    moved, wide = [f.moved for f in found.values()], [f.wide for f in found.values()]
    print(
        f"within force_bounds with pads known within a factor of two: {len(found) - len(far)} of {len(found)}", end=" "
    )
    print(f"grasps; of the others {len(wrong)} where contacts do the same; such pads change forces by", end=" ")
    print(f"{100 * min(moved):.0f} to {100 * max(moved):.0f} %, bounds are {100 * np.median(wide):.0f} % wide")
    return not wrong


def main(words):
    """Compute them with MuJoCo, for the grasps whose titles hold one of the words, and put them into the file; 0."""
    known = read_rows(GRASPS)
    for name in known:
        if words and not any(word in name for word in words):
            continue
        forces = theirs(made(known[name]), SEED)
        found = {} if forces is None else {name: np.round(forces, 5).tolist()}
        others = {title: row for title, row in stored().items() if title != name}
        write_rows(FILE, dict(sorted((others | found).items())))
        said = "lost" if forces is None else f"largest {np.linalg.norm(forces, axis=1).max():.3f} N"
        print(f"{name:32s} {said}", flush=True)
    return 0
