"""`HandDescription`: joints with ranges, limits, stiffness; fingertips, couplings, mass and size."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import check_call, check_method_calls
from handlcp.errors import HandLCPError, InputError
from handlcp.record import Record, pick_entries
from handlcp.robot.audit import Audit, file_doubts, make_audit
from handlcp.robot.description import COLLISION, VISUAL, RobotDescription, describe_xml
from handlcp.robot.description_row import (
    DEFAULT_SOURCE,
    GIVEN_SOURCE,
    NO_SOURCE,
    CouplingRow,
    JointRow,
    LinkRow,
    OriginRow,
    StatedRow,
    TendonRow,
    TipRow,
    TouchRow,
    describe_shape,
    drive_origins,
    file_origins,
    format_description,
    limit_origins,
    stated_rows,
)
from handlcp.robot.fingertip import FingertipCandidate, choose_obvious_tips, find_tip_candidates
from handlcp.robot.joint import Coupling, TorqueLimits, read_torque_limits
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_surface import surface_points
from handlcp.robot.servo_stiffness import read_file_stiffness

# ---------------------------------------------------------------- How large a hand is.


def hand_extents(described: RobotDescription, kinematics: Kinematics) -> tuple[float, float, float]:
    """Extents along x, y, z in the neutral posture [m]: of the collision geometry, else of what is drawn, else of the
    links' frames.
    """
    places, _ = kinematics.frames_at(kinematics.neutral, range(1, len(described.model.frames)))
    points = [places[:, :3, 3]]
    for kind in (COLLISION, VISUAL):
        try:
            parts = [part for part in described.load_shapes(kind) if part.frame]
        except HandLCPError:  # its meshes are missing
            continue
        surfaces = [
            (places[p.frame - 1], surface_points([(p.shape, p.rotation, p.position)], corners=True)) for p in parts
        ]
        if found := [at @ place[:3, :3].T + place[:3, 3] for place, at in surfaces if at is not None]:
            points = found
            break
    x, y, z = np.ptp(np.concatenate(points), axis=0).tolist()
    return (x, y, z)


# ----------------------------------------------------------------
# What a hand is: `hand.describe()`, and `describe_urdf` for a file of which nothing else is known yet.

_ROW_ENTRIES = {
    "joints": ("name", "kind", "lower", "upper", "torque_limit_Nm", "stiffness_Nm_per_rad", "fingertips"),
    "fingertips": ("name", "link", "point_m (3,)", "taken", "reason"),
    "touching": ("name", "shapes", "pad_m_per_N (3, 3) = pad"),
    "tendons": ("name", "arms_m", "tension_limit_N", "closes_N"),
    "links": ("name", "mass_kg", "joint", "geometry"),
}


@check_method_calls
@dataclass(frozen=True)
class HandDescription(Record):
    """A hand in words and numbers; iterates over its joints, prints in lines of at most 80 columns.

    name : the robot's. source : the file's. joints : the independent ones, in the order of every vector over joints.
    fingertips : those of the hand, and what else could be one (`taken` says which). touching : what may touch an object
    where a grasp asks for links; () for a file, and where meshes are missing. couplings : joints that follow,
    chains : of them, those that do so through others, as names from the joint to the independent one. tendons : of a
    hand with some. links : all of them. mass [kg]. size (3,) : extents along x, y, z in the neutral posture [m].
    origins : where each number came from. stated : what the file states besides: friction, springs, gears. audit : its
    doubts.
    """

    entries = (
        "name",
        "source",
        "mass_kg",
        "size_m (3,)",
        "joints",
        "fingertips",
        "touching",
        "couplings",
        "chains",
        "tendons",
        "links",
        "origins",
        "stated",
        "doubts = audit.doubts",
    )

    name: str
    source: str
    joints: tuple[JointRow, ...]
    fingertips: tuple[TipRow, ...]
    touching: tuple[TouchRow, ...]
    couplings: tuple[CouplingRow, ...]
    chains: tuple[tuple[str, ...], ...]
    tendons: tuple[TendonRow, ...]
    links: tuple[LinkRow, ...]
    mass: float
    size: tuple[float, float, float]
    origins: tuple[OriginRow, ...]
    stated: tuple[StatedRow, ...]
    audit: Audit

    def __iter__(self) -> Iterator[JointRow]:
        return iter(self.joints)

    def __len__(self) -> int:
        return len(self.joints)

    def to_dict(self) -> dict[str, Any]:
        """The description as plain data for JSON, SI units in the keys; None where nothing is known, or a range has
        no end.
        """
        rows = {
            name: [pick_entries(row, *lines) for row in getattr(self, name)] for name, lines in _ROW_ENTRIES.items()
        }
        return pick_entries(self, *self.entries) | rows

    def __str__(self) -> str:
        return format_description(self)


@check_call()
def describe_urdf(path: Any, base: str | None = None, package_dirs: Any = None) -> HandDescription:
    """Describe a URDF or MJCF file, or its text, of which nothing is known yet; below link `base` if given.

    Raises URDFError, UnknownName for an unknown base; Unsupported for an MJCF file without MuJoCo.
    """
    described = describe_xml("path", path, base, package_dirs)
    kinematics = Kinematics(described.model, described.facts)
    joints, facts = kinematics.joint_names, {f.name: f for f in described.facts}
    found = find_tip_candidates(described)
    taken = {c.name for c in choose_obvious_tips(found)}
    tips = tuple(_candidate_row(c, c.name in taken) for c in found)
    audit = make_audit(described.source, file_doubts(described, kinematics))
    try:
        stiffness = read_file_stiffness(described, kinematics)
    except InputError:
        stiffness = None
    drives = [OriginRow("stiffness", joints, NO_SOURCE)] if stiffness is None else drive_origins(stiffness, joints)
    origins = [*limit_origins(facts, joints), *drives]
    limits = read_torque_limits(None, joints, facts)
    return _build_description(described, kinematics, tips, (), limits, stiffness, audit, origins)


def describe_hand(hand: Any, touching: Iterable[Any]) -> HandDescription:
    """Of a hand; as a method, `hand.describe()`. touching : with name, shapes and pad, what may touch."""
    described, frames = hand.description, hand.kinematics.model.frames
    reasons = {(c.name, c.link): c for c in find_tip_candidates(described)}
    tips = []
    for name, place in zip(hand.fingertips, hand.tips.places, strict=True):
        frame = frames[place.link]
        at = (frame.placement.inverse() * place.placement).translation
        x, y, z = (round(float(v), 6) for v in at)
        point = (x, y, z) if np.linalg.norm(at) > 1e-9 else None
        known = reasons.pop((name, frame.name), None)
        same = known is not None and (known.point is None) == (point is None)
        tips.append(TipRow(name, frame.name, point, True, known.reason if known is not None and same else "named"))
    links = {t.link for t in tips}
    tips += [_candidate_row(c, False) for c in reasons.values() if c.link not in links]
    rows = tuple(TouchRow(t.name, tuple(describe_shape(shape) for shape in t.shapes), t.pad) for t in touching)
    return _build_description(
        described, hand.kinematics, tuple(tips), rows, hand.torques, hand.stiffness, hand.audit(), _hand_origins(hand)
    )


def _hand_origins(hand: Any) -> Iterator[OriginRow]:
    """Of what a hand was given, or took from its file."""
    facts, limits = {f.name: f for f in hand.description.facts}, hand.torques
    yield from limit_origins(facts, hand.joint_names, limits.given, limits.drives)
    yield from drive_origins(hand.stiffness, hand.joint_names)
    soft = [bool(pad.any()) for pad in hand.pad_flexibility]
    for some, source in ((True, GIVEN_SOURCE), (False, f"{DEFAULT_SOURCE}: rigid")):
        yield OriginRow("pad", tuple(t for t, s in zip(hand.fingertips, soft, strict=True) if s is some), source)
    shapes = {"radius": GIVEN_SOURCE, COLLISION: "collision geometry", VISUAL: "what is drawn", "": NO_SOURCE}
    for kind, source in shapes.items():
        tips = tuple(name for i, name in enumerate(hand.fingertips) if hand.tip_kind(i) == kind)
        yield OriginRow("shape of a tip", tips, source)


def _candidate_row(c: FingertipCandidate, taken: bool) -> TipRow:
    point = None if c.point is None else (float(c.point[0]), float(c.point[1]), float(c.point[2]))
    return TipRow(c.name, c.link, point, taken, c.reason)


def _build_description(
    described: RobotDescription,
    kinematics: Kinematics,
    tips: tuple[TipRow, ...],
    touching: tuple[TouchRow, ...],
    limits: TorqueLimits,
    stiffness: Elasticity | None,
    audit: Audit,
    origins: Iterable[OriginRow],
) -> HandDescription:
    """What both have in common; `limits` and `stiffness` are those of the file, or of the hand."""
    model, coupling, names = described.model, kinematics.all_joints, kinematics.joint_names
    springs = dict[str, float]()  # none behind a transmission
    if stiffness is not None and not stiffness.is_transmission:
        springs = dict(zip(names, np.diagonal(stiffness.stiffness_matrix).tolist(), strict=True))
    tendons = list[TendonRow]()
    if isinstance(stiffness, TendonStiffness):
        numbers = stiffness.arms.tolist(), stiffness.cables.limits.tolist(), stiffness.closing_tensions.tolist()
        for name, arms, limit, closes in zip(stiffness.cables.names, *numbers, strict=True):
            arms_by_joint = {joint: arm for joint, arm in zip(names, arms, strict=True) if arm}
            tendons.append(TendonRow(name, arms_by_joint, *(None if np.isinf(x) else x for x in (limit, closes))))
    moved = _moved_tips(model, coupling, kinematics.movable, [t for t in tips if t.taken] or tips)
    kinds = {f.name: f.kind for f in described.facts}
    numbers_by_joint = zip(names, kinematics.lower, kinematics.upper, limits.limits, limits.known, strict=True)
    joints = [
        JointRow(j, kinds[j], float(low), float(high), float(most) if known else None, springs.get(j), moved[j])
        for j, low, high, most, known in numbers_by_joint
    ]
    couplings = list[CouplingRow]()
    for name, row, offset in zip(kinematics.movable, coupling.C, coupling.offset.tolist(), strict=True):
        if name not in names:
            k = int(np.argmax(abs(row)))
            couplings.append(CouplingRow(name, names[k], float(row[k]), offset))
    solid, seen, masses = described.links_with(COLLISION), described.links_with(VISUAL), described.link_masses
    links = list[LinkRow]()
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY and frame.name != "universe":
            geometry = COLLISION if frame.name in solid else VISUAL if frame.name in seen else ""
            joint = model.names[frame.parentJoint] if frame.parentJoint else ""
            links.append(LinkRow(frame.name, masses.get(frame.name, 0.0), joint, geometry))
    return HandDescription(
        str(model.name),
        described.source,
        tuple(joints),
        tips,
        touching,
        tuple(couplings),
        _coupling_chains(kinematics),
        tuple(tendons),
        tuple(links),
        sum(float(inertia.mass) for inertia in model.inertias),
        hand_extents(described, kinematics),
        (*file_origins(described, names), *origins),
        tuple(stated_rows(described)),
        audit,
    )


def _moved_tips(
    model: Any, coupling: Coupling, movable: Sequence[str], tips: Iterable[TipRow]
) -> dict[str, tuple[str, ...]]:
    """Independent joint → fingertips that it moves, also through joints that follow it."""
    masters = {name: coupling.names[int(abs(row).argmax())] for name, row in zip(movable, coupling.C, strict=True)}
    carrier = {f.name: int(f.parentJoint) for f in model.frames}
    moved: dict[str, dict[str, None]] = {name: {} for name in coupling.names}
    for tip in tips:
        for j in model.supports[carrier[tip.link]]:
            if j and model.joints[j].nv:
                moved[masters[model.names[j]]][tip.name] = None
    return {name: tuple(these) for name, these in moved.items()}


def _coupling_chains(kinematics: Kinematics) -> tuple[tuple[str, ...], ...]:
    """A joint that follows, those between, and the independent one; of joints that follow through others."""
    masters = {f.name: f.mimic.master for f in kinematics.facts if f.mimic is not None and f.mimic.master}
    found = []
    for name in masters:
        chain = [name]
        while chain[-1] in masters:
            chain.append(masters[chain[-1]])
        if len(chain) > 2:
            found.append(tuple(chain))
    return tuple(found)
