"""What an optimisation is made of, for tests."""

from handlcp.design.evaluation import parse_requirement
from handlcp.design.optimise.aims import margin, read_aims
from handlcp.design.optimise.best import slopes_of
from handlcp.design.optimise.slopes import Gradient, places, slope
from handlcp.design.space import Space

__all__ = ["Gradient", "Space", "margin", "parse_requirement", "places", "read_aims", "slope", "slopes_of"]
