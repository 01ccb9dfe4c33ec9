"""`python -m handlcp`."""

from handlcp.cli import main

__all__: list[str] = []

main()
