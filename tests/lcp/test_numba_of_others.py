"""numba is left as it is for everybody else in the process: kernels change nothing that other functions use."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parents[2]

COMPILE_A_FOREIGN_FUNCTION_BEFORE_AND_AFTER = """
import json, sys, types
import numba, numpy as np
from numba.core.registry import cpu_target


def foreign():
    # A function that calls another one, large enough that a kernel of its size would stay apart, and assigns a slice
    @numba.njit
    def solve(a, b):
        x = b.copy()
        for i in range(len(b)):
            for j in range(i):
                x[i] -= a[i, j] * x[j]
            x[i] /= a[i, i]
        return np.sort(x)

    @numba.njit
    def assign(a, b, out):
        out[:] = solve(a, b)

    assign(np.eye(3), np.arange(3.0), np.zeros(3))
    try:
        assign(np.eye(3), np.arange(3.0), np.zeros(4))
    except ValueError as error:
        message = str(error)
    (found,) = assign.overloads.values()
    (called,) = solve.overloads.values()
    return {
        "classes": [type(found.library).__name__, type(called.library).__name__, type(assign).__name__],
        "takes_in": called.library in found.library._linking_libraries,
        "instructions": found.library.get_llvm_str().count("\\n"),
        "message": message,
        "own": sorted({"own", "needs"} & set(vars(found.library))),
        "dispatcher": sorted(vars(assign)),
    }


def attributes():
    # What every module and class of numba and the code generator hold, by identity
    owners = {n: m for n, m in list(sys.modules.items()) if n.split(".")[0] in ("numba", "llvmlite")}
    owners |= {f"{n}.{c}": v for n, m in list(owners.items()) for c, v in vars(m).items() if isinstance(v, type)}
    kinds = types.FunctionType, type, classmethod, staticmethod, property
    found = {f"{n}.{a}": v for n, o in owners.items() for a, v in vars(o).items() if isinstance(v, kinds)}
    codegen = cpu_target.target_context.codegen()
    return found | {f"codegen.{a}": v for a, v in vars(codegen).items()}


before = foreign()
held = attributes()

from tests.support.kernels import compiled, large
from handlcp.lcp.compiler.compile_policy import compile_now

with compile_now():
    large()(np.eye(3) + 1.0, np.arange(3.0), np.zeros(3), np.zeros(3, dtype=np.int64), 1e-12)
now = attributes()
print(json.dumps({
    "compiled": compiled(),
    "before": before,
    "after": foreign(),
    "changed": sorted(name for name, value in held.items() if now.get(name) is not value),
}))
"""


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """What a process says of a function of its own that numba compiled before kernels were used, and after."""
    code, env = COMPILE_A_FOREIGN_FUNCTION_BEFORE_AND_AFTER, dict(os.environ, HANDLCP_KERNELS="auto")
    env["HANDLCP_CACHE_DIR"] = str(tmp_path_factory.mktemp("cache"))
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_foreign_function_is_compiled_after_kernels_as_before(foreign):
    assert foreign["compiled"] > 0
    assert foreign["after"] == foreign["before"]
    assert foreign["after"]["own"] == []


def test_no_function_or_class_of_numba_is_replaced(foreign):
    assert foreign["changed"] == []
