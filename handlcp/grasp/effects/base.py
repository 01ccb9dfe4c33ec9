"""What an effect is: its unknowns, its blocks, and how its own law is checked."""

from __future__ import annotations

from typing import ClassVar, Self

from handlcp.check import Array
from handlcp.grasp.effects.limit import Limit
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene
from handlcp.grasp.system import System, Unknown

__all__ = ["Effect"]

_MOST = 16  # effects whose limits a scene keeps: a grasp has few, and who tries many others on it piles up nothing


class Effect:
    """One physical effect. Subclasses declare unknowns and stamp blocks, or `limits`, from which both follow; most need
    nothing else.

    title : what `explain()` calls it. equation : its law in one line. The others are its entry in the catalogue
    (`handlcp.grasp.entry`): when, who wants it; in_python, in_file, how to ask for it; brings, its unknowns; source.
    """

    title: ClassVar[str]
    equation: ClassVar[str]
    when: ClassVar[str]
    in_python: ClassVar[str]
    in_file: ClassVar[str]
    brings: ClassVar[str]
    source: ClassVar[str]

    @property
    def key(self) -> object:
        """A grasp has one effect of each key: of its kind, unless a kind says otherwise."""
        return type(self)

    @property
    def opens(self) -> bool:
        """Whether it moves contacts by unknowns of its own, so that contact modes do not describe the scene."""
        return type(self).limits is not Effect.limits or type(self).opening is not Effect.opening

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """This effect, completed for a grasp of n contacts by a hand with these joints (None: no hand), beside others.

        argument : what to call it in an InputError, which says what does not fit.
        """
        return self

    def for_fingers(self, argument: str, fingers: int, n: int) -> Self:
        """This effect, completed for a grasp whose first `fingers` of n contacts are the hand's and whose others are
        the environment's, before `for_grasp`; not asked where all are the hand's.
        """
        return self

    def why(self, scene: Scene) -> str:
        """Why the scene has this effect, for `explain()`."""
        raise NotImplementedError

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """Limits on the forces that give way: where an effect is made of them alone, nothing below needs saying.

        Asked once a scene; everyone else reads `present`.
        """
        return ()

    def present(self, scene: Scene) -> tuple[Limit, ...]:
        """The limits, without groups of none."""
        if type(self).limits is Effect.limits:
            return ()
        known: tuple[Limit, ...]
        for effect, known in scene.made:
            if effect is self:
                return known
        known = tuple([limit for limit in self.limits(scene) if len(limit.room)])
        if len(scene.made) >= _MOST:
            scene.made.clear()
        scene.made.append((self, known))
        return known

    def unknowns(self, scene: Scene) -> tuple[Unknown, ...]:
        """The groups this effect brings."""
        return tuple([limit.unknown for limit in self.present(scene)])

    def stamp(self, scene: Scene, system: System) -> None:
        """Add this effect's blocks."""
        for limit in self.present(scene):
            limit.stamp(scene, system)

    def opening(self, scene: Scene, extra: dict[str, Array]) -> Array | None:
        """(c,) motion between object and fingertips that this effect adds to Gᵀu + E r + d [m], over the scene's
        components.

        `extra` holds the unknowns that effects brought beyond forces and object motion, by group name, SI; a group of
        none is left out. None: nothing.
        """
        total = None
        for limit in self.present(scene):
            part = limit.opening(extra)
            total = part if total is None else total + part
        return total

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """How far a candidate misses this effect's own law, relative; forces (c,) N, the scene's components.

        The laws of balance, contact and friction are recomputed by the certifier itself.
        """
        worst = 0.0
        for limit in self.present(scene):
            part = limit.residual(scene, forces, extra, force_size, motion_size)
            worst = part if not part <= worst else worst  # NaN stays
        return worst
