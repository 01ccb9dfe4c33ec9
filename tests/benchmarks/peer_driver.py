"""One peer over a corpus, scene by scene, under whatever interpreter has it: nothing of this package is imported.

    python peer_driver.py PEERS_FOLDER CORPUS PEER --faces 4 8 --repeats 3

Prints a JSON line for each scene and number of faces: its name, the verdict, the best time in seconds. Exits with 3 and
one line where the peer is missing. The folder's own command prints counts only.
"""

from __future__ import annotations

import argparse
import json
import math
import sys

MISSING = 3


def main() -> None:
    """Run what the command line asks for."""
    options = argparse.ArgumentParser()
    for name in ("folder", "corpus", "peer"):
        options.add_argument(name)
    options.add_argument("--faces", type=int, nargs="*", default=[])
    options.add_argument("--families", nargs="*", default=[])
    options.add_argument("--repeats", type=int, default=1)
    options.add_argument("--limit", type=int, default=20)
    o = options.parse_args()
    sys.path.insert(0, o.folder)
    from run_peers import PEERS, guarded
    from scenes import read

    kind, make, package = PEERS[o.peer]
    try:
        peer = make()
    except (ImportError, AttributeError) as e:
        print(f"{e}; it needs {package}", file=sys.stderr)
        sys.exit(MISSING)
    scenes = [s for s in read(o.corpus) if not o.families or s.family in o.families]
    for faces in o.faces if kind == "lcp" else [None]:
        for scene, (verdict, seconds) in zip(scenes, guarded(peer, scenes, faces, o.repeats, o.limit), strict=True):
            time = seconds if math.isfinite(seconds) else None
            print(json.dumps({"name": scene.name, "faces": faces or "cone", "verdict": verdict, "seconds": time}))


if __name__ == "__main__":
    main()
