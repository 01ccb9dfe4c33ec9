"""Where the contacts of a grasp are, and what moves them."""

from __future__ import annotations

from dataclasses import dataclass

from handlcp.check import Array
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Placement:
    """contacts (n,): of the fingers, then of the environment. positions (n, 3) [m]. frames (n, 3, 3): contact axes in
    columns, world axes. plane (3,): unit normal of a planar scene; None: spatial. fingers: how many contacts, the first
    ones, are the fingers'; None: all. mechanism: what moves the fingers, if anything is known.
    """

    contacts: tuple[Contact, ...]
    positions: Array
    frames: Array
    plane: Array | None
    fingers: int | None
    mechanism: Mechanism | None

    @property
    def n(self) -> int:
        """Contacts."""
        return len(self.contacts)

    @property
    def of_fingers(self) -> int:
        """How many contacts are the fingers'."""
        return self.n if self.fingers is None else self.fingers

    @property
    def planar(self) -> bool:
        """Whether the scene lies in a plane."""
        return self.plane is not None
