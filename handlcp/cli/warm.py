"""`handlcp warm`: compile everything now."""

from __future__ import annotations

import time

import typer
from rich.console import Console
from rich.text import Text

from handlcp.cli.app import Json, app, print_json, progress_bar
from handlcp.errors import InputError


@app.command()
def warm(json: Json = False) -> None:
    """Compile everything now, for a container or a test machine: a minute or two, once.

    Without it, commands start interpreted and compile when that pays. Exit status 0, 1 if compiled code could not be
    kept, 2 where HANDLCP_KERNELS forbids to compile.
    """
    from handlcp.lcp.compiler import folders, messages, when

    if when.mode() == "interpreted":
        raise InputError("HANDLCP_KERNELS", '"auto" or "compiled": nothing is compiled otherwise', '"interpreted"')
    begun = time.perf_counter()
    messages.silent()
    with progress_bar() as progress, when.at_once():
        progress(0, 1, "importing")
        from handlcp.show.picture.raster import touch
        from handlcp.study.everything import JOBS

        jobs = (*JOBS, ("pictures", touch))
        for k, (name, job) in enumerate(jobs):
            progress(k, len(jobs), name)
            job()
    seconds, (kernels, where) = time.perf_counter() - begun, folders.kept()
    if json:
        print_json({"kernels": kernels, "folder": None if where is None else str(where), "seconds": seconds})
    elif where is not None:
        Console(soft_wrap=True).print(Text(f"{kernels} kernels are compiled, kept in {where}: {seconds:.1f} s"))
    if where is None:
        raise typer.Exit(1)
