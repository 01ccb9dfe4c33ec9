"""What a designer asks of a hand's grasp: one method a question, each a call to the file that answers it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from handlcp.grasp.friction import Pyramid
from handlcp.grasp.grasp import Grasp
from handlcp.keywords import helped_methods
from handlcp.progress import told

if TYPE_CHECKING:
    from handlcp.grasp.analysis.required import Required
    from handlcp.hand.design.motors import RequiredTorque


@helped_methods
class HandQuestions(Grasp):
    """Base of `HandGrasp`: questions about its motors, and about how hard it closes."""

    def required_torque(
        self, loads: Any = None, safety: float = 1.5, faces: int | str | Pyramid = "cone", tolerance: float = 0.01,
        *, most_force: Any = None, progress: bool | Callable[[int], object] | None = None,
    ) -> RequiredTorque:  # fmt: skip
        """The torque of each joint, and the grip of each finger, with which every load of a brief holds.

        loads : what the hand has to hold, one load at a time: (6,) force [N] and torque [N·m] beside the object's
            weight, about the reference; (m, 6) several; or a mapping of names to loads, each a (6,) or a mapping of
            "load" (6,), "mass" [kg] and "gravity" (3,) [m/s²], where what is left out is as the grasp has it. None: the
            grasp's own load.
        safety : every load is multiplied by it, and so is the object's weight; the fingers' own weight is not.
        tolerance : of the grip: to that share the least is found. faces : as in `solve`.
        most_force : the largest normal force [N] that the object bears, on the way to each load times safety, such as
            3 N for an egg: a number for every contact, one for each, or a mapping by name; None: any.
        progress : None: a line on the terminal once it takes long; False: none; True: a line on stderr that stays; a
            function: called with the number of grips tried so far.

        The hand closes by a grip force at each fingertip, in place of the grasp's own command, then the load comes, as
        in `check`. Many grips hold every load. The one is looked for that keeps the torque of the joint that is loaded
        most as small as possible, from the first touch to the whole load: as a share of the joints' limits where all of
        them have one, in N·m otherwise. The search starts from the grip that is best where nothing slips (a linear
        program); every grip that it tries is followed. Before it is given, `check()` judges every load with the answer
        as torque limits (`verdicts`); the answer is confirmed where all of them are HELD.
        Raises InputError, UnknownName, Unsupported (known forces).
        """
        from handlcp.hand.design.required_torque import required_torque

        def by_count(tried: int, _: int) -> None:
            if tried and callable(progress):
                progress(tried)

        with told("grips tried", None, by_count if callable(progress) else progress) as say:
            section = self._section(faces)
            return required_torque(self.spec, section, loads, safety, tolerance, lambda _: say(1), most_force)

    def required_grip(
        self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3, *, most_force: Any = None
    ) -> Required:  # fmt: skip
        """The smallest grip force [N], common to all fingertips and in place of the grasp's own command, with which
        the grasp holds when it closes and is loaded then, to a relative tolerance, and no contact presses harder on the
        way than `most_force`, as of `required_torque`, which finds a grip for each finger. Raises InputError,
        UnknownName, Unsupported.
        """
        from handlcp.hand.design.required_torque import required_grip

        return required_grip(self.spec, self._section(faces), tolerance, most_force)

    def required_squeeze(
        self, faces: int | str | Pyramid = "cone", tolerance: float = 1e-3, *, most_force: Any = None
    ) -> Required:  # fmt: skip
        """The smallest squeeze [m], common to all fingertips and in place of the grasp's own command, with which the
        grasp holds, as `required_grip`. Raises InputError, UnknownName, Unsupported.
        """
        from handlcp.hand.design.required_torque import required_squeeze

        return required_squeeze(self.spec, self._section(faces), tolerance, most_force)
