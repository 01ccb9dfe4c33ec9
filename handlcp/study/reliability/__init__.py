"""How sure it is that a grasp holds, when what it is made of varies."""

from handlcp.study.reliability.interval import Chance, Influence
from handlcp.study.reliability.result import Reliability, Sample
from handlcp.study.reliability.study import reliability

__all__ = ["Chance", "Influence", "Reliability", "Sample", "reliability"]
