"""Imports run one way: cli → viz → design → studies → scene → simulator → hand → grasp → contact → kinematics → lcp →
record, words, lazy_property, check, progress, read_file, write_file, errors, tolerances, version.

Every import counts, wherever it stands: on top of a file, inside a function, or for type checkers alone. But methods of
answers and grasps, such as `plot`, import from viz and studies what they show when they are called.
"""

import ast
import pathlib
import re
from functools import cache

import pytest

import handlcp

ROOT = pathlib.Path(handlcp.__file__).parent
ORDER = [
    "version",
    "tolerances",
    "errors",
    "write_file",
    "read_file",
    "progress",
    "check",
    "lazy_property",
    "words",
    "record",
    "lcp",
    "kinematics",
    "contact",
    "grasp",
    "actuation",
    "robot",
    "geometry",
    "hand",
    "simulator",
    "scene",
    "studies",
    "design",
    "viz",
    "cli",
]
# Of grasp, as the table of handlcp/README.md has them
GRASP = [
    "model", "effects", "failure", "assembly", "verify", "derivatives", "solution", "solve", "analysis", "path",
    "verdict", "limits", "margins", "design", "grasp", "batch",
]  # fmt: skip
FILES = sorted(p for p in ROOT.rglob("*.py") if p.parent != ROOT or p.stem in ORDER)


def dotted(file):
    parts = ("handlcp", *file.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(p): p for p in ROOT.rglob("*.py")}
SHOWN = ("viz", "studies")  # rooms whose functions methods of the rooms below may call


def methods(tree):
    """The functions that stand in classes."""
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    return [node for kind in classes for node in kind.body if isinstance(node, ast.FunctionDef)]


def shows(file, node):
    """Whether an import in a method of this file is of a room above that shows or studies."""
    asked = (getattr(node, "module", None) or "").split(".")
    if asked[0] != "handlcp" or asked[1:2] == [] or asked[1] not in SHOWN:
        return False
    room = dotted(file).partition(".")[2].partition(".")[0]
    return ORDER.index(room) < ORDER.index(asked[1])


@cache
def imports(file):
    """(module, name) of everything that a file imports from the package, but for what its methods show; `from package
    import module` is an import of the module, and has no name.
    """
    tree, found = ast.parse(file.read_text(encoding="utf-8")), []
    shown = {node for method in methods(tree) for node in ast.walk(method) if shows(file, node)}
    for node in ast.walk(tree):
        if node in shown:
            continue
        if isinstance(node, ast.Import):
            found += [(a.name, "") for a in node.names if a.name.partition(".")[0] == "handlcp"]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "handlcp":
            for a in node.names:
                whole = f"{node.module}.{a.name}"
                found.append((whole, "") if whole in MODULES else (node.module, a.name))
    return found


def graph():
    """Every module → the modules that it imports."""
    return {name: {m for m, _ in imports(file) if m in MODULES} - {name} for name, file in MODULES.items()}


def circles(edges):
    """Groups of more than one node from each of which every other of the group is reached (Tarjan's components)."""
    index, low, stack, groups = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(edges.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                groups.append(sorted(group))

    for node in sorted(edges):
        if node not in index:
            visit(node)
    return sorted(groups)


@pytest.mark.parametrize(
    ("room", "text", "counts"),
    [
        ("grasp", "from {viz} import draw", True),
        ("grasp", "def plot():\n    from {viz} import draw", True),
        ("grasp", "class A:\n    def plot(self):\n        from {viz} import draw", False),
        ("grasp", "class A:\n    def plot(self):\n        from {hand} import draw", True),
        ("cli", "class A:\n    def plot(self):\n        from {viz} import draw", True),
    ],
)
def test_only_what_methods_show_does_not_count(room, text, counts):
    tree = ast.parse(text.format(viz="handlcp.viz", hand="handlcp.hand"))
    shown = {node for method in methods(tree) for node in ast.walk(method) if shows(ROOT / room / "a.py", node)}
    assert bool(shown) != counts


def short(file):
    return str(file.relative_to(ROOT))


# ---------------------------------------------------------------- which way imports run
def test_a_room_imports_only_rooms_below_it():
    found = []
    for file in FILES:
        below = ORDER[: ORDER.index(dotted(file).split(".")[1]) + 1]
        found += [f"{short(file)}: {n}" for n, _ in imports(file) if n == "handlcp" or n.split(".")[1] not in below]
    assert not found, "\n".join(found)


def test_a_room_of_grasp_imports_only_rooms_below_it():
    rooms = [(name, m) for name, others in graph().items() for m in others
             if name.startswith("handlcp.grasp.") and m.startswith("handlcp.grasp.")]  # fmt: skip
    above = [f"{a}: {b}" for a, b in rooms if GRASP.index(b.split(".")[2]) > GRASP.index(a.split(".")[2])]
    assert not above, "\n".join(above)


def test_the_page_lists_the_rooms_of_grasp_in_the_same_order():
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `grasp/(\w+)`", page, re.M) == [room for room in GRASP if (ROOT / "grasp" / room).is_dir()]


def test_only_pictures_import_matplotlib():
    others = [p for p in FILES if p.relative_to(ROOT).parts[0] != "viz"]
    assert not [short(p) for p in others if re.search(r"(import|from) matplotlib", p.read_text(encoding="utf-8"))]


def test_circles_are_found():
    edges = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": {"e"}, "e": set(), "f": {"g"}, "g": {"f", "a"}}
    assert circles(edges) == [["a", "b", "c"], ["f", "g"]]


def test_no_import_goes_in_a_circle():
    found = [", ".join(short(MODULES[name]) for name in group) for group in circles(graph())]
    assert not found, f"{len(found)} circles:\n" + "\n".join(found)


# ---------------------------------------------------------------- rooms
def test_no_two_folders_side_by_side_import_each_other():
    """Of a file in one folder a file in the other, however deep in it."""
    across = set()
    for name, others in graph().items():
        for other in others:
            one, two = (MODULES[n].relative_to(ROOT).parts[:-1] for n in (name, other))
            same = next((k for k, (a, b) in enumerate(zip(one, two, strict=False)) if a != b), None)
            if same is not None:
                across.add((one[: same + 1], two[: same + 1]))
    both = sorted({tuple(sorted((a, b))) for a, b in across if (b, a) in across})
    assert not both, "\n".join(f"{'/'.join(a)} and {'/'.join(b)}" for a, b in both)


def test_no_file_imports_a_name_with_an_underscore():
    found = [f"{short(file)}: {name} of {module}" for file in MODULES.values() for module, name in imports(file)
             if name.startswith("_") or module.rpartition(".")[2].startswith("_")]  # fmt: skip
    assert not found, "\n".join(found)
