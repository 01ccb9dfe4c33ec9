"""`python -m handlcp.study.paper [--json]`."""

from __future__ import annotations

import sys

from handlcp.study.paper.command import paper_command

if __name__ == "__main__":
    sys.exit(paper_command(json="--json" in sys.argv[1:]))
