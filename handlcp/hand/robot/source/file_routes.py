"""The routes of an MJCF file's tendons, for whoever says the rest of them."""

from __future__ import annotations

from typing import Any

from handlcp.errors import Unsupported
from handlcp.hand.elasticity.route import Route
from handlcp.hand.robot.source.description import content
from handlcp.hand.robot.source.mjcf import compiled
from handlcp.hand.robot.source.mjcf_routes import routes
from handlcp.keywords import helped


@helped()
def tendon_routes(source: Any) -> dict[str, Route]:
    """The spatial tendons of an MJCF file as routes, by name, for `Tendons`; those that are sums of joint angles are
    left out.

    source : as of `Hand.from_mjcf`. Raises Unsupported for a tendon that runs through the inside of a body, naming it,
    and without MuJoCo; URDFError as `Hand.from_mjcf`.
    """
    text, path = content("source", source)
    read, refused = routes(compiled(text.decode() if path is None else "", path))
    if refused:
        raise Unsupported("; ".join([f"tendon {name!r}: {why}" for name, why in refused.items()]))
    return read
