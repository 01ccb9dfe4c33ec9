"""What the main job costs: posture → torques for the five-finger hand, against bare Pinocchio in the same run.

    python tests/benchmarks/main_job.py

Prints the split of one warm call, NSNGRK's cost per step, and import times. Absolute times move with the machine and
its load; the ratios are what carries over. Medians over many calls, garbage collection off.
"""

from __future__ import annotations

import gc
import os
import pathlib
import subprocess
import sys
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
os.environ.setdefault("HANDLCP_KERNELS", "compiled")  # compiled code is what is timed
sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))  # run as a file, it finds what it takes from the tests

import numpy as np
import pinocchio as pin
from rich.console import Console
from rich.table import Table

import handlcp as hl
from tests.support.lcp import Kaczmarz
from tests.support.steps import OneCall

FACES = 8


def median_us(call, repeats=400, warm=20):
    """Median time of one call [µs]."""
    for _ in range(warm):
        call()
    times = np.empty(repeats)
    gc.disable()
    for k in range(repeats):
        start = time.perf_counter()
        call()
        times[k] = time.perf_counter() - start
    gc.enable()
    return 1e6 * float(np.median(times))


def main_job(console: Console) -> None:
    """The split of one call."""
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    q = hand.close_on(ball, squeeze=3e-3)
    detected = hand.at(q).grasp(ball, hl.Coulomb(0.6))
    contacts, load = detected.contacts, np.array([0, 0, -0.2 * 9.81, 0, 0, 0])
    offset, reference = detected.offset, detected.reference
    model, data = hand.model, hand.model.createData()
    tips = [model.getFrameId(name) for name in hand.fingertips]

    def bare():
        pin.framesForwardKinematics(model, data, q)
        pin.computeJointJacobians(model, data, q)
        for tip in tips:
            pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)

    def grasp(state):
        return state.grasp(contacts, wrench=load, offset=offset, reference=reference)

    def whole():
        return grasp(hand.at(q)).solve(FACES)

    state = hand.at(q)
    g = grasp(state)
    call = OneCall(g, FACES)
    call.pack()
    call.answer()
    found, stream = call.read(), hl.GraspStream(g, FACES)

    one = median_us(bare)
    rows = [
        ("bare Pinocchio: FK, joint Jacobians, 5 frame Jacobians", one),
        ("hand.at(q): FK, Jacobians, E at the tips", median_us(lambda: hand.at(q))),
        ("state.grasp(contacts): J and E at the contacts, contact axes", median_us(lambda: grasp(state))),
        ("the scene as a row of numbers", median_us(call.pack)),
        (
            "units, stamps, solver, certificate, states: one call",
            median_us(call.answer),
        ),
        ("the answer in SI, torques, limits", median_us(lambda: call.conclude(found))),
    ]
    total = median_us(whole)
    table = Table(
        title=f"posture → torques, five fingers, {FACES} faces, {call.unknowns} unknowns",
        title_justify="left",
    )
    for name in ("step", "µs", "× bare"):
        table.add_column(name, justify="left" if name == "step" else "right")
    for name, us in rows:
        table.add_row(name, f"{us:.1f}", f"{us / one:.1f}")
    table.add_section()
    table.add_row(
        "sum of the parts", f"{sum(us for _, us in rows[1:]):.1f}", f"{sum(us for _, us in rows[1:]) / one:.1f}"
    )
    table.add_row("the whole call, measured as one", f"{total:.1f}", f"{total / one:.1f}", style="bold")
    update = median_us(lambda: stream.update(q, wrench=load).torques)
    table.add_row("the same as an update of a stream", f"{update:.1f}", f"{update / one:.1f}", style="bold")
    detect = median_us(lambda: hand.at(q).grasp(ball, hl.Coulomb(0.6)).solve(FACES), 200)
    table.add_row("the same with contact detection by coal", f"{detect:.1f}", f"{detect / one:.1f}")
    console.print(table)


def kaczmarz_step(console: Console) -> None:
    """Time per step at growing n: O(n)."""
    table = Table(title="NSNGRK, one Kaczmarz step", title_justify="left")
    for name in ("n", "µs", "ns per unknown"):
        table.add_column(name, justify="right")
    rng = np.random.default_rng(0)
    for n in (45, 90, 180, 360, 720):
        A = rng.normal(size=(n, n)) / np.sqrt(n)
        M = A @ A.T + (A - A.T)
        q, steps = rng.normal(size=n), 2000
        method = Kaczmarz(M, q, np.zeros(n, bool))

        def run(method=method, q=q, n=n, steps=steps):
            method.run(np.zeros(n), q.copy(), 0, steps)

        us = median_us(run, 15, 2) / steps
        table.add_row(str(n), f"{us:.3f}", f"{1e3 * us / n:.1f}")
    console.print(table)


def imports(console: Console) -> None:
    """Import times in fresh processes."""
    table = Table(title="import, fresh process, median of 7", title_justify="left")
    table.add_column("module")
    table.add_column("s", justify="right")
    times = {}
    for module, more in (("pinocchio", ""), ("handlcp", "; handlcp.Hand, handlcp.Grasp")):  # names bring what they need
        code = f"import time; t = time.perf_counter(); import {module}{more}; print(time.perf_counter() - t)"
        runs = [
            float(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout)
            for _ in range(7)
        ]
        times[module] = float(np.median(runs))
        table.add_row(module, f"{times[module]:.2f}")
    table.add_row("handlcp over pinocchio", f"{times['handlcp'] - times['pinocchio']:.2f}", style="bold")
    console.print(table)


if __name__ == "__main__":
    out = Console()
    main_job(out)
    kaczmarz_step(out)
    imports(out)
