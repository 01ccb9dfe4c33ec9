"""Numbers that look as if they were in other units than metres and kilograms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.errors import URDFError

_WIDEST, _HEAVIEST = 20.0, 2000.0  # [m, kg] no robot that carries a hand is larger


def check_units(argument: str, model: Any) -> None:
    """Raises URDFError for a robot that is wider than 20 m or heavier than 2 t, and says how to go on."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    places = np.array([place.translation for place in data.oMf])
    width = float(np.ptp(places, axis=0).max()) if np.isfinite(places).all() else 0.0
    if width > _WIDEST:
        expected = (
            "lengths in metres (are they in millimetres? then multiply each xyz, size, radius and length by 0.001)"
        )
        raise URDFError(argument, expected, f"a robot {width:.3g} m wide")
    mass = sum(float(inertia.mass) for inertia in model.inertias)
    if mass > _HEAVIEST:
        expected = "masses in kilograms (are they in grams? then multiply each mass and inertia by 0.001)"
        raise URDFError(argument, expected, f"a robot of {mass:.3g} kg")
