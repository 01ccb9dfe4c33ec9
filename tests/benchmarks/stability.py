"""How often each scene of the peers' corpus gets a certified answer, a certified "no", or none; with the peers beside.

Each scene and number of faces becomes one `Record`. An answer of ours is judged by the peers' checker and not by our
certifier: solved (worst relative residual ≤ 1e-8), loose (≤ 1e-5), wrong. A "no" is wrong where the oracle or a peer
has an answer, and counts as uncertified where its proof does not pass: the escaping motion is tested by signs alone
(`tests.support.escapes`), a proof that no equilibrium exists must state its bounds.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

import handlcp as hl
from tests.benchmarks.corpus import Faces, PeersFolder, as_case
from tests.benchmarks.peers import answers
from tests.support.escapes import escapes

__all__ = ["Record", "examine", "measure"]

TIGHT, LOOSE = 1e-8, 1e-5
OUTCOME = {
    hl.Status.NO_EQUILIBRIUM: "no equilibrium",
    hl.Status.NOT_HOLDABLE: "not holdable",
    hl.Status.UNDECIDED: "undecided",
}


@dataclass
class Record:
    """One scene with one number of faces.

    outcome : solved | loose | wrong | no equilibrium | not holdable | undecided. residual : the checker's, of an
    answer. proven : whether a "no" has its proof. seconds : of the one call of `solve`. stages : of the chain that
    ran. last : what the last of them said. peers : their verdicts. oracle : "solvable", "none", "unknown" or None.
    """

    family: str
    name: str
    faces: Faces
    outcome: str
    residual: float | None
    proven: bool
    seconds: float
    stages: int
    last: str
    peers: dict[str, str] = field(default_factory=dict)
    oracle: str | None = None

    @property
    def solvable(self) -> bool:
        """Whether somebody else has an answer."""
        return self.oracle == "solvable" or "solved" in self.peers.values()

    @property
    def refuted(self) -> bool:
        """A "no" where somebody else has an answer."""
        return self.outcome in ("no equilibrium", "not holdable") and self.solvable

    @property
    def wrong(self) -> bool:
        """A wrong answer or a wrong "no"."""
        return self.outcome == "wrong" or self.refuted

    @property
    def missed(self) -> bool:
        """Undecided where somebody else has an answer."""
        return self.outcome == "undecided" and self.solvable

    @property
    def unproven(self) -> bool:
        """A "no" without proof."""
        return self.outcome in ("no equilibrium", "not holdable") and not self.proven

    def __str__(self) -> str:
        who = [p for p, verdict in self.peers.items() if verdict == "solved"]
        who += ["the oracle"] if self.oracle == "solvable" else []
        said = f"{self.name}, {self.faces}: {self.outcome}"
        said += f" (residual {self.residual:.1e})" if self.residual is not None else ""
        return f"{said}; solved by {', '.join(who) or 'nobody else'}; {self.last}"

    def asdict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def examine(folder: PeersFolder, scene: Any, faces: Faces) -> Record:
    """Solve one scene and judge what comes out."""
    case = as_case(scene, faces)
    grasp = case.grasp()
    start = time.perf_counter()
    solution = grasp.solve(faces, throw=False)
    seconds = time.perf_counter() - start
    residual, proven = None, False
    if solution.held:
        residual = folder.residual_of(scene, solution, faces)
        outcome = "solved" if residual <= TIGHT else "loose" if residual <= LOOSE else "wrong"
    else:
        outcome = OUTCOME[solution.status]
        if outcome == "not holdable":
            proven = solution.certificate is not None and escapes(case, solution.certificate)
        elif outcome == "no equilibrium":
            proven = solution.bounds is not None
    last = solution.trace[-1] if solution.trace else ""
    return Record(scene.family, scene.name, faces, outcome, residual, proven, seconds, len(solution.trace), last)


def measure(
    console: Console,
    folder: PeersFolder,
    corpus: Path,
    faces: Sequence[Faces],
    families: Sequence[str],
    peers: Iterable[str],
    oracle: dict[tuple[str, Faces], str],
    known: Iterable[dict[str, Any]] = (),
) -> list[Record]:
    """Every scene at every number of faces. known : records of an earlier run, whose peers' verdicts are taken over."""
    told: dict[tuple[str, Faces], dict[str, str]] = {(r["name"], r["faces"]): r["peers"] for r in known}
    scenes = folder.read(corpus, families)

    def missing(peer: str) -> bool:
        suited = [f for f in faces if (f == "cone") == (folder.peers[peer] == "cone")]
        return any(peer not in told.get((s.name, f), {}) for s in scenes for f in suited)

    todo = [p for p in peers if missing(p)]
    for peer, found in answers(console, folder, corpus, todo, faces, families).items():
        for key, answer in found.items():
            told.setdefault(key, {})[peer] = answer.verdict
    records = []
    for f in faces:
        for scene in scenes:
            with console.status(f"{scene.name}, {f}"):
                record = examine(folder, scene, f)
            record.peers, record.oracle = told.get((scene.name, f), {}), oracle.get((scene.name, f))
            records.append(record)
    return records
