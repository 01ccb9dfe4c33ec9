"""What docstrings and comments of handlcp name is there: in backticks, and as arguments or fields that they list."""

import ast
import builtins
import functools
import gc
import keyword
import pathlib
import re
import sys
from collections import defaultdict
from typing import NamedTuple

PACKAGE = pathlib.Path(__file__).parents[2] / "handlcp"
TICKED = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
NAME = re.compile(r"(~?[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\(.*\))?")
FILE = re.compile(r"[\w./]+\.(?:py|pyi|md|toml|json|csv)")
LISTED = re.compile(r"(?:^ *|[.;] )(\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: \([^()]*\))? : ", re.M)
SHAPE = r"\([^()]*,[^()]*\)"
SHAPED = re.compile(rf"(?:\A|[.;:] |[.;:]\n)\s*((?:\w+ {SHAPE},\s+)*\w+ {SHAPE}) ?: ")
SYMBOL = re.compile(r"[A-Z\u0391-\u03c9]\w?")  # one capital or Greek letter, with an index
# Strings and comments
NO_CODE = re.compile(r'"""(?:\\.|[^\\])*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|#[^\n]*', re.S)
IN_SELF = re.compile(r"\b(?:self\.|__setattr__\(self, .)(\w+)")
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)

LEFT = ("grasp/path/", "grasp/limits/", "hand/find/")  # rewritten as a whole by other work
OTHERS = {
    *dir(builtins),
    *keyword.kwlist,
    *sys.stdlib_module_names,
    *("numpy", "trimesh", "hl"),
    *("grasp_qpos", "obj_pose", "cspace_position", "pregrasp_cspace_position"),  # keys of planners' files
    *("tendon_", "wrap_", "body_invweight0"),  # MuJoCo
    "client",  # of dask
}


class Documented(NamedTuple):
    """A docstring or comment: where it stands, its text, and what it documents (None: a comment)."""

    line: int
    text: str
    node: ast.AST | None


class Source(NamedTuple):
    """A file of the package: its path and text, its classes and functions, its docstrings and comments, and the names
    that the module binds.
    """

    path: pathlib.Path
    text: str
    definitions: list[ast.AST]
    documented: list[Documented]
    top: set[str]


def statements(body):
    """All statements of a body and of those within it; no expressions, which are most of a tree."""
    for node in body:
        yield node
        for field in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from statements(getattr(node, field, ()))


def stored(nodes):
    """Names that statements bind: definitions, assignments, imports; also under `if` and `try`."""
    found = set()
    for node in nodes:
        if isinstance(node, DEFINITIONS):
            found.add(node.name)
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            found |= stored(ast.iter_child_nodes(node))
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {(alias.asname or alias.name).split(".")[0] for alias in node.names}
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}
    return found


def read_source(path):
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    definitions = [node for node in statements(tree.body) if isinstance(node, DEFINITIONS)]
    documented = [
        Documented(node.body[0].lineno, ast.get_docstring(node, clean=False), node)
        for node in (tree, *definitions)
        if ast.get_docstring(node, clean=False)
    ]
    for match in NO_CODE.finditer(text) if re.search("#.*`", text) else ():
        if match[0].startswith("#") and "`" in match[0]:
            documented.append(Documented(text.count("\n", 0, match.start()) + 1, match[0], None))
    return Source(path, text, definitions, documented, stored(tree.body))


@functools.cache
def names_in_code(text):
    """Identifiers of a file's code, and its strings that are a word."""
    return {*re.findall(r"[^\W\d]\w*", NO_CODE.sub(" ", text)), *re.findall(r'"([^\W\d]\w*)"', text)}


@functools.cache
def sources():
    gc.disable()  # a pass over all trees for every few thousand nodes takes longer than parsing
    try:
        return [read_source(path) for path in sorted(PACKAGE.rglob("*.py"))]
    finally:
        gc.enable()


def read_here():
    return [source for source in sources() if not str(source.path.relative_to(PACKAGE)).startswith(LEFT)]


def own_members(node, lines):
    """Fields, properties and methods of a class, and what its methods store in `self`."""
    text = "\n".join(lines[node.lineno - 1 : node.end_lineno])
    return stored(node.body).union(IN_SELF.findall(text))


@functools.cache
def classes():
    """Members and bases of every class, by name; classes of one name together."""
    members, bases = defaultdict(set), defaultdict(set)
    for source in sources():
        lines = source.text.splitlines()
        for node in source.definitions:
            if isinstance(node, ast.ClassDef):
                members[node.name] |= own_members(node, lines)
                bases[node.name].update(*(re.findall(r"\w+", ast.unparse(base)) for base in node.bases))
    return members, bases


@functools.cache
def members_of(name):
    members, bases = classes()
    found = set(members[name])
    for base in bases[name] - {name}:
        found |= members_of(base) if base in members else set()
    return found


@functools.cache
def files():
    root = PACKAGE.parent
    return [path.relative_to(root).as_posix() for path in root.rglob("*.*") if ".git" not in path.parts]


@functools.cache
def shared_names():
    """Names that any file may mention: of modules and folders, of what modules define, of members of classes."""
    found = set(OTHERS)
    for source in sources():
        found |= {code for code in re.findall(r'"(\w+)"', source.text) if "_" in code}
        found |= source.top | set(source.path.relative_to(PACKAGE.parent).with_suffix("").parts)
    return found.union(*classes()[0].values())


@functools.cache
def modules():
    found = defaultdict(set)
    for source in sources():
        name = source.path.parent.name if source.path.stem == "__init__" else source.path.stem
        found[name] |= source.top
    return found


def is_known(name, source):
    return name in shared_names() or name in names_in_code(source.text)


def is_there(name, source):
    if FILE.fullmatch(name):
        return any(file == name or file.endswith("/" + name.lstrip("./")) for file in files())
    first, *rest = name.lstrip("~").split(".")
    if not is_known(first, source):
        return False
    if first in OTHERS:
        return True
    for part in rest:
        if first in classes()[0]:
            there = part in members_of(first)
        elif first in modules():
            there = is_known(part, source)
        else:
            there = is_known(part, source)
        if not there:
            return False
        first = part
    return True


def missing_names(source):
    for documented in source.documented:
        for ticked in TICKED.findall(documented.text):
            name = ticked if FILE.fullmatch(ticked) else (NAME.fullmatch(ticked) or [None, None])[1]
            if name is not None and not is_there(name, source):
                yield f"{source.path.relative_to(PACKAGE.parent)}:{documented.line}: `{ticked}`"


def arguments(node):
    return {part.arg for inner in ast.walk(node) if isinstance(inner, ast.arguments) for part in every_argument(inner)}


def every_argument(of):
    return [*of.posonlyargs, *of.args, *of.kwonlyargs, *filter(None, (of.vararg, of.kwarg))]


def allowed(node, source, names):
    """Members of a class and arguments of what makes or calls it; arguments of a function, and keys that it writes."""
    if isinstance(node, ast.ClassDef):
        made = [part for part in node.body if getattr(part, "name", "") in ("__init__", "__new__", "__call__")]
        return members_of(node.name).union(*map(arguments, made))
    text = "\n".join(source.text.splitlines()[node.lineno - 1 : node.end_lineno])
    own = {part.arg for part in every_argument(node.args)} | set(re.findall(r'"(\w+)"', text))
    return own if names <= own else own | arguments(node)


def missing_listed(source):
    for documented in source.documented:
        if documented.node is None or isinstance(documented.node, ast.Module):
            continue
        listed = [name.strip("* ") for names in LISTED.findall(documented.text) for name in names.split(",")]
        listed += [name for names in SHAPED.findall(documented.text) for name in re.findall(r"(\w+) \(", names)]
        there = allowed(documented.node, source, set(listed)) if listed else set()
        for name in listed:
            if name not in there and not SYMBOL.fullmatch(name):
                where = f"{source.path.relative_to(PACKAGE.parent)}:{documented.line}"
                yield f"{where}: {documented.node.name} lists {name}"


def test_every_name_in_backticks_is_there():
    assert [name for source in read_here() for name in missing_names(source)] == []


def test_every_listed_argument_or_field_is_one():
    assert [name for source in read_here() for name in missing_listed(source)] == []
