"""The solver's measures in one command: stability beside the peers, speed with the split, agreement with ADMM.

    python -m tests.benchmarks.solver all PEERS_FOLDER --json results.json
    python -m tests.benchmarks.solver stability PEERS_FOLDER --families ring stiff --faces 8 cone --no-peers
    python -m tests.benchmarks.solver speed PEERS_FOLDER
    python -m tests.benchmarks.solver agreement PEERS_FOLDER

PEERS_FOLDER holds scenes.py, problems.py and run_peers.py. Corpora are made by its scenes.py unless given. Every solver
runs on one thread. `pip install '.[bench]'` brings QuantEcon; a peer that is missing is named and left out.
"""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.benchmarks import agreement, peers, report, speed, stability
from tests.benchmarks.corpus import Faces, PeersFolder, read_oracle


def section(word: str) -> Faces:
    """A number of faces, or "cone"."""
    if word == "cone":
        return word
    if word.isdecimal() and int(word) >= 3:
        return int(word)
    raise argparse.ArgumentTypeError(f'expected "cone" or a number of faces ≥ 3, got {word!r}')


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measure", choices=["stability", "speed", "agreement", "all"])
    parser.add_argument("folder", type=Path, metavar="PEERS_FOLDER")
    parser.add_argument("--corpus", type=Path, help="npz made by the folder's scenes.py; default: made anew")
    parser.add_argument("--count", type=int, default=40, help="scenes a family in a corpus made anew")
    parser.add_argument("--ring", type=Path, help="speed: npz of scenes; default: 60 rings of five fingers, made anew")
    parser.add_argument("--families", nargs="*", default=[], metavar="FAMILY")
    parser.add_argument("--faces", nargs="*", type=section, help="stability: default 4 8 16 cone")
    parser.add_argument("--peers", nargs="*", default=list(peers.DEFAULT), metavar="PEER")
    parser.add_argument("--no-peers", dest="peers", action="store_const", const=[])
    parser.add_argument("--oracle", type=Path, nargs="*", default=[], help="files written by the folder's problems.py")
    parser.add_argument("--known", type=Path, help="--json of an earlier run: its peers' verdicts are taken over")
    parser.add_argument("--rounds", type=int, default=5, help="speed: rounds of three calls each, the best counts")
    parser.add_argument("--json", type=Path, help="write everything measured to this file")
    return parser.parse_args()


def main() -> None:
    """Measure, print, write."""
    o = arguments()
    console, folder = report.opened(180), PeersFolder(o.folder)
    if unknown := set(o.peers) - set(folder.peers):
        sys.exit(f"--peers: expected some of {', '.join(folder.peers)}, got {', '.join(sorted(unknown))}")
    results: dict[str, Any] = {"conditions": report.conditions()}
    console.print(results["conditions"], highlight=False)
    everything = o.measure == "all"
    with tempfile.TemporaryDirectory() as directory:
        corpus, ring = o.corpus, o.ring
        if o.measure != "speed" and corpus is None:
            corpus = folder.generate(Path(directory) / "corpus.npz", "--count", str(o.count))
        if everything or o.measure == "stability":
            known = json.loads(o.known.read_text())["stability"] if o.known else []
            oracle = {key: verdict for path in o.oracle for key, verdict in read_oracle(path).items()}
            faces = o.faces or [4, 8, 16, "cone"]
            records = stability.measure(console, folder, corpus, faces, o.families, o.peers, oracle, known)
            report.print_stability(console, records)
            results["stability"] = [r.asdict() for r in records]
        if everything or o.measure == "agreement":
            results["agreement"] = agreement.measure(console, folder, corpus, o.families)
        if everything or o.measure == "speed":
            if ring is None:
                options = ("--count", "60", "--family", "ring", "--fingers", "5")
                ring = folder.generate(Path(directory) / "ring.npz", *options)
            results["speed"] = speed.measure(console, folder, ring, o.peers, o.rounds)
    if o.json:
        o.json.write_text(json.dumps(results, indent=1, default=float))


if __name__ == "__main__":
    main()
