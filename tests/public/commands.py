"""The commands of `handlcp`, with what each of them takes, and the keys of the files that they read."""

from __future__ import annotations

import json
import types
import typing
from typing import Any

import typer
from typer.testing import CliRunner

from handlcp.cli import app

__all__ = ["commands", "file_keys"]


def commands() -> dict[str, dict[str, str]]:
    """{command: {its arguments in capitals, its options by their names: what they take}}; "handlcp" is the program."""
    program: Any = typer.main.get_command(app)
    return {"handlcp": takes(program)} | {name: takes(command) for name, command in sorted(program.commands.items())}


def file_keys() -> dict[str, dict[str, str]]:
    """{"scene" or "brief": {key: "needed" or its default, and "several" where its table may come several times}}."""
    found = {}
    for file, options in (("scene", []), ("brief", ["--brief"])):
        keys = json.loads(CliRunner().invoke(app, ["keys", "--json", *options]).stdout)["keys"]
        found[file] = {f"{key['table']}.{key['key']}".lstrip("."): words_of(key) for key in keys}
    return found


def words_of(key: dict[str, Any]) -> str:
    """Such as "needed" or "default 0.6"."""
    words = ["needed"] if key["required"] else [f"default {key['default'] or 'none'}"]
    return ", ".join(words + ["several"] * bool(key["many"]))


def takes(command: Any) -> dict[str, str]:
    """{argument or option: what it takes} of one command."""
    function = command.callback
    kinds = typing.get_type_hints(getattr(function, "__wrapped__", function))
    return {name_of(p): said(p, kinds[p.name]) for p in command.params if p.name in kinds}


def name_of(parameter: Any) -> str:
    """Such as "SCENE", "--faces" or "--followed/--fixed"."""
    if parameter.param_type_name == "argument":
        return str(parameter.name).upper()
    return "/".join([*parameter.opts, *parameter.secondary_opts])


def said(parameter: Any, kind: Any) -> str:
    """Such as "Path, required" or "float, default 0.1"."""
    words = ["flag"] if getattr(parameter, "is_flag", False) else [kind_name(kind)]
    words += ["required"] * parameter.required
    default = parameter.default
    if words != ["flag"] and isinstance(default, (int, float, str)) and not parameter.required:
        words.append(f"default {default}")
    return ", ".join(words)


def kind_name(kind: Any) -> str:
    """The type without None, such as "Path" or "list[str]"."""
    if typing.get_origin(kind) in (types.UnionType, typing.Union):
        return " | ".join(kind_name(k) for k in typing.get_args(kind) if k is not type(None))
    return str(kind) if typing.get_args(kind) else kind.__name__
