"""`python -m handlcp.cli`."""

from handlcp.cli import main

__all__: list[str] = []

main()
