"""How sure it is that a grasp holds, when what it is made of varies."""

from handlcp.studies.reliability.chance import Chance, Influence
from handlcp.studies.reliability.estimate import Reliability, Sample, reliability

__all__ = ["Chance", "Influence", "Reliability", "Sample", "reliability"]
