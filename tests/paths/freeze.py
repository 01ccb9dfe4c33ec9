"""What a package says of every scene, written to a file: limits, what binds, events, forces, verdicts; and which grasps
hold their squeeze and weight (`accept`).

A file is gzipped JSON, a line for each scene: "number" of seed 0, "direction", "factor"
(null: infinite), "binds" as [kind, who], "marks" ("first_slip", "slides" and "lost" of the limit, null: never),
"fixed" (of a hand the factor in one posture), "events" (how many), "forces" at the end of squeeze and weight [N]
contact by contact, "check" (its words at 0.95 and 1.05 of the factor), "follow" (whether these are reached),
"seconds", and "stopped" where the time was over or an error came.
"""

from __future__ import annotations

import gzip
import json
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import handlcp as hl
from tests.paths import corpus
from tests.paths.contradictions import BELOW, BEYOND, FAR
from tests.paths.corpus import Case, accepted, case_of, held
from tests.paths.time_limit import TookTooLong, at_most
from tests.paths.words import checked, followed, limit_of

DIFFERS = 0.01
FROZEN = Path(__file__).with_name("frozen.json.gz")
MARKS = ("first_slip", "slides", "lost")
LONGEST = 10.0  # a case that takes longer is not accepted [s]


def accept(numbers: int, out: Path) -> int:
    """Try the numbers of seed 0 below this that were not tried yet, and write those that hold."""
    known = accepted(out)
    for number in range(known["tried"], numbers):
        try:
            with at_most(LONGEST):
                known["0"] += [number] * held(case_of(0, number))
        except TookTooLong:
            pass
        known["tried"] = number + 1
        if number % 50 == 49 or number == numbers - 1:
            out.write_text(json.dumps(known, separators=(",", ":")) + "\n", encoding="utf-8")
            print(f"{number + 1} tried, {len(known['0'])} hold", flush=True)
    return 0


def frozen(path: Path = FROZEN) -> list[dict[str, Any]]:
    """The scenes of a file."""
    return [json.loads(line) for line in gzip.decompress(path.read_bytes()).decode("utf-8").splitlines()]


def scene(case: Case, direction: int) -> dict[str, Any]:
    """Everything that is written of one case and direction, but the seconds."""
    told: dict[str, Any] = {"number": case.number, "direction": direction}
    start = case.grasp.follow(np.zeros(6), geometry=case.geometry, faces=case.faces)
    told["forces"] = np.round(np.asarray(start.steps.forces[-1]), 5).tolist()
    way = case.directions[direction]
    limit = limit_of(case, way)
    told["factor"] = _finite(limit.factor)
    told["marks"] = {mark: getattr(limit, mark) for mark in MARKS}
    if case.geometry != "fixed":
        told["fixed"] = _finite(case.grasp.load_limit(way, geometry="fixed", faces=case.faces).factor)
    told["binds"] = sorted([b.kind, b.who] for b in limit.binds)
    told["events"] = len(limit.events)
    shares = (BELOW, BEYOND)
    size = limit.factor
    if not np.isfinite(size):
        shares, size = (FAR,), float(start.steps.forces[-1, :, 2].sum())
    if size > 0.0:
        told["check"], told["follow"] = [], []
        for share in shares:
            told["follow"].append(followed(case, share * size * way)[0].said)
            told["check"].append(checked(case, share * size * way).said)
    return told


def _finite(factor: float) -> float | None:
    """A factor as JSON has it."""
    return float(factor) if np.isfinite(factor) else None


def freeze(cases: int, out: Path, seconds: float, directions: int) -> int:
    """Write so many scenes, `directions` of each case, none longer than so many seconds. Lines are kept beside the file
    as they come, with the ending jsonl: another run goes on after them, or after those of the file itself.
    """
    plain = out.with_name(out.name.removesuffix(".gz").removesuffix(".json") + ".jsonl")
    if out.is_file() and not plain.is_file():
        plain.write_bytes(gzip.decompress(out.read_bytes()))
    before = plain.read_text(encoding="utf-8").splitlines() if plain.is_file() else []
    done = {(x["number"], x["direction"]) for x in map(json.loads, before)}
    with plain.open("a", encoding="utf-8") as lines:
        for case in corpus.cases(-(-cases // directions)):
            for k in range(directions):
                direction = (case.number + 5 * k) % len(case.directions)
                if (case.number, direction) not in done:
                    lines.write(json.dumps(_timed(case, direction, seconds), separators=(",", ":")) + "\n")
                    lines.flush()
            if case.number % 20 == 0:
                pack(plain, out)
    pack(plain, out)
    return 0


def compare(file: Path, scenes: int, seconds: float) -> int:
    """Print where the package that is imported says otherwise than a file: factor by 1 %, in one posture too; words at
    0.95 and 1.05; forces at the end of squeeze and weight by 1 %. The number of scenes that differ.
    """
    tally = Counter[str]()
    for old in frozen(file)[:scenes]:
        case = case_of(0, old["number"])
        new = _timed(case, old["direction"], seconds)
        said = {what: text for what, text in _differences(old, new).items() if text}
        tally += Counter({what: 1 for what in said} | {"scenes": 1, "differ": bool(said)})
        if said:
            told = "; ".join(f"{what} {text}" for what, text in said.items())
            print(f"(0, {case.number}, {old['direction']}) {case.name}: {told}", flush=True)
    print(dict(tally))
    return tally["differ"]


def _differences(old: dict[str, Any], new: dict[str, Any]) -> dict[str, str]:
    """What differs between two lines of one scene: then and now; "": nothing."""
    if stopped := [f"{when}: {x['stopped']}" for when, x in (("then", old), ("now", new)) if "stopped" in x]:
        return {"stopped": ", ".join(stopped)}
    first, then = np.array(old["forces"]), np.array(new["forces"])
    off = float(abs(first - then).max() / max(abs(first).max(), 1e-12))
    found = {"forces": f"{100 * off:.1f} % off" if off > DIFFERS else ""}
    for name in ("factor", "fixed"):
        a, b = (np.inf if x[name] is None else x[name] for x in (old, new)) if name in old else (0.0, 0.0)
        far = a != b and not abs(a - b) <= DIFFERS * max(abs(a), abs(b))
        found[name] = f"{a:.5g}, now {b:.5g}" if far else ""
    for what, word_of in (("follow", lambda said: said == "reached"), ("check", lambda said: said.partition(" (")[0])):
        one, two = old.get(what), new.get(what)
        words = [None if each is None else [word_of(said) for said in each] for each in (one, two)]
        found[what] = f"{one}, now {two}" if words[0] != words[1] else ""
    return found


def _timed(case: Case, direction: int, most: float) -> dict[str, Any]:
    begun, told = time.process_time(), {"number": case.number, "direction": direction}
    try:
        with at_most(most):
            told = scene(case, direction)
    except TookTooLong as why:
        told["stopped"] = str(why)
    except hl.HandLCPError as why:
        told["stopped"] = f"{type(why).__name__}: {why}"[:200]
    told["seconds"] = round(time.process_time() - begun, 2)
    return told


def pack(plain: Path, out: Path) -> None:
    """The file as it is kept, byte for byte the same for the same lines."""
    with out.open("wb") as raw, gzip.GzipFile(fileobj=raw, mode="wb", mtime=0, filename="") as file:
        file.write(plain.read_bytes())
