"""What NSNGRK is measured against: the paper's settings and units, its method as printed, rows drawn alike."""

from handlcp.method.nsngrk.as_printed import RES, SEEDS, STEPS, AsPrinted, UniformRows, UnitsOf, in_units

__all__ = ["RES", "SEEDS", "STEPS", "AsPrinted", "UniformRows", "UnitsOf", "in_units"]
