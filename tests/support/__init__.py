"""The only door to what is inside the package.

Tests use the package as everyone does: `handlcp` itself, its errors, scene files, command line, and the names that the
packages `lcp`, `grasp`, `hand`, `show` and `study.…` export. What a test needs of the inside it asks for here, a module
for each room, in terms of public objects where that can be done: then the house may move, and only these files with it.
`tests/test_doors.py` sees to it.
"""
