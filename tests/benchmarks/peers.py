"""Other people's solvers, each in a process of its own under the first interpreter that has it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from tests.benchmarks.corpus import Faces, PeersFolder
from tests.benchmarks.peer_driver import MISSING

__all__ = ["DEFAULT", "Answer", "PeerMissing", "answers", "run_peer"]

DEFAULT = ("quantecon-lemke", "siconos-lemke", "siconos-pivot", "siconos-newton-fb", "siconos-nsn-ac", "pin-admm")
DRIVER = Path(__file__).with_name("peer_driver.py")


class Answer(NamedTuple):
    """solved | loose | wrong | gave_up | unposed | died, in the words of the folder's run_peers.py; best time [s]."""

    verdict: str
    seconds: float | None


class PeerMissing(Exception):
    """No interpreter here has it; the message says what each lacks."""


Answers = dict[tuple[str, Faces], Answer]  # by scene and faces


def interpreters() -> Iterator[str]:
    """This one, then what `python3` means here, then the system's (distributions install Siconos for that one only)."""
    found = (sys.executable, shutil.which("python3"), shutil.which("python3", path=os.defpath))
    yield from dict.fromkeys(f for f in found if f)


def run_peer(
    folder: PeersFolder,
    corpus: Path,
    peer: str,
    faces: Iterable[Faces],
    families: Sequence[str] = (),
    repeats: int = 1,
) -> Answers:
    """What the peer makes of every scene. Raises PeerMissing."""
    numbers = [str(f) for f in faces if f != "cone"]
    words = [str(folder.path), str(corpus), peer, "--faces", *numbers, "--repeats", str(repeats)]
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    reasons = []
    for python in interpreters():
        run = subprocess.run(
            [python, str(DRIVER), *words, "--families", *families],
            capture_output=True, text=True, env=environment, check=False,
        )  # fmt: skip
        if run.returncode == 0:
            lines = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
            return {(r["name"], r["faces"]): Answer(r["verdict"], r["seconds"]) for r in lines}
        last = run.stderr.strip().splitlines()[-1:] or [f"exit {run.returncode}"]
        if run.returncode != MISSING and "ModuleNotFoundError" not in last[0]:
            raise RuntimeError(f"{peer}: {run.stderr.strip()}")
        reasons.append(last[0])
    raise PeerMissing(reasons[0])


def answers(
    console: Console,
    folder: PeersFolder,
    corpus: Path,
    peers: Iterable[str],
    faces: Sequence[Faces],
    families: Sequence[str] = (),
    repeats: int = 1,
) -> dict[str, Answers]:
    """All peers that are here and that know these sections; one line for each that is not here."""
    out = {}
    for peer in peers:
        suited = [f for f in faces if (f == "cone") == (folder.peers[peer] == "cone")]
        if not suited:
            continue
        try:
            out[peer] = run_peer(folder, corpus, peer, suited, families, repeats)
        except PeerMissing as e:
            console.print(f"{peer}: skipped, not installed here ({e})", highlight=False)
    return out
