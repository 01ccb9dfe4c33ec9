"""What the package says about compiling."""


def without_compiling(said):
    """What a program said on stderr, without lines about compiling: whoever comes first to a kernel waits for it."""
    return "".join(line for line in said.splitlines(keepends=True) if not line.startswith("handlcp: compiling"))
