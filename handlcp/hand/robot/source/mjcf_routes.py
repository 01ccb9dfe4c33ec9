"""The spatial tendons of an MJCF model as routes: sites, side sites, cylinders, spheres and pulleys.

Points are in the frames of bodies, and the link of a body, named as in `handlcp.hand.robot.source.mjcf`, has the same
frame.
Source: MuJoCo's XML reference, tendon/spatial, and the fields of mjModel named `tendon_` and `wrap_`.
"""

from __future__ import annotations

from typing import Any

import pinocchio as pin

from handlcp.errors import InputError, Unsupported
from handlcp.hand.elasticity.places import CYLINDER, SPHERE, Around, Pulley, Site
from handlcp.hand.elasticity.route import Route
from handlcp.hand.robot.source.part import rotation_of

_JOINT, _PULLEY, _SITE, _SPHERE, _CYLINDER = 1, 2, 3, 4, 5  # mjtWrap: what a tendon passes


def routes(model: Any) -> tuple[dict[str, Route], dict[str, str]]:
    """Tendon name → route of each spatial tendon of a compiled mujoco.MjModel; and tendon name → why one is not read.

    Tendons that are sums of joint angles are left out: they have no path.
    """
    read, refused = dict[str, Route](), dict[str, str]()
    for t in range(model.ntendon):
        first, name = int(model.tendon_adr[t]), model.tendon(t).name or f"tendon {t}"
        places = range(first, first + int(model.tendon_num[t]))
        if any(model.wrap_type[w] == _JOINT for w in places):
            continue
        try:
            read[name] = Route([_place(model, w) for w in places])
        except (InputError, Unsupported) as error:
            refused[name] = str(error)
    return read, refused


def _place(model: Any, w: int) -> Site | Around | Pulley:
    """One of the places. Raises InputError, Unsupported."""
    kind, item = int(model.wrap_type[w]), int(model.wrap_objid[w])
    if kind == _PULLEY:
        return Pulley(float(model.wrap_prm[w]))
    if kind == _SITE:
        return Site(_link(model, model.site_bodyid[item]), model.site_pos[item])
    if kind not in (_SPHERE, _CYLINDER):
        raise Unsupported(f"a place of MuJoCo's type {kind}: sites, spheres, cylinders and pulleys are read")
    body = int(model.geom_bodyid[item])
    at = pin.SE3(rotation_of(model.geom_quat[item]), model.geom_pos[item])
    shape = SPHERE if kind == _SPHERE else CYLINDER
    side = _side(model, int(model.wrap_prm[w]), body)
    try:
        return Around(_link(model, body), at, float(model.geom_size[item, 0]), shape, side)
    except Unsupported:
        raise Unsupported(
            f"{_called(model.geom(item), 'geom')}: its side site is inside, and the tendon with it"
        ) from None


def _side(model: Any, site: int, body: int) -> Any:
    """(3,) a side site in the frame of the body that is wrapped [m]; None without one. Raises Unsupported."""
    if site < 0:
        return None
    if int(model.site_bodyid[site]) != body:
        name, link = _called(model.site(site), "site"), _link(model, body)
        raise Unsupported(f"{name} is the side site of a geom on {link!r}, and on another body")
    return model.site_pos[site]


def _link(model: Any, body: int) -> str:
    """The link of a body, by the name that our reader gives it."""
    return str(model.body(int(body)).name or f"body_{int(body)}")


def _called(item: Any, kind: str) -> str:
    return f"{kind} {item.name!r}" if item.name else f"{kind} {item.id}"
