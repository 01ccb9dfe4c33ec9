"""A second opinion on a hand's grasp with any effects: every law in SI, from what was asked for and what came out.

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
from scipy.spatial import ConvexHull, HalfspaceIntersection

import handlcp as hl
from tests.hand.differences import kinematics
from tests.support.grasp import arrays


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


def support(law, faces, planar):
    """(face normals (3, f), their distance, corners (3, p)) per newton, in the law's axes; no corners: a ball."""
    if law.mu == 0.0:
        return np.zeros((3, 0)), 0.0, np.zeros((3, 1))
    if planar:
        return np.array([[1.0, -1.0], [0, 0], [0, 0]]), law.mu, np.array([[law.mu, -law.mu], [0, 0], [0, 0]])
    if faces == "cone":
        return np.zeros((3, 0)), law.mu, None
    a = 2 * np.pi * np.arange(faces) / faces
    if law.lever == 0.0:
        N = np.vstack([np.cos(a), np.sin(a), 0 * a])
        b = a + np.pi / faces
        return N, law.mu * np.cos(np.pi / faces), law.mu * np.vstack([np.cos(b), np.sin(b), 0 * b])
    k = max(1, round(faces / 4))
    N = [[0, 0, 1.0], [0, 0, -1.0]]
    for phi in 0.5 * np.pi * np.arange(-k + 1, k) / k:
        N += [[np.cos(phi) * np.cos(t), np.cos(phi) * np.sin(t), np.sin(phi)] for t in a]
    N = np.array(N)
    V = HalfspaceIntersection(np.column_stack([N, -np.ones(len(N))]), np.zeros(3)).intersections
    V = V[ConvexHull(V).vertices].T
    reach = np.linalg.norm(V, axis=0).max()
    return N.T, law.mu / reach, V * law.mu / reach


def laws(asked, s, faces):
    """By how much each law is missed, relative, by name."""
    g, planar = asked.grasp, arrays(asked.grasp).plane is not None
    n, k = len(g.contacts), len(g.fingertips)
    p = np.array([c.position for c in g.contacts])
    R = g.frames
    normal = R[:, :, 2]
    f, moment = s.forces, np.zeros(n) if s.torsion is None else s.torsion
    spin = np.zeros(n) if s.spin is None else s.spin
    world = np.einsum("nab,nb->na", R, f)
    arms = p - g.reference
    size = np.sqrt(((p - p.mean(0)) ** 2).sum(1).mean())
    F = max(abs(f).max(), np.linalg.norm(asked.wrench[:3]))
    out = {}

    # ---- balance
    lost = world.sum(0) + asked.wrench[:3]
    turned = np.cross(arms, world).sum(0) + (moment[:, None] * normal).sum(0) + asked.wrench[3:]
    out["balance"] = np.hypot(np.linalg.norm(lost), np.linalg.norm(turned) / size) / F

    # ---- joints
    kin = kinematics(g)
    q, C = kin.q, asked.compliance
    J = np.zeros((n, 3, len(q)))
    J[:k] = np.einsum("nba,nbj->naj", R[:k], kin.jacobian)
    T = np.zeros((n, len(q)))
    if moment.any() or s.spin is not None:
        T[:k] = np.einsum("nb,nbj->nj", normal[:k], kin.turning)
    push = np.einsum("naj,na->j", J, f) + moment @ T
    weight = kin.weight(asked.gravity) if asked.weight else np.zeros(len(q))
    torque = push + weight
    out["torques"] = abs(s.torques - torque).max() / (F * size)
    gives, pulled = C, torque
    if asked.bends:
        K_g = kin.bending(world[:k])
        gives = np.linalg.solve(np.eye(len(q)) + C @ K_g, C)
        pulled = torque + K_g @ asked.command
    given_way = gives @ pulled
    V = max(abs(J.reshape(-1, len(q)) @ given_way).max(), abs(asked.offset).max(), abs(asked.pad * f).max())
    lever = max(np.sqrt((J**2).sum((0, 1))).max(), 1e-9)
    out["deflection"] = abs(s.joint_deflection - given_way).max() * lever / V
    yielded = s.joint_yield
    limits = g.state.hand.torque_limits
    if asked.saturates:
        loaded = np.array([i not in asked.prescribed for i in range(n)])
        reached = (abs(J[loaded]).max((0, 1)) > 1e-9) & np.isfinite(
            limits
        )  # the others' torques nothing here can change
        over = max((abs(torque) - limits)[reached].max(initial=0.0), 0.0)
        idle = abs(yielded * (limits - np.copysign(1.0, yielded) * torque))[reached].max(initial=0.0)
        out["saturation"] = max(over / (F * size), idle / (F * V), -min((yielded * torque).min(), 0.0) / (F * V))
    else:
        out["saturation"] = float(yielded.any())

    # ---- motions, term by term
    wrench_on_palm = np.zeros(6)
    for i in range(k):
        about = np.cross(p[i] - asked.at, world[i]) + moment[i] * normal[i]
        wrench_on_palm += np.r_[world[i], about]
    palm = asked.wrist @ wrench_on_palm
    if planar:
        W = [np.r_[R[i, :, a], np.cross(p[i] - asked.at, R[i, :, a])] for i in range(k) for a in (0, 2)]
        palm_moves = np.zeros((n, 3))
        palm_moves[:k, [0, 2]] = (np.array(W) @ palm).reshape(k, 2)
    else:
        palm_moves = np.zeros((n, 3))
        for i in range(k):
            palm_moves[i] = R[i].T @ (palm[:3] + np.cross(palm[3:], p[i] - asked.at))
    u = s.object_displacement
    object_moves = np.einsum("nba,nb->na", R, u[:3] + np.cross(u[3:], arms))
    surface = np.broadcast_to(asked.surface, (n, 3)) * f
    pad = np.where(np.arange(n) < k, asked.pad, asked.environment)[:, None] * f
    opened = np.zeros((n, 3))
    free = np.array([i not in asked.prescribed for i in range(n)])
    fingers = np.arange(n) < k
    if np.isfinite(asked.total):
        z = float(s.extra.get("z̄", [0.0])[0])
        room = asked.total - f[free & fingers, 2].sum()
        out["total"] = max(-z / V, -room / F, abs(min(z / V, room / F)))
        opened[fingers & free, 2] += z
    if np.isfinite(asked.each):
        z = s.extra.get("z̄_i", np.zeros((free & fingers).sum()))
        room = asked.each - f[free & fingers, 2]
        out["each"] = max(abs(np.minimum(z / V, room / F)).max(), 0.0)
        opened[free & fingers, 2] += z
    served = np.zeros((n, 3))
    for i, r in asked.known.items():
        served[i, 2] = sum(sign * float(s.extra.get(f"κ{i}{way}", [0.0])[0]) for sign, way in ((1, "⁺"), (-1, "⁻")))
        out["known"] = max(out.get("known", 0.0), abs(f[i, 2] - r) / F)
    elastic = np.einsum("naj,j->na", J, gives @ push) + pad + surface + palm_moves
    held = gives @ (pulled - push) - asked.command  # of the fingers' weight, and what was commanded
    given = asked.offset + np.einsum("naj,j->na", J, held)
    limit = np.einsum("naj,j->na", J, yielded) + opened
    moved = object_moves + elastic + given + limit + served
    if planar:
        moved[:, 1] = 0.0
    said = np.column_stack([s.slip, s.gap])
    out["motion"] = abs(said - moved)[free].max() / V
    out["prescribed"] = max((abs(f[i] - r).max() / F for i, r in asked.prescribed.items()), default=0.0)
    flex = np.array([getattr(c.friction, "torsional_flexibility", 0.0) for c in g.contacts])
    soft = np.array([c.friction.lever > 0 and free[i] and not planar for i, c in enumerate(g.contacts)])
    on_palm = np.where(fingers, normal @ palm[3:], 0.0)
    twist_elastic = T @ (gives @ push) + flex * moment + on_palm
    twist_given, twist_limit = T @ held, T @ yielded
    twisted = normal @ u[3:] + twist_elastic + twist_given + twist_limit
    out["spin"] = abs(np.where(soft, spin - twisted, 0.0)).max() * size / V
    out["hard"] = float(moment[~soft].any())

    # ---- contact and friction
    worst = 0.0
    for i in np.flatnonzero(free):
        law = g.contacts[i].friction
        r, gap = f[i, 2], s.gap[i]
        worst = max(worst, -r / F, -gap / V, abs(min(r / F, gap / V)))
        scale = np.array([*law.scale, law.lever if soft[i] else 1.0])
        if planar and isinstance(law, hl.AnisotropicCoulomb):
            x, y, _ = g.contacts[i].rotation.T @ R[i, :, 0]
            law, scale = hl.Coulomb(1 / np.hypot(x / law.mu_x, y / law.mu_y)), np.ones(3)
        y = np.array([f[i, 0], f[i, 1], moment[i]]) / scale
        w = np.array([s.slip[i, 0], s.slip[i, 1], spin[i]]) * scale
        N, distance, corners = support(law, faces, planar)
        outside = np.linalg.norm(y) - law.mu * r if corners is None else (N.T @ y - distance * r).max(initial=0.0)
        most = law.mu * np.linalg.norm(w) if corners is None else (-w @ corners).max()
        if law.mu == 0.0:
            outside, most = np.linalg.norm(y), 0.0
            w = np.zeros(3)
        out["friction"] = max(out.get("friction", 0.0), outside / F, abs(most * max(r, 0.0) + w @ y) / (F * V))
    out["contact"] = worst

    # ---- energies
    load = asked.wrench @ u
    preload = -(f * given).sum() - moment[soft] @ twist_given[soft]
    springs = push @ gives @ push + (f * (pad + surface)).sum() + wrench_on_palm @ palm + (flex * moment**2)[soft].sum()
    v = np.where(free[:, None], said, moved)
    friction = -(f[free] * said[free]).sum() - moment[soft] @ spin[soft]
    follows = -(f * v)[~free].sum()
    serves = (f * served).sum()
    yields = (f * limit).sum() + moment @ twist_limit
    E = max(abs(x) for x in (load, preload, springs, F * V))
    out["energy"] = abs(load + preload - springs - friction - follows - yields - serves) / E
    out["dissipation"] = max(-friction / E, -yields / E, -springs / E, 0.0)
    return {name: float(value) for name, value in out.items()}
