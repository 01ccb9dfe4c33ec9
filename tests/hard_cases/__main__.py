"""Counts of every family at every number of faces: solved or refused with proof / undecided / wrong."""

import sys

from tests.hard_cases.scenes import FACES, examine
from tests.hard_cases.test_families import FAMILIES


def main(count):
    """Print the table, and below it the name of every case that is undecided or wrong."""
    print(f"{'family':36s}" + "".join(f"{f:>16}" for f in FACES) + "    (answered / undecided / wrong)")
    trouble = []
    for name, (_, generate) in FAMILIES.items():
        found = [(faces, examine(generate(faces, count))) for faces in FACES]
        cells = [f"{len(r.solved) + len(r.refused)} / {len(r.undecided)} / {len(r.wrong)}" for _, r in found]
        print(f"{name:36s}" + "".join(f"{c:>16s}" for c in cells), flush=True)
        for faces, r in found:
            trouble += [f"{name}, {faces}: wrong {w}" for w in r.wrong]
            trouble += [f"{name}, {faces}: undecided {u}" for u in r.undecided]
    print("\n".join(trouble))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
