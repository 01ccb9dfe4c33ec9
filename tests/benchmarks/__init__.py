"""What the solvers cost and how often they answer, beside other people's. Run on demand, never part of the tests."""

import os

os.environ.setdefault("HANDLCP_KERNELS", "compiled")  # before handlcp is imported: compiled code is what is timed
