"""`python -m handlcp.method.catalogue`: the page of effects, measured here and now, on stdout."""

from __future__ import annotations

import sys

from handlcp.method.catalogue import costs, here_and_now, page

if __name__ == "__main__":
    sys.stdout.write(page(costs(), here_and_now()))
