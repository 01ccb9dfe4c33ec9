"""What a solve, a path, a question, a search, a batch and a first start cost: `python -m tests.benchmarks.solve`.

Every script compares within one run, in turns, and prints ratios beside times: only ratios carry over to another
machine. They use public names alone. `pytest -m bench tests/benchmarks` runs all of them with small sizes.
"""

import os
import sys

if "pytest" not in sys.modules:  # before numpy and handlcp are imported: compiled code is what is timed, on one thread
    os.environ.setdefault("HANDLCP_KERNELS", "compiled")
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
