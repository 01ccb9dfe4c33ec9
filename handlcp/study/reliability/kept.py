"""A file that keeps what is done, so that an interrupted run goes on where it was."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.errors import InputError, brief, writing
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.mechanism import HandMechanism
from handlcp.study.reliability.outcome import Outcomes
from handlcp.study.reliability.spread import Dimension
from handlcp.version import VERSION

_FIELDS = ("codes", "margin", "again", "unplaced")


def question_of(spec: GraspSpec, dimensions: Sequence[Dimension], **more: Any) -> dict[str, Any]:
    """What a run answers, in words and digests that differ where the answer may."""
    spread = [[d.name, d.parameter, d.at, d.law.marks] for d in dimensions]
    return {"handlcp": VERSION, "grasp": _digest_of(spec), "spread": _digest(json.dumps(spread)), **more}


class Kept:
    """The file of one run; None: nothing is kept.

    Raises InputError for a file of another question, or of no run at all.
    """

    def __init__(self, path: Any, question: dict[str, Any]) -> None:
        self.path, self.question = None if path is None else Path(path), question

    def read(self) -> Outcomes | None:
        """What was done before; None where there is no such file yet."""
        if self.path is None or not self.path.exists():
            return None
        expected = "a file that an earlier run with resume= wrote, or a new one"
        try:
            with np.load(self.path, allow_pickle=False) as found:
                question = json.loads(str(found["question"]))
                arrays = [found[name] for name in _FIELDS]
        except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
            raise InputError("resume", expected, f"{str(self.path)!r}: {brief(error)}") from None
        names = [name for name in (*self.question, *question) if self.question.get(name) != question.get(name)]
        if others := list(dict.fromkeys(names)):
            raise InputError("resume", "a file of the same question", f"{str(self.path)!r} of another {others[0]}")
        return Outcomes(*arrays)

    def write(self, done: Outcomes) -> None:
        """All that is done, at once: whoever reads the file sees the old one or the new one. Raises InputError."""
        if self.path is None:
            return
        new = self.path.with_name(self.path.name + ".new")
        with writing("resume", self.path):
            with new.open("wb") as out:
                arrays: dict[str, Any] = {name: getattr(done, name) for name in _FIELDS}
                np.savez(out, question=np.array(json.dumps(self.question)), **arrays)
                out.flush()
                os.fsync(out.fileno())
            new.replace(self.path)


def _digest_of(spec: GraspSpec) -> str:
    """Of everything in a grasp that its answer hangs on."""
    arrays = [spec.positions, spec.frames, spec.wrench, spec.reference, spec.flexibility, spec.offset]
    said = [repr([c.friction for c in spec.contacts]), repr(spec.plane), repr(spec.fingers), repr(spec.names)]
    for e in spec.effects:
        said.append(type(e).__name__)
        for name, value in sorted(vars(e).items()):
            arrays += [value] if isinstance(value, np.ndarray) else []
            said.append(f"{name}={value!r}" if not isinstance(value, np.ndarray) else name)
    mechanism = spec.mechanism
    if mechanism is not None:
        arrays += [mechanism.jacobian, mechanism.root, mechanism.limits]
    if isinstance(mechanism, HandMechanism):
        arrays += [mechanism.posture.q, mechanism.posture.hand.pads.blocks, mechanism.gravity, mechanism.stand_off]
        said.append(repr(mechanism.target))
    return _digest("\n".join(said), *arrays)


def _digest(text: str, *arrays: Any) -> str:
    made = hashlib.sha256(text.encode())
    for a in arrays:
        made.update(np.ascontiguousarray(a, dtype=float).tobytes())
    return made.hexdigest()[:16]
