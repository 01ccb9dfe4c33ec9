"""Counts of every family at every number of faces: solved or refused with proof / undecided / wrong."""

from __future__ import annotations

import importlib
import pkgutil
import sys

import tests.hard_cases as here
from tests.hard_cases.scenes import FACES, examine


def main(count):
    """Print the table, and below it the name of every case that is undecided or wrong."""
    print(f"{'family':34s}" + "".join(f"{f:>16}" for f in FACES) + "    (answered / undecided / wrong)")
    trouble = []
    for module in sorted(m.name for m in pkgutil.iter_modules(here.__path__) if m.name.startswith("test_")):
        families = getattr(importlib.import_module(f"tests.hard_cases.{module}"), "FAMILIES", {})
        for name, cases in families.items():
            cells = []
            for faces in FACES:
                r = examine(cases(faces, count))
                cells.append(f"{len(r.solved) + len(r.refused)} / {len(r.undecided)} / {len(r.wrong)}")
                trouble += [f"{name}, {faces}: wrong {w}" for w in r.wrong]
                trouble += [f"{name}, {faces}: undecided {u}" for u in r.undecided]
            print(f"{name:34s}" + "".join(f"{c:>16s}" for c in cells), flush=True)
    print("\n".join(trouble))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
