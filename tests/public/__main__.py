"""What differs from `surface.json`; with `write`, the file anew. Exit status 1 where something differs."""

from __future__ import annotations

import os
import sys

os.environ.setdefault("HANDLCP_KERNELS", "compiled")

from tests.public.surface import FILE, differences, kept, surface, written


def main() -> int:
    """Compare, and write where that is asked for."""
    if sys.argv[1:] not in ([], ["write"]):
        print("usage: python -m tests.public [write]", file=sys.stderr)
        return 2
    now = surface()
    found = differences(kept() if FILE.exists() else {}, now)
    if sys.argv[1:]:
        FILE.write_text(written(now), encoding="utf-8")
    print("\n".join(found) or "nothing differs")
    return int(bool(found) and not sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
