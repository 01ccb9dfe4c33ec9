"""A grasp's arrays in the coordinates of its friction laws, in which every law is a ball (`friction`).

    r = S r̂,    R̂ = R S,  Ê = S E S,  d̂ = S d,  v̂ = S v

Balance, compatibility and power look the same in r̂ and v̂ as they do in r and v, so that solvers, certifier and search
know one friction law. Where S = 1, in nearly all scenes, nothing is done.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.contact import Contact
from handlcp.grasp.friction import AnisotropicCoulomb, SoftFinger
from handlcp.grasp.scene import Scene
from handlcp.grasp.solution import GraspSolution

__all__ = ["Law", "in_axes", "law_of", "padded", "soft_contacts"]


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """mu (n,), soft and scale as in `Scene`."""

    mu: Array
    soft: tuple[int, ...]
    scale: Array | None

    def applied(self, scene: Scene, spin: Array | None) -> Scene:
        """The scene in the law's coordinates, from contact axes; spin (k,) [rad] as in `Grasp`, None: zero."""
        if self.scale is None:
            return replace(scene, mu=self.mu)
        n, scale = scene.n, self.scale
        rows = scale[: 3 * n].reshape(-1, 3)
        return replace(
            scene,
            mu=self.mu,
            frames=read_only(scene.frames * rows[:, None, :]),
            flexibility=read_only(scene.flexibility * scale[:, None] * scale),
            offset=read_only(scene.offset * rows),
            soft=self.soft,
            scale=scale,
            spin=None if spin is None else read_only(spin * scale[3 * n :]),
        )


def law_of(contacts: tuple[Contact, ...], frames: Array, governed: tuple[bool, ...], planar: bool) -> Law:
    """The law of these contacts; frames (n, 3, 3) in contact axes. A plane's law is an interval: nothing to scale."""
    mu = np.array([c.mu for c in contacts])
    if planar:
        for i, c in enumerate(contacts):
            if isinstance(c.friction, AnisotropicCoulomb):
                x, y, _ = c.rotation.T @ frames[i, :, 0]
                mu[i] = c.friction.toward(float(x), float(y))
        return Law(read_only(mu), (), None)
    soft = soft_contacts(contacts, governed, planar)
    scale = np.ones((len(contacts), 3))
    for i, c in enumerate(contacts):
        scale[i, :2] = c.friction.scale
    levers = [contacts[i].friction.lever for i in soft]
    if not soft and (scale == 1.0).all():
        return Law(read_only(mu), (), None)
    return Law(read_only(mu), soft, read_only(np.append(scale.ravel(), levers)))


def soft_contacts(contacts: tuple[Contact, ...], governed: tuple[bool, ...], planar: bool) -> tuple[int, ...]:
    """Contacts whose moment about the normal is unknown."""
    if planar:
        return ()
    return tuple(i for i, c in enumerate(contacts) if governed[i] and c.friction.lever > 0.0)


def padded(flexibility: Array, contacts: tuple[Contact, ...], soft: tuple[int, ...]) -> Array:
    """(c, c) contact axes, from that of the points (3n, 3n), with the torsional flexibility of the pads."""
    if not soft:
        return flexibility
    n, c = len(contacts), 3 * len(contacts) + len(soft)
    out = np.zeros((c, c))
    out[: len(flexibility), : len(flexibility)] = flexibility
    for at, i in enumerate(soft, 3 * n):
        law = contacts[i].friction
        assert isinstance(law, SoftFinger)
        out[at, at] = law.torsional_flexibility
    return out


def in_axes(solution: GraspSolution) -> GraspSolution:
    """A solution in the laws' coordinates, in contact axes: r = S r̂, v = S⁻¹ v̂."""
    scene = solution.scene
    assert scene is not None
    assert scene.scale is not None
    n, soft, rows = scene.n, list(scene.soft), scene.scale[: 3 * scene.n].reshape(-1, 3)
    torsion, spin = solution.torsion, solution.spin
    if soft:
        assert torsion is not None
        assert spin is not None
        levers = np.ones(n)
        levers[soft] = scene.levers
        torsion, spin = read_only(torsion * levers), read_only(spin / levers)
    forces, slip = read_only(solution.forces * rows), read_only(solution.slip / rows[:, :2])
    return replace(solution, forces=forces, slip=slip, torsion=torsion, spin=spin)
