"""The peers' folder: its corpus of scenes as grasps, its checker, its oracle's verdicts."""

from __future__ import annotations

import argparse
import importlib
import json
import subprocess
import sys
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import handlcp as hl
from tests.hard_cases.scenes import Case

__all__ = ["Faces", "PeersFolder", "as_case", "family_options", "read_oracle"]

Faces = int | str  # of the pyramid, or "cone"


class PeersFolder:
    """A folder with scenes.py, problems.py and run_peers.py. It is imported from where it is."""

    def __init__(self, folder: Path) -> None:
        self.path = folder.resolve()
        missing = [f for f in ("scenes.py", "problems.py", "run_peers.py") if not (self.path / f).is_file()]
        if missing:
            sys.exit(f"{folder}: expected a folder with scenes.py, problems.py and run_peers.py, no {missing[0]} there")
        if str(self.path) not in sys.path:
            sys.path.insert(0, str(self.path))

    @cached_property
    def problems(self) -> Any:
        """Posing and the independent checker."""
        return importlib.import_module("problems")

    @cached_property
    def peers(self) -> dict[str, str]:
        """What each peer solves: "lcp" (pyramids) or "cone"."""
        return {name: kind for name, (kind, *_) in importlib.import_module("run_peers").PEERS.items()}

    def generate(self, path: Path, *options: str) -> Path:
        """A corpus written to `path` by the folder's own command."""
        subprocess.run([sys.executable, str(self.path / "scenes.py"), str(path), *options], check=True)
        return path

    def read(self, corpus: Path, families: Iterable[str] = ()) -> list[Any]:
        """The scenes of a corpus, or those of some families."""
        wanted = set(families)
        scenes = importlib.import_module("scenes").read(str(corpus))
        if unknown := wanted - {s.family for s in scenes}:
            sys.exit(f"--families: none called {', '.join(sorted(unknown))} in {corpus}")
        return [s for s in scenes if not wanted or s.family in wanted]

    def family(self, directory: Path, family: str, fingers: int, count: int) -> list[Any]:
        """So many scenes of a family, made anew in the directory."""
        options = ("--count", str(count), "--family", family, "--fingers", str(fingers))
        return self.read(self.generate(directory / f"{family}{fingers}.npz", *options))

    def residual(self, scene: Any, forces: np.ndarray, twist: np.ndarray, faces: Faces) -> float:
        """The checker's worst relative residual of forces (n, 3) [N] and twist (6,) about the origin."""
        found = self.problems.check(scene, np.ravel(forces), twist, None if faces == "cone" else faces)
        return float(max(found.values()))

    def residual_of(self, scene: Any, solution: hl.GraspSolution, faces: Faces) -> float:
        """The same of our own answer."""
        return self.residual(scene, solution.forces, solution.object_displacement, faces)


def family_options(about: str | None) -> argparse.ArgumentParser:
    """The command line of a measure over families of scenes made anew."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--families", nargs="*", default=["ring", "sphere"])
    parser.add_argument("--fingers", nargs="*", type=int, default=[3, 5])
    parser.add_argument("--count", type=int, default=60, help="scenes of a family")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path, help="write everything measured to this file")
    return parser


def as_case(scene: Any, faces: Faces) -> Case:
    """A scene of the corpus as a case of the hard-case suite, which knows how to make a grasp of it."""
    s = scene
    return Case(s.name, s.p, s.R, s.mu, s.E, s.d.reshape(-1, 3), s.w, faces)


def read_oracle(path: Path) -> dict[tuple[str, Faces], str]:
    """(scene, faces) → "solvable", "none" or "unknown", from the file that the folder's problems.py writes."""
    data = json.loads(path.read_text())
    return {(name, data["facets"]): verdict for name, verdict in data["verdicts"].items()}
