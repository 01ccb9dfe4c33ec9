"""From a specification to its certified solution."""

from handlcp.grasp.solve.solve_spec import solve_spec

__all__ = ["solve_spec"]
