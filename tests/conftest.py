"""Thousands of small solves: the suite runs compiled kernels from their first call on. Set before handlcp is imported.

They wait for the compiler, once: what a test runs then does not depend on how far another process has come, and none
is left behind. HANDLCP_KERNELS=interpreted runs it without a compiler, for those with time.
"""

import gc
import os

os.environ.setdefault("HANDLCP_KERNELS", "compiled")


def pytest_configure(config):
    """Whether somebody has compiled before must not show in what tests read on stderr."""
    from handlcp.lcp.compiler.compile_policy import silence

    silence()


def pytest_collection_finish(session):
    """Thousands of tests and their modules stay until the end: the garbage collector need not look through them again
    and again.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
