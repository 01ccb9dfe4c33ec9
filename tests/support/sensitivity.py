"""Grasps that differ in one parameter, and differences of whole solves between them."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

import handlcp as hl
from handlcp.hand import library
from handlcp.hand.grasp_variation import lengthen_link
from handlcp.hand.hand_grasp import make_grasp

HANDS_OF_LIBRARY = tuple([name for name in library.HANDS if name != "planar_ring"])  # the ring lies in a plane


def pair(axis, mu, x=0.0, name="pair"):
    """Two fingers that squeeze along an axis, at x."""
    e, at = np.eye(3)[axis], np.array([x, 0.0, 0.0])
    return [hl.Contact(at - a * e, a * e, hl.Coulomb(mu), tangent=(0, 0, 1), name=f"{name} {a:+}") for a in (1.0, -1.0)]


def three_pairs(mu):
    """Three pinches that share the load, one of them with less friction."""
    return [*pair(0, mu, name="weak"), *pair(1, 0.9, 0.5, "strong"), *pair(1, 0.9, -0.5, "strong")]


# Fourth-order differences over these leave about 1e-10 of truncation and of the solver's rounding
STEPS = {
    "wrench": 1e-4, "squeeze": 1e-6, "joint_offset": 1e-5, "stiffness": 1e-3, "pads": 1e-7, "friction": 1e-4,
    "torque_limits": 1e-5, "positions": 1e-6, "normals": 1e-5, "posture": 3e-6, "lengths": 3e-7, "mass": 1e-4,
}  # fmt: skip


def varied(grasp, parameter, index, step):
    """The grasp with one entry of a parameter larger by a step, made with none of the code that differentiates."""
    spec, i = grasp.spec, index[0]
    if parameter in ("wrench", "squeeze", "pads"):
        wrench, offset, E = spec.wrench.copy(), spec.offset.copy(), spec.flexibility.copy()
        if parameter == "wrench":
            wrench[i] += step
        elif parameter == "squeeze":
            offset[i, 2] -= step
        else:
            E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] += np.diag([1.0, 0.0 if spec.planar else 1.0, 1.0]) * step
        return make_grasp(spec.replace(wrench=wrench, offset=offset, flexibility=E, asked=spec.asked))
    if parameter == "mass":
        return grasp.replace(mass=grasp.target.mass + step)
    if parameter == "friction":
        laws = [c.friction for c in spec.contacts]
        laws[i] = laws[i].with_mu(laws[i].mu + step)
        return make_grasp(spec.with_laws(tuple(laws)))
    if parameter in ("positions", "normals"):
        return _contacts(spec, parameter, *index, step)
    if parameter == "joint_offset":
        return grasp.replace(joint_offset=grasp.joint_offset + np.eye(grasp.state.hand.nv)[i] * step)
    hand, q = grasp.state.hand, grasp.state.q.copy()
    if parameter == "stiffness":
        K = np.array(hand.joint_stiffness)
        K[i, i] += step
        hand = hand.replace(joint_stiffness=K)
    elif parameter == "torque_limits":
        limits = np.array(hand.torque_limits)
        limits[i] += step
        hand = hand.replace(torque_limits=limits)
    elif parameter == "lengths":
        hand = lengthen_link(hand, 3 * i + index[1], step)
    else:
        q[i] += step
    return make_grasp(replace(spec.asked, state=hand.at(q)).spec())


def _contacts(spec, parameter, i, axis, step):
    positions, frames = spec.positions.copy(), spec.frames.copy()
    if parameter == "positions":
        positions[i, axis] += step
    else:
        frames[i] = frames[i] @ pin.exp3(np.eye(3)[axis] * step)
    if spec.mechanism is not None:
        return make_grasp(spec.mechanism.variation.replace_contacts(spec, positions, frames))
    contacts = [
        hl.Contact(p, R[:, 2], c.friction, tangent=R[:, 0])
        for p, R, c in zip(positions, frames, spec.contacts, strict=True)
    ]
    return make_grasp(replace(hl.Grasp(contacts).spec, wrench=spec.wrench, reference=spec.reference,
                            flexibility=spec.flexibility, offset=spec.offset, effects=spec.effects))  # fmt: skip


def quantities(solution):
    """What a solution says of each quantity."""
    same = "forces", "slip", "gap", "friction_margin", "torsion", "torques", "torque_margin"
    fields = {name: name for name in same} | {"displacement": "object_displacement"}
    found = {name: getattr(solution, of, None) for name, of in fields.items()}
    if (margin := found["torque_margin"]) is not None:
        found["torque_margin"] = np.where(np.isfinite(margin), margin, np.nan)
    return {name: x for name, x in found.items() if x is not None}


def differences(grasp, solution, faces, parameter, index):
    """(differences, step): fourth-order central differences of whole solves, with a step on which no contact changes
    its state.
    """
    h = STEPS[parameter]
    for _ in range(4):
        found = [varied(grasp, parameter, index, k * h).solve(faces, start=solution) for k in (1, -1, 2, -2)]
        if all(s.contact_state == solution.contact_state for s in found):
            break
        h /= 10.0
    a, b, c, d = map(quantities, found)
    return {name: (8 * (a[name] - b[name]) - (c[name] - d[name])) / (12 * h) for name in a}, h


def _with_gaps(s, parameter, index, name):
    """The derivative where fingertips that just touch leave gaps, on whichever side that is: overlaps of less than a
    micrometre, as in these differences, count as touching. One joint or length moves the tip of one finger.
    """
    _, change = s._rates_by(parameter)
    way = np.zeros(s.of("displacement", parameter).shape[1:])
    way[index] = 1.0
    deeper = change.rates.reshape(-1, *way.shape)[(slice(None), *index)]
    assert (deeper <= 1e-9).all() or (deeper >= -1e-9).all()
    both = s.along(parameter, way)
    return (both.behind if (deeper > 1e-9).any() else both.ahead)[name]


_ALIKE = (("forces", "friction_margin"), ("slip", "gap", "displacement"), ("torques", "torque_margin"), ("torsion",))
# Of a quantity, what a solve is off by; where forces change their own flexibility, it is solved until they stay
_ROUNDING, _ITERATED = 1e-12, 1e-10


def misses(grasp, solution, faces, parameter, index):
    """By quantity, how far its derivative is from differences, as a share of the largest entry of this parameter among
    quantities of a kind, rounding of the differences left out; inf where one of the two is no number.
    """
    found, s, values = {}, solution.sensitivity(), quantities(solution)
    noise = _ITERATED if any(e.depends_on_forces for e in grasp.effects) else _ROUNDING
    truths, step = differences(grasp, solution, faces, parameter, index)
    two_sided = [k for k in s.kinks if parameter in k.by]
    size = {name: np.nanmax(abs(s.of(name, parameter)), initial=0.0) for name in truths}
    for name, truth in truths.items():
        one = _with_gaps(s, parameter, index, name) if two_sided else s.of(name, parameter)[(..., *index)]
        if name == "friction_margin":  # without a tangential force it has a corner
            smooth = np.hypot(*solution.tangential_force.T) > 1e-6 * abs(solution.forces).max()
            one, truth = np.where(smooth, one, 0.0), np.where(smooth, truth, 0.0)
        known, alike = np.isfinite(truth) & np.isfinite(one), next(group for group in _ALIKE if name in group)
        largest = max(size.get(other, 0.0) for other in alike)
        rounding = noise * max(np.nanmax(abs(values[other]), initial=0.0) for other in alike if other in values)
        missed = abs(np.where(known, one - truth, 0.0)).max(initial=0.0) - rounding / step
        found[name] = max(missed, 0.0) / largest if largest > 0.0 else max(missed, 0.0)
        if (np.isfinite(truth) != np.isfinite(one)).any():
            found[name] = np.inf
    return found
