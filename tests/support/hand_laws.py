"""The laws of a hand's grasp with any effects, in SI, from what was asked for and what came out; on top of `laws`.

It knows none of the package's matrices. Jacobians are differences of the hand's tip placements (fourth order, good to
rounding), gravity torques differences of Pinocchio's potential energy, compliances numbers that the scene was made of.

Energies. Each motion is v = Gᵀu + E r + d + Aᵀs (object, springs, gaps and preloads and commands, what yields at
limits); multiplied by r, with G r = -w,

    w·u - r·d = rᵀE r + (-r·v) + r·Aᵀs

The load's work on the object, and that of preloads, commanded joints and the fingers' weight, is twice the springs'
energy ½ rᵀE r (which loads that grow in proportion store) plus what sliding and yielding dissipate, both ≥ 0. Where a
force is prescribed, its actuator follows the object and does the work -r·v, of either sign; where a part of it is
known, its finger moves by κ until that is so, and the work is r·κ.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import handlcp as hl
from tests.support.differences import kinematics
from tests.support.friction_sets import limit
from tests.support.laws import balance, contact, reported, spread


@dataclass
class Asked:
    """What a scene was made of. compliance (nv, nv) of the joints; wrist (6, 6) about `at`; surface, pad and
    environment [m/N] along all axes, or (3,); command (nv,); limits (nv,).
    """

    grasp: Any
    wrench: np.ndarray  # about the reference, the object's weight included
    compliance: np.ndarray
    pad: float
    command: np.ndarray
    planar: bool = False
    weight: bool = False
    gravity: np.ndarray = field(default_factory=lambda: np.array([0, 0, -9.81]))
    surface: np.ndarray = field(default_factory=lambda: np.zeros(3))
    wrist: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    at: np.ndarray = field(default_factory=lambda: np.zeros(3))
    environment: float = 0.0
    total: float = np.inf
    each: float = np.inf
    saturates: bool = False
    bends: bool = False
    prescribed: dict[int, np.ndarray] = field(default_factory=dict)
    known: dict[int, float] = field(default_factory=dict)  # normal forces that are known
    offset: np.ndarray | None = None  # (n, 3) gaps, preloads and offsets asked for


def laws(asked, s, faces):
    """By how much each law is missed, relative, by name."""
    hand = _Hand(asked, s, faces)
    out = {"balance": balance(hand.arms, hand.world, asked.wrench, hand.size, hand.F, hand.couples)}
    out |= hand.joints() | hand.limits() | hand.motions() | hand.contacts() | hand.energies()
    return {name: float(value) for name, value in out.items()}


class _Hand:
    """Everything that a law is made of, recomputed once; n contacts, the first k of them the fingers'."""

    def __init__(self, asked, s, faces):
        g = asked.grasp
        self.asked, self.s, self.faces, self.touches = asked, s, 2 if asked.planar else faces, g.contacts
        self.n, self.k = len(g.contacts), len(g.fingertips)
        n, k = self.n, self.k
        self.p, self.R = np.array([c.position for c in g.contacts]), g.frames
        self.normal, self.f = self.R[:, :, 2], s.forces
        self.moment = np.zeros(n) if s.torsion is None else s.torsion
        self.spin = np.zeros(n) if s.spin is None else s.spin
        self.world, self.arms = np.einsum("nab,nb->na", self.R, self.f), self.p - g.reference
        self.couples = self.moment[:, None] * self.normal
        self.size, self.F = spread(self.p), max(abs(self.f).max(), np.linalg.norm(asked.wrench[:3]))
        self.fingers = np.arange(n) < k
        self.free = np.array([i not in asked.prescribed for i in range(n)])
        self.said = np.column_stack([s.slip, s.gap])
        lever = [c.friction.lever > 0 and not asked.planar for c in g.contacts]
        self.soft = np.array(lever) & self.free
        self.flex = np.array([getattr(c.friction, "torsional_flexibility", 0.0) for c in g.contacts])
        self._bend(kinematics(g))

    def _bend(self, kin):
        """What the joints feel and by how much they give way."""
        asked, n, k, nv = self.asked, self.n, self.k, len(kin.q)
        self.J, self.T = np.zeros((n, 3, nv)), np.zeros((n, nv))
        self.J[:k] = np.einsum("nba,nbj->naj", self.R[:k], kin.jacobian)
        if self.moment.any() or self.s.spin is not None:
            self.T[:k] = np.einsum("nb,nbj->nj", self.normal[:k], kin.turning)
        self.push = np.einsum("naj,na->j", self.J, self.f) + self.moment @ self.T
        self.torque = self.push + (kin.weight(asked.gravity) if asked.weight else 0.0)
        self.gives, pulled = asked.compliance, self.torque
        if asked.bends:
            K_g = kin.bending(self.world[:k])
            self.gives = np.linalg.solve(np.eye(nv) + asked.compliance @ K_g, asked.compliance)
            pulled = self.torque + K_g @ asked.command
        self.given_way, self.bent = self.gives @ pulled, np.zeros(nv)
        if asked.bends:  # the torques are those of the posture that the joints give way to
            self.bent = K_g @ (asked.command - self.given_way)
        self.held = self.gives @ (pulled - self.push) - asked.command  # of the fingers' weight, and what was commanded
        self.V = max(abs(self.at_tips(self.given_way)).max(), abs(asked.offset).max(), abs(asked.pad * self.f).max())

    def at_tips(self, joints):
        """(n, 3) how the contacts move with the joints."""
        return np.einsum("naj,j->na", self.J, joints)

    # ---------------------------------------------------------------- joints and limits
    def joints(self):
        """Torques by virtual work, and by how much they bend the joints."""
        lever = max(np.sqrt((self.J**2).sum((0, 1))).max(), 1e-9)
        return {
            "torques": abs(self.s.torques - self.torque - self.bent).max() / (self.F * self.size),
            "deflection": abs(self.s.joint_deflection - self.given_way).max() * lever / self.V,
        }

    def limits(self):
        """Joints that yield, forces that are bounded: z of a bound opens the gaps of those that it bounds."""
        asked, s, f, F, V = self.asked, self.s, self.f, self.F, self.V
        bounded, yielded = self.free & self.fingers, s.joint_yield
        out, self.opened = {"saturation": float(yielded.any())}, np.zeros((self.n, 3))
        if asked.saturates:
            limits = asked.grasp.state.hand.torque_limits
            # Of joints that carry prescribed forces alone nothing here can change the torques
            reached = (abs(self.J[self.free]).max((0, 1)) > 1e-9) & np.isfinite(limits)
            over = max((abs(self.torque) - limits)[reached].max(initial=0.0), 0.0)
            idle = abs(yielded * (limits - np.copysign(1.0, yielded) * self.torque))[reached].max(initial=0.0)
            against = -min((yielded * self.torque).min(), 0.0)
            out["saturation"] = max(over / (F * self.size), idle / (F * V), against / (F * V))
        if np.isfinite(asked.total):
            z, room = float(s.extra.get("z̄", [0.0])[0]), asked.total - f[bounded, 2].sum()
            out["total"] = max(-z / V, -room / F, abs(min(z / V, room / F)))
            self.opened[bounded, 2] += z
        if np.isfinite(asked.each):
            z, room = s.extra.get("z̄_i", np.zeros(bounded.sum())), asked.each - f[bounded, 2]
            out["each"] = max(abs(np.minimum(z / V, room / F)).max(), 0.0)
            self.opened[bounded, 2] += z
        self.limit = self.at_tips(yielded) + self.opened
        return out

    # ---------------------------------------------------------------- motions, term by term
    def motions(self):
        """What object, springs, offsets and limits move, beside what the solution says; after `limits`."""
        asked, f, n = self.asked, self.f, self.n
        u = self.s.object_displacement
        object_moves = np.einsum("nba,nb->na", self.R, u[:3] + np.cross(u[3:], self.arms))
        surface = np.broadcast_to(asked.surface, (n, 3)) * f
        pad = np.where(self.fingers, asked.pad, asked.environment)[:, None] * f
        self.layers, self.given = pad + surface, asked.offset + self.at_tips(self.held)
        elastic = self.at_tips(self.gives @ self.push) + self.layers + self._of_the_palm()
        self.served, out = np.zeros((n, 3)), {}
        for i, r in asked.known.items():
            there, back = (float(self.s.extra.get(f"κ{i}{way}", [0.0])[0]) for way in "⁺⁻")
            self.served[i, 2] = there - back
            out["known"] = max(out.get("known", 0.0), abs(f[i, 2] - r) / self.F)
        self.moved = object_moves + elastic + self.given + self.limit + self.served
        if asked.planar:
            self.moved[:, 1] = 0.0
        held = self.free
        out["reported"] = reported(self.said[held], self.moved[held], np.full(held.sum(), self.V))
        out["prescribed"] = max((abs(f[i] - r).max() / self.F for i, r in asked.prescribed.items()), default=0.0)
        return out | self._turning(u[3:])

    def _of_the_palm(self):
        """(n, 3) how the tips move with a palm on a soft wrist, in a plane within it alone."""
        arms, palm_moves = self.p - self.asked.at, np.zeros((self.n, 3))
        turned = np.cross(arms, self.world) + self.couples
        self.on_palm = np.concatenate([self.world, turned], axis=1)[self.fingers].sum(0)
        self.palm = self.asked.wrist @ self.on_palm
        moves = np.einsum("nba,nb->na", self.R, self.palm[:3] + np.cross(self.palm[3:], arms))
        axes = [0, 2] if self.asked.planar else [0, 1, 2]
        palm_moves[np.ix_(self.fingers, axes)] = moves[np.ix_(self.fingers, axes)]
        return palm_moves

    def _turning(self, turn):
        """The same of the object's turn on soft fingertips; hard ones bear no moment."""
        on_palm = np.where(self.fingers, self.normal @ self.palm[3:], 0.0)
        elastic = self.T @ (self.gives @ self.push) + self.flex * self.moment + on_palm
        self.twist_given, self.twist_limit = self.T @ self.held, self.T @ self.s.joint_yield
        twisted = self.normal @ turn + elastic + self.twist_given + self.twist_limit
        spin = abs(np.where(self.soft, self.spin - twisted, 0.0)).max() * self.size / self.V
        return {"spin": spin, "hard": float(self.moment[~self.soft].any())}

    # ---------------------------------------------------------------- contact and friction
    def contacts(self):
        """Of those whose force is not prescribed, in the coordinates of their friction laws."""
        limits, forces, slides = [], [], []
        for i in np.flatnonzero(self.free):
            law = self.touches[i].friction
            scale = np.array([*law.scale, law.lever if self.soft[i] else 1.0])
            if self.asked.planar and isinstance(law, hl.AnisotropicCoulomb):
                x, y, _ = self.touches[i].rotation.T @ self.R[i, :, 0]
                law, scale = hl.Coulomb(1 / np.hypot(x / law.mu_x, y / law.mu_y)), np.ones(3)
            own = slice(0, 3 if self.soft[i] else 2)
            limits.append(limit(law.mu, self.faces, bool(self.soft[i])))
            forces.append((np.append(self.f[i, :2], self.moment[i]) / scale)[own])
            slides.append((np.append(self.s.slip[i], self.spin[i]) * scale)[own])
        V = np.full(len(limits), self.V)
        push, gap = self.f[self.free, 2], self.s.gap[self.free]
        missed = contact(limits, push, gap, forces, slides, self.F, V, V)
        return dict(zip(("normal", "cone", "slip", "work"), missed, strict=True))

    # ---------------------------------------------------------------- energies
    def energies(self):
        """See the top; after `motions`."""
        f, soft, free = self.f, self.soft, self.free
        load = self.asked.wrench @ self.s.object_displacement
        preload = -(f * self.given).sum() - self.moment[soft] @ self.twist_given[soft]
        turned = (self.flex * self.moment**2)[soft].sum()
        springs = self.push @ self.gives @ self.push + (f * self.layers).sum() + self.on_palm @ self.palm + turned
        v = np.where(free[:, None], self.said, self.moved)
        friction = -(f[free] * self.said[free]).sum() - self.moment[soft] @ self.spin[soft]
        follows, serves = -(f * v)[~free].sum(), (f * self.served).sum()
        yields = (f * self.limit).sum() + self.moment @ self.twist_limit
        E = max(abs(x) for x in (load, preload, springs, self.F * self.V))
        return {
            "energy": abs(load + preload - springs - friction - follows - yields - serves) / E,
            "dissipation": max(-friction / E, -yields / E, -springs / E, 0.0),
        }
