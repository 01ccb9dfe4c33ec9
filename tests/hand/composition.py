"""Hands with any mixture of effects, and beside each grasp the plain numbers it was made of, for `hand_laws.laws`."""

from functools import cache

import numpy as np

import handlcp as hl
from tests.support.differences import kinematics
from tests.support.hand_laws import Asked

G = 9.81
BALL = hl.Sphere(0.035, (0, 0, 0.07), mass=0.2)
DISC = hl.Cylinder(0.03, 0.02, mass=0.1)
WRIST = np.diag([2e-5, 3e-5, 4e-5, 0.02, 0.03, 0.04])
WRIST[0, 4] = WRIST[4, 0] = 3e-4
STIFFNESS = {"five": 6.0, "allegro": 4.0, "ring": 3.0, "mimic": 3.0}
PAD = 2e-4
PRESCRIBED = {"five": 1, "allegro": 0, "ring": 0, "mimic": 2}
GRAVITY = {name: np.array([0, 0, -G]) for name in ("allegro", "mimic")}
GRAVITY |= {"five": np.array([0, 0, G]), "ring": np.array([0, -G, 0])}  # five hangs, the ring lies in its plane
LIBRARY = {"five": "five_finger", "allegro": "allegro", "ring": "planar_ring", "mimic": "psyonic"}
HANDS = ("five", "allegro", "ring", "mimic")
EFFECTS = (
    "soft fingers", "anisotropic friction", "a frictionless finger", "environment", "object weight", "finger weight",
    "commanded joints", "tendons", "synergies", "total bound", "finger bounds", "torque saturation",
    "geometric stiffness", "contact compliance", "soft wrist", "prescribed force",
    "known force",
)  # fmt: skip


@cache
def bare(name, **more):
    return hl.example_hand(LIBRARY[name], pad_flexibility=PAD, **({"joint_stiffness": STIFFNESS[name]} | more))


@cache
def posture(name):
    hand = bare(name)
    if name == "five":
        return hand.close_on(BALL)
    if name == "ring":
        return hand.close_on(DISC, np.tile([0.5, -0.9], 6), squeeze=2e-3)
    if name == "allegro":
        bend = {"joint_12.0": 1.2, "joint_13.0": 0.5, "joint_14.0": 0.4, "joint_15.0": 0.6}
        fingers = {j: 0.7 for j in hand.joint_names if int(j[6:-2]) % 4 and j not in bend}
        q = dict.fromkeys(hand.joint_names, 0.0) | fingers | bend
        return np.array([q[j] for j in hand.joint_names])
    return hand.neutral + 0.5 * np.minimum(hand.upper - hand.neutral, 1.0)


def axes(name, state):
    """(n, 3) normals towards the middle of the tips."""
    p = state.tip_positions
    z = p.mean(0) - p
    return z / np.linalg.norm(z, axis=1)[:, None]


def transmission(name, effects):
    """(joint_stiffness, compliance (nv, nv)) of a hand with tendons, synergies, or springs at its joints."""
    nv, k = bare(name).nv, STIFFNESS[name]
    rng = np.random.default_rng(nv)
    if "tendons" in effects:
        R, t = rng.uniform(-0.01, 0.02, (3, nv)), np.array([3e3, 5e3, 8e3])
        return hl.Tendons(R, t, k), np.linalg.inv(k * np.eye(nv) + R.T @ (t[:, None] * R))
    if "synergies" in effects:
        S, z = rng.uniform(-0.5, 1.0, (nv, 2)), np.array([20.0, 30.0])
        return hl.Synergies(S, z, k), np.eye(nv) / k + (S / z) @ S.T
    return k, np.eye(nv) / k


def made(name, effects=(), faces=8):
    """`Asked` of the hand `name` with effects by name."""
    effects = frozenset(effects)
    springs, C = transmission(name, effects)
    limits = {}
    if "torque saturation" in effects:
        limits = {"torque_limits": 0.85 * abs(plain(name).torques).max()}
    hand = hl.example_hand(LIBRARY[name], pad_flexibility=PAD, joint_stiffness=springs, **limits)
    state = hand.at(posture(name))
    n = len(hand.fingertips)
    laws = [hl.Coulomb(0.8 if name == "allegro" else 0.6)] * n
    ellipses = [hl.AnisotropicCoulomb(0.6, 0.8, along=(0.3, 0.2, 0.9)), hl.AnisotropicCoulomb(0.8, 0.5)]
    if "a frictionless finger" in effects:  # the others have to hold more
        laws = [hl.Frictionless(), *[hl.Coulomb(0.9)] * (n - 1)]
        ellipses = [hl.AnisotropicCoulomb(0.8, 0.9, along=(0.3, 0.2, 0.9)), hl.AnisotropicCoulomb(0.9, 0.7)]
    if "anisotropic friction" in effects:
        laws[1:3] = ellipses
    if "soft fingers" in effects:
        patch = hl.SoftFinger(laws[-1].mu, 0.006, 2.0)
        mixed = {"anisotropic friction", "a frictionless finger"} & effects
        laws = [*laws[:-1], patch] if mixed else [patch] * n
    asked = Asked(None, np.zeros(6), C, PAD, np.zeros(hand.nv), planar=name == "ring")
    named, more = [], {}
    if "total bound" in effects:
        asked.total = 0.9 * plain(name).normal_force.sum()
        named.append(hl.TotalForceBound(asked.total))
    if "finger bounds" in effects:
        asked.each = 0.9 * plain(name).normal_force.max()
        named.append(hl.FingerForceBound(asked.each))
    if "torque saturation" in effects:
        asked.saturates = True
        named.append(hl.TorqueSaturation())
    if "geometric stiffness" in effects:
        asked.bends = True
        named.append(hl.GeometricStiffness())
    if "contact compliance" in effects:
        asked.surface = np.array([1e-4, 2e-4, 1.5e-4])
        named.append(hl.ContactCompliance(asked.surface))
    if "soft wrist" in effects:
        asked.wrist, asked.at = WRIST, np.array([0.01, 0.02, -0.03])
        named.append(hl.SoftWrist(WRIST, asked.at))
    if "prescribed force" in effects:
        i = PRESCRIBED[name]
        force = 1.05 * plain(name).forces[i]
        asked.prescribed = {i: force}
        named.append(hl.PrescribedForce(i, force))
    if "known force" in effects:
        i = (PRESCRIBED[name] + 1) % n
        asked.known = {i: 0.85 * float(plain(name).normal_force[i])}
        named.append(hl.KnownForce(i, (None, None, asked.known[i])))
    if "finger weight" in effects:
        asked.weight, more["finger_weight"] = True, True
    if "commanded joints" in effects:
        asked.command = np.random.default_rng(3).uniform(-0.01, 0.02, hand.nv)
        more["joint_offset"] = asked.command
    heavy = "object weight" in effects
    load = {
        "five": np.array([0.3, 0.2, 0.5, 0.01, 0.005, 0.01]), "allegro": np.array([0.2, 0.1, -0.3, 0.002, 0.0, 0.004]),
        "ring": np.array([0.3, 0.1, 0, 0, 0, 0.002]), "mimic": np.array([0.1, 0.1, -0.2, 0.0, 0.002, 0.002]),
    }[name]  # fmt: skip
    asked.gravity = GRAVITY[name]
    asked.wrench = load.copy()
    tangential = np.random.default_rng(4).uniform(-3e-4, 3e-4, (n, 3)) * (1, 1, 0)
    if name == "ring":
        tangential[:, 1] = 0.0
    if name in ("five", "ring"):
        target = BALL if name == "five" else DISC
        if not heavy:
            target = hl.Sphere(0.035, (0, 0, 0.07)) if name == "five" else hl.Cylinder(0.03, 0.02)
        asked.wrench[:3] += target.mass * asked.gravity
        more |= {"friction": dict(zip(hand.fingertips, laws, strict=True))}
        if name == "ring":
            more["plane"] = (0, 0, 1)
    else:
        p, z = state.tip_positions, axes(name, state)
        target = [hl.Contact(a, b, law) for a, b, law in zip(p, z, laws, strict=True)]
        more["reference"] = p.mean(0)
        if heavy:
            asked.wrench[:3] += 0.05 * asked.gravity
            load = asked.wrench
    squeeze = {"five": 0.004, "allegro": 0.006, "ring": 0.002, "mimic": 0.004}[name]
    around = np.zeros((0, 3))
    if "environment" in effects:
        asked.environment = 5e-4
        if name == "five":
            more["environment"] = hl.Table((0, 0, 0.1015), (0, 0, -1), hl.Coulomb(0.3), 5e-4)
            around = np.array([[0, 0, -3.5e-3]])
        elif name == "ring":
            wall = hl.Contact((0.0, -0.03, 0.0), (0, 1, 0), hl.Coulomb(0.3))
            more["environment"] = hl.Environment([wall], 5e-4, -3e-4)
            around = np.array([[0, 0, -3e-4]])
        else:
            c, laws_there = more["reference"], [hl.Coulomb(0.3), hl.AnisotropicCoulomb(0.4, 0.2), hl.Coulomb(0.3)]
            if "soft fingers" in effects:
                laws_there[0] = hl.SoftFinger(0.4, 0.01, 1.0)
            places = c + np.array([[0.01, 0, -0.03], [-0.01, 0.01, -0.03], [0, -0.015, -0.03]])
            feet = [hl.Contact(a, (0, 0, 1), law) for a, law in zip(places, laws_there, strict=True)]
            gap = np.array([0.0, -2e-4, 1e-4])
            more["environment"] = hl.Environment(feet, 5e-4, gap)
            around = np.column_stack([np.zeros((3, 2)), gap])
    g = state.grasp(
        target, wrench=load, gravity=asked.gravity, preload=squeeze, offset=tangential, effects=named, **more
    )
    asked.grasp, asked.given = g, {"offset": tangential, "preload": squeeze}
    tips = tangential - [0, 0, squeeze]
    if name in ("five", "ring"):
        tips = tips + plain_gaps(name)
    asked.offset = np.concatenate([tips, around])
    return asked


@cache
def plain_gaps(name):
    """(n, 3) gaps as detected, from the grasp of this object alone. A finger that overlaps it was moved there by the
    smallest motion of its joints that goes so deep, and its tip went sideways with them.
    """
    target = BALL if name == "five" else DISC
    more = {"plane": (0, 0, 1), "gravity": (0, -G, 0)} if name == "ring" else {}
    g = bare(name).at(posture(name)).grasp(target, **more)
    out = np.outer(g.offset[:, 2], (0.0, 0.0, 1.0))
    for i, J in enumerate(np.einsum("nba,nbj->naj", g.frames, kinematics(g).jacobian)):
        if out[i, 2] < -1e-6:
            out[i, :2] += (J[:2] @ J[2]) * out[i, 2] / (J[2] @ J[2])
    return out * ((1, 0, 1) if name == "ring" else 1)


@cache
def plain(name):
    """The answer without any of the effects."""
    return made(name).grasp.solve()
