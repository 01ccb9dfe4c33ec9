"""Load limits in many directions at once, which no public name asks for yet."""

from handlcp.grasp.limits.directions import limits_of as limits_of
