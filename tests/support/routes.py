"""Routes of spatial tendons as the reader of MJCF files has them, for tests."""

from handlcp.actuation.route import BoundRoute as BoundRoute
from handlcp.robot.mjcf_cable import read_routes as read_routes
