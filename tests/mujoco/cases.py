"""The cases: six hands; sticking, sliding, soft fingers, tables, large motions, objects lost, load limits."""

import pathlib

import numpy as np
import pinocchio as pin

import handlcp as hl
import handlcp.scene
from tests.mujoco.case import Case, closing

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
BALL = {"radius": 0.035, "placement": [0, 0, 0.07], "mass": 0.3}
UP = (0.0, 0.0, 9.81)  # gravity of hands that hang: along their fingers


def three(obj=None, K=6.0, offset=0.02, law=None, hand=None, **more):
    """Three fingers that stand around an object of 50 g."""
    the_hand = hl.example_hand("three_finger", joint_stiffness=K, **(hand or {}))
    obj = hl.Box(0.05, [0, 0, 0.08], mass=0.05) if obj is None else obj
    state = the_hand.at(the_hand.close_on(obj))
    return state.grasp(obj, law or hl.Coulomb(0.8), joint_offset=[offset, offset] * 3, **more)


def five(K, depth, mu=0.6, height=0.07, gravity=UP, **more):
    """Five fingers that hang around a ball of 300 g."""
    hand, obj = hl.example_hand("five_finger", joint_stiffness=K), hl.Sphere(**(BALL | {"placement": [0, 0, height]}))
    return closing(hand.at(hand.close_on(obj)).grasp(obj, hl.Coulomb(mu), gravity=gravity, **more), depth)


def two(obj, offset=0.01, law=None, table=None, wrench=None, hand=None, **more):
    """Two fingers that hang and pinch, beside a table where there is one: its place and its flexibility."""
    hand = hl.example_hand("two_finger", joint_stiffness=6.0, pad_flexibility=2e-4, **(hand or {}))
    around = None
    if table is not None:
        around = hl.Table([0, 0, table[0]], [0, 0, -1], hl.Coulomb(0.4), flexibility=table[1])
    state = hand.at(hand.close_on(obj))
    return state.grasp(obj, law or hl.Coulomb(0.8), joint_offset=[offset] * 4, gravity=UP, environment=around,
                       wrench=wrench, **more)  # fmt: skip


def pinch(**more):
    """Two soft fingers that pinch a cube of 50 g."""
    return two(hl.Box(0.05, [0, 0, 0.085], mass=0.05), 0.05, hl.SoftFinger(0.8, 0.008), **more)


def slow(name, hand, kind, make, load=None):
    """A case whose contacts slide far."""
    return Case(name, hand, kind, make, load, seconds=8.0)


def scene(name, depth, K=6.0):
    """A shipped scene, squeezed by its joints."""
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not line.startswith(("preload_m", "squeeze_m"))]
    springs = f"joint_stiffness_Nm_per_rad = {K}"
    return closing(hl.scene.read("\n".join(kept).replace("joint_stiffness_Nm_per_rad = 6.0", springs)).build(), depth)


def coupled():
    K = np.diag([6.0] * 6)
    K[0, 1] = K[1, 0] = 2.0
    K[2, 4] = K[4, 2] = -1.0
    return K


TENDONS = hl.Tendons(
    {"pull": {"finger_1_proximal": 0.01, "finger_1_distal": 0.008}, "pair": {"finger_2_distal": 0.01,
     "finger_3_distal": 0.01}}, 2e4, 4.0)  # fmt: skip
TURNED = hl.Ellipsoid(
    [0.03, 0.025, 0.035], pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.2, 0.1), np.array([0, 0, 0.08])), mass=0.05
)
CAN = hl.Cylinder(0.03, 0.06, [0, 0, 0.08], mass=0.05)
FOOTED = hl.Box([0.05, 0.05, 0.07], [0, 0, 0.09], mass=0.5)
CUP = hl.Cylinder(0.025, 0.07, [0, 0, 0.09], mass=0.5)
ASIDE = [0.5, 0, 0, 0, 0, 0]
BEAD = hl.Sphere(0.03, [0, 0, 0.085], mass=0.5)

STICKS = (
    Case("cube", "three_finger", "sticks", three),
    Case("cube, stiff, squeezed hard", "three_finger", "sticks", lambda: three(K=20.0, offset=0.05)),
    Case("ball", "three_finger", "sticks", lambda: three(hl.Sphere(0.03, [0, 0, 0.08], mass=0.05))),
    Case("ellipsoid", "three_finger", "sticks", lambda: three(hl.Ellipsoid([0.03, 0.03, 0.04], [0, 0, 0.08], 0.05))),
    Case("turned ellipsoid, load about another point", "three_finger", "sticks",
         lambda: three(TURNED, reference=[0.01, 0, 0.07], wrench=[0, 0, -0.1, 0.001, 0, 0])),
    Case("cube of the README", "three_finger", "sticks", lambda: scene("cube_three_fingers", 0.005)),
    Case("can", "three_finger", "sticks", lambda: three(CAN)),
    Case("pads that differ by axis", "three_finger", "sticks",
         lambda: three(hand={"pad_flexibility": [1e-4, 2e-4, 5e-5]}), short=True),
    Case("no pads", "three_finger", "sticks", lambda: three(hand={"pad_flexibility": 0.0})),
    Case("all together", "three_finger", "sticks", three, order="together", short=True),
    Case("torque about the vertical", "three_finger", "sticks", lambda: three(wrench=[0, 0, 0, 0, 0, 0.005])),
    Case("fingers that sag", "three_finger", "sticks", lambda: three(finger_weight=True)),
    Case("fingers that sagged", "three_finger", "sticks", lambda: three(finger_weight="torques")),
    Case("joints at their limit", "three_finger", "sticks",
         lambda: three(offset=0.03, hand={"torque_limits": 0.12}, effects=[hl.TorqueSaturation()]), short=True),
    Case("five fingers, 1 mm", "five_finger", "sticks", lambda: five(6.0, 0.001, height=0.075)),
    Case("five fingers, 3 mm", "five_finger", "sticks", lambda: five(6.0, 0.003)),
    Case("Allegro pinch", "allegro", "sticks", lambda: scene("allegro_pinch", 0.002)),
    Case("Allegro pinch, 5 mm", "allegro", "sticks", lambda: scene("allegro_pinch", 0.005)),
    Case("Allegro pinch, soft, pulled", "allegro", "sticks",
         lambda: scene("allegro_pinch", 0.004, K=3.0).replace(wrench=[0.5, 0, -1.0, 0, 0, 0])),
    Case("planar ring", "planar_ring", "sticks", lambda: scene("planar_ring", 0.001), short=True),
)  # fmt: skip

SLIDING = (
    Case("coupled springs", "three_finger", "slides", lambda: three(K=coupled()), short=True),
    Case("tendons", "three_finger", "slides", lambda: three(K=TENDONS), short=True),
    Case("soft fingers", "three_finger", "slides", lambda: three(law=hl.SoftFinger(0.8, 0.004)), short=True),
    Case("soft fingers, small patch", "three_finger", "slides", lambda: three(law=hl.SoftFinger(0.8, 5e-4))),
    Case("soft pinch against a torque", "two_finger", "sticks", lambda: pinch(wrench=[0, 0, 0, 0.005, 0, 0])),
    Case("box on a soft table", "two_finger", "slides", lambda: two(FOOTED, table=(0.125, 1e-4), wrench=ASIDE)),
    Case("box on a soft table, pushed", "two_finger", "jumps",
         lambda: two(FOOTED, 0.03, table=(0.125, 1e-4), wrench=[2.5, 0, 0, 0, 0, 0])),
    Case("ball on a soft table", "two_finger", "slides", lambda: two(BEAD, table=(0.115, 1e-4), wrench=ASIDE)),
    Case("ball on a rigid table", "two_finger", "slides", lambda: two(BEAD, table=(0.115, 0.0), wrench=ASIDE)),
    Case("can on a soft table", "two_finger", "slides", lambda: two(CUP, table=(0.125, 1e-4), wrench=ASIDE)),
    Case("can in the psyonic hand, 3 mm", "psyonic", "slides", lambda: scene("psyonic_grasp", 0.003)),
    slow("can in the psyonic hand, 1 mm", "psyonic", "slides", lambda: scene("psyonic_grasp", 0.001)),
    slow("five fingers, pulled with 13 N", "five_finger", "slides",
         lambda: five(6.0, 0.003, wrench=[0, 0, 13.0, 0, 0, 0])),
    slow("box pushed along a table", "two_finger", "slides", lambda: two(FOOTED, 0.03, table=(0.125, 1e-4)),
         [20.0, 0, 0, 0, 0, 0]),
    slow("cube pushed sideways", "three_finger", "slides", three, [0, 4.0, 0, 0, 0, 0]),
    slow("cube twisted", "three_finger", "slides", three, [0, 0, 0, 0, 0, 0.12]),
)  # fmt: skip

LOST = (
    slow("300 g in a soft hand, closed 1 mm", "five_finger", "lost", lambda: five(1.0, 0.001)),
    slow("pulled with 20 N", "five_finger", "lost", lambda: five(6.0, 0.003, wrench=[0, 0, 20.0, 0, 0, 0])),
    Case("squeezed below the equator, little friction", "five_finger", "lost", lambda: five(6.0, 0.003, mu=0.3)),
)  # fmt: skip

LIMITS = (
    Case("cube pulled down", "three_finger", "limit", three, [0, 0, -4.0, 0, 0, 0]),
    slow("ball pulled out of five fingers", "five_finger", "limit", lambda: five(6.0, 0.003), [0, 0, 20.0, 0, 0, 0]),
    slow("ball pushed into five fingers", "five_finger", "limit", lambda: five(6.0, 0.003), [0, 0, -8.0, 0, 0, 0]),
    slow("pinch turned", "two_finger", "limit", pinch, [0, 0, 0, 0.06, 0, 0]),
    slow("ball pulled out of three fingers", "three_finger", "limit",
         lambda: three(hl.Sphere(0.03, [0, 0, 0.08], mass=0.05)), [0, 0, -6.0, 0, 0, 0]),
    slow("can pulled out of three fingers", "three_finger", "limit", lambda: three(CAN, K=20.0), [0, 0, 20.0, 0, 0, 0]),
    slow("ball pulled out of a soft hand", "five_finger", "limit", lambda: five(2.0, 0.003), [0, 0, 8.0, 0, 0, 0]),
    slow("Allegro pinch lifted", "allegro", "limit", lambda: scene("allegro_pinch", 0.004), [0, 0, 6.0, 0, 0, 0]),
    slow("can pulled out of the psyonic hand", "psyonic", "limit", lambda: scene("psyonic_grasp", 0.003),
         [-12.0, 0, 0, 0, 0, 0]),
    slow("Allegro pinch pulled", "allegro", "limit", lambda: scene("allegro_pinch", 0.003), [6.0, 0, 0, 0, 0, 0]),
    slow("disc pulled out of the ring", "planar_ring", "limit", lambda: scene("planar_ring", 0.001),
         [0.3, -40.0, 0, 0, 0, 0]),  # to the side, too: upright it stays where no push finds it
)  # fmt: skip

CASES = (*STICKS, *SLIDING, *LOST, *LIMITS)
