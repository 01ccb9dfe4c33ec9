"""Routes of spatial tendons as the reader of MJCF files has them, for tests."""

from handlcp.hand.elasticity.route import BoundRoute as BoundRoute
from handlcp.hand.robot.source.mjcf_routes import routes as routes
