"""How large a hand is."""

from __future__ import annotations

import numpy as np

from handlcp.errors import HandLCPError
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.link_surface import surface_points
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description


def size_of(described: Description, kinematics: Kinematics) -> tuple[float, float, float]:
    """Extents along x, y, z in the neutral posture [m]: of the collision geometry, else of what is drawn, else of the
    links' frames.
    """
    every = range(1, len(described.model.frames))
    places, _ = kinematics.frames_at(kinematics.neutral, every)
    points = [places[:, :3, 3]]
    for kind in (COLLISION, VISUAL):
        try:
            parts = described.parts(kind)
        except HandLCPError:  # its meshes are missing
            continue
        for part in parts:
            surface = surface_points([(part.shape, part.rotation, part.position)], corners=True)
            if surface is not None and part.frame:
                place = places[part.frame - 1]
                points.append(surface @ place[:3, :3].T + place[:3, 3])
        if len(points) > 1:
            points = points[1:]
            break
    x, y, z = np.ptp(np.concatenate(points), axis=0).tolist()
    return (x, y, z)
