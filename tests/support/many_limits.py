"""Load limits in many directions: no public name asks for it yet."""

from handlcp.contact.friction import as_section
from handlcp.grasp.limits.load_limit import limits_of


def many_limits(grasp, wrenches, geometry="followed"):
    """Of loads (m, 6), on the exact cone."""
    return limits_of(grasp.spec, as_section("cone", planar=False), wrenches, geometry)
