"""Routes of an MJCF file's spatial tendons, for tests."""

from __future__ import annotations

import mujoco

from handlcp.hand.elasticity.route import BoundRoute as BoundRoute, Route
from handlcp.hand.robot.source.mjcf_routes import routes as routes


def mjcf_routes(text: str) -> dict[str, Route]:
    """All of them."""
    read, refused = routes(mujoco.MjModel.from_xml_string(text))
    assert not refused
    return read
