"""One valid file of each kind that the package reads, and some that are made to exhaust a reader."""

import json
import shutil
import struct
from pathlib import Path

import numpy as np
import trimesh

ROOT = Path(__file__).parents[2]
CORNERS = np.array([(0, 0, 0), (0.02, 0, 0), (0, 0.02, 0), (0, 0, 0.02)], dtype=float)
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
MJCF = """<mujoco model="two">
<compiler angle="radian" meshdir="."/><size nkey="1"/><option timestep="0.002"/>
<default><joint damping="0.1" armature="0.001"/><geom density="800"/></default>
<asset><mesh name="tip" file="tip.stl" scale="1 1 1"/><texture name="t" type="2d" builtin="flat" width="4" height="4"/>
<hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset>
<worldbody><body name="palm"><geom type="box" size="0.03 0.03 0.01"/>
<replicate count="1" sep="x"><site name="s" pos="0 0 0.01"/></replicate>
<body name="left" pos="0.03 0 0"><joint name="left_joint" axis="0 1 0" range="-1 1" limited="true"/>
<geom type="capsule" size="0.008 0.02" pos="0 0 0.02"/>
<body name="left_tip" pos="0 0 0.05"><geom type="sphere" size="0.01"/></body></body>
<body name="right" pos="-0.03 0 0"><joint name="right_joint" axis="0 -1 0" range="-1 1" limited="true"/>
<inertial pos="0 0 0.02" mass="0.02" diaginertia="1e-5 1e-5 1e-5"/>
<body name="right_tip" pos="0 0 0.05"><geom type="mesh" mesh="tip"/></body></body></body></worldbody>
<tendon><fixed name="both"><joint joint="left_joint" coef="0.01"/>
<joint joint="right_joint" coef="0.01"/></fixed></tendon>
<actuator><position name="pull" joint="left_joint" kp="2" forcerange="-1 1"/><motor tendon="both" gear="1"/></actuator>
<equality><joint joint1="left_joint" joint2="right_joint" polycoef="0 1 0 0 0"/></equality>
<sensor><jointpos joint="left_joint"/></sensor></mujoco>
"""
MESH_URDF = """<robot name="m"><link name="base"><visual><geometry><mesh filename="tip.dae"/></geometry></visual></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<link name="tip"><inertial><mass value="0.01"/><inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>
</inertial><collision><geometry><mesh filename="tip.stl" scale="1 1 1"/></geometry></collision></link></robot>
"""
BRIEF = """friction = 0.6
motion_m = 0.005
tries = 16
grip_force_N = 2.0
[objects.ball]
shape = "sphere"
radius_m = 0.03
mass_kg = 0.1
[objects.part]
shape = "mesh"
file = "tip.stl"
mass_kg = 0.1
[loads.pull]
force_N = [0.0, 0.0, 1.0]
"""
STUDY = """brief = "brief.toml"
samples = 2
seed = 1
out = "study_out.csv"
[hand]
fingers = 3
joint_stiffness = 4.0
link_lengths = [0.05, 0.04]
[space]
palm_radius = { low = 0.04, high = 0.045 }
tilt = [0.0, 0.1]
"brief.friction" = 0.7
"""
YAML = """format: isaac_grasp
grasps:
  grasp_0: &one
    confidence: 0.9
    position: [0.0, 0.0, 0.1]
    orientation: {w: 0.0, xyz: [1.0, 0.0, 0.0]}
    cspace_position: {index: 0.3, thumb: -1e-2}
  grasp_1: *one
"""
SPACE = {"x": {"low": 0.0, "high": 1.0}, "kind": ["soft", "hard"]}
SWEEP = {"handlcp": "0", "space": SPACE, "sampling": "sobol", "samples": 3, "seed": 0, "make": "a", "brief": "b"}


def rows():
    """Of a sweep that nobody computed: two designs, and one that failed."""
    good = {
        "error": None, "holds": True, "payload_kg": 1.5, "factor": 2.0, "gives_out": "a slips", "worst_object": "ball",
        "force_N": 2.0, "torque_Nm": 0.3, "torque_used": 0.4, "motion_m": 1e-3, "objects.ball.word": "HELD",
    }  # fmt: skip
    bad = {"design": 2, "x": 0.75, "kind": "hard", "error": "InputError: no"}
    return [{"design": k, "x": 0.25 * k, "kind": "soft", **good} for k in (0, 1)] + [bad]


def collada(levels=0, copies=1, circle=False):
    """A tetrahedron, in nodes that stand `copies` times in each other, over so many levels."""
    nodes = "".join(
        f'<node id="n{i}">' + f'<instance_node url="#n{i + 1}"/>' * copies + "</node>" for i in range(levels)
    )
    last = "<instance_node url='#n0'/>" if circle else '<instance_geometry url="#g"/>'
    numbers, indices = " ".join(map(str, CORNERS.ravel())), " ".join(map(str, FACES.ravel()))
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>'
        '<unit meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="p">'
        f'<float_array id="pa" count="12">{numbers}</float_array><technique_common><accessor source="#pa" count="4" '
        'stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>'
        '</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        f'<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles></mesh>'
        f'</geometry></library_geometries><library_nodes>{nodes}<node id="n{levels}">{last}</node></library_nodes>'
        '<library_visual_scenes><visual_scene id="s"><node><instance_node url="#n0"/></node></visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def meshes():
    """Name → bytes of a tetrahedron in each format."""
    mesh = trimesh.Trimesh(CORNERS, FACES, process=False)
    return {
        "tip.stl": mesh.export(file_type="stl"), "text.stl": mesh.export(file_type="stl_ascii").encode(),
        "tip.obj": b"mtllib tip.mtl\n" + mesh.export(file_type="obj").encode(), "tip.mtl": b"newmtl m\n",
        "tip.dae": collada().encode(), "tip.ply": mesh.export(file_type="ply", encoding="ascii"),
    }  # fmt: skip


def write_seeds(folder):
    """Kind → valid files of it, with what stands beside them."""
    from handlcp.design.sweep.journal import beside
    from handlcp.design.sweep.table import write_table
    from tests.support.sweeps import journal_of

    put = {"hand.xml": MJCF, "mesh.urdf": MESH_URDF, "brief.toml": BRIEF, "study.toml": STUDY, "grasps.yaml": YAML}
    for name, text in put.items():
        (folder / name).write_text(text, encoding="utf-8")
    for name, data in meshes().items():
        (folder / name).write_bytes(data)
    for file in (ROOT / "urdf").glob("*.urdf"):
        shutil.copy(file, folder / file.name)
    pose = np.array([0.0, 0, 0, 1, 0, 0, 0])
    numbers = {"grasp_qpos": np.array([[*pose, 0.1, 0.2]]), "obj_pose": pose}
    np.savez(folder / "grasps.npz", **numbers)
    np.savez_compressed(folder / "packed.npz", **numbers)
    np.save(folder / "numbers.npy", numbers["grasp_qpos"])
    np.save(folder / "pickled.npy", numbers, allow_pickle=True)
    for name in ("table.csv", "table.parquet"):
        write_table(folder / name, SWEEP, rows())
    journal_of(folder / "begun.csv", SWEEP, rows())
    examples = [p for p in sorted((ROOT / "examples").rglob("*.toml")) if p.stem != "stated"]
    scenes = [p for p in examples if "[hand]" not in p.read_text(encoding="utf-8")]
    for scene in scenes:
        shutil.copy(scene, folder / f"scene_{scene.name}")
    return {
        "urdf": [folder / "mesh.urdf", *sorted(folder.glob("*_finger.urdf"))], "mjcf": [folder / "hand.xml"],
        "scene": sorted(folder.glob("scene_*.toml")), "brief": [folder / "brief.toml"],
        "study": [folder / "study.toml"], "yaml": [folder / "grasps.yaml"],
        "npy": [folder / name for name in ("grasps.npz", "packed.npz", "numbers.npy", "pickled.npy")],
        "csv": [folder / "table.csv"], "parquet": [folder / "table.parquet"], "json": [folder / "table.csv.json"],
        "rows": [beside(folder / "begun.csv")],
        "mesh": [folder / name for name in ("tip.stl", "text.stl", "tip.obj", "tip.dae", "tip.ply")],
    }  # fmt: skip


def study_saying(victim, lines):
    """A study with these lines below its [hand]; VICTIM stands for a file of somebody."""
    return STUDY.replace("[space]", f"{lines}\n[space]").replace("VICTIM", victim.as_posix())


def bombs(victim):
    """(kind, ending, contents) of small files that describe much, or say where to write. victim : a file of somebody,
    which has to stay what it is.
    """
    laughs = "a: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"b{i}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(9)
    )
    body = '<worldbody><body name="b"><joint/><geom size="0.1"/></body></worldbody></mujoco>'
    many = " ".join(f'a{i}="1"' for i in range(300_000))
    wide = {f'"{i}"': i for i in range(20_000)}
    deep_json = json.dumps(SWEEP).replace('"sobol"', "[" * 100_000 + "]" * 100_000)
    mjcf = {
        "key": f'<mujoco><size nkey="100000000"/>{body}', "user": f'<mujoco><size nuser_body="100000000"/>{body}',
        "memory": f'<mujoco><size memory="100G"/>{body}',
        "copies": body.replace("<worldbody>", '<mujoco><worldbody><replicate count="20000">').replace(
            "</worldbody>", "</replicate></worldbody>"),
        "nested": "<mujoco><worldbody>" + '<replicate count="100">' * 5 + '<body><joint/><geom size="0.1"/></body>'
        + "</replicate>" * 5 + "</worldbody></mujoco>",
        "picture": '<mujoco><asset><texture type="2d" builtin="flat" width="99999" height="99999" name="t"/></asset>'
        + body,
        "heights": f'<mujoco><asset><hfield name="h" nrow="99999" ncol="99999" size="1 1 1 1"/></asset>{body}',
        "grid": '<mujoco><worldbody><flexcomp name="f" type="grid" count="99 99 99" spacing=".1 .1 .1"/></worldbody>'
        "</mujoco>",
        "steps": '<mujoco><compiler><lengthrange mode="all" inttotal="1e9" timestep="1e-9"/></compiler><worldbody>'
        '<body><joint name="j"/><geom size="0.1"/></body></worldbody><actuator><muscle joint="j"/></actuator></mujoco>',
        "sensor": f'{body[:-9]}<sensor><user dim="1000000000"/></sensor></mujoco>'.replace("<world", "<mujoco><world"),
        "itself": "<mujoco><include file='bomb_itself.xml'/></mujoco>", "attributes": f"<mujoco {many}>{body}",
    }  # fmt: skip
    found = [("mjcf", f"{name}.xml", text.encode()) for name, text in mjcf.items()]
    found += [
        ("yaml", "laughs.yaml", laughs.encode()), ("yaml", "graspgen.yaml", f"{laughs}grasps: *a9\n".encode()),
        ("yaml", "deep.yaml", b"[" * 100_000), ("yaml", "itself.yaml", b"grasps: &a {b: *a}"),
        ("yaml", "date.yaml", YAML.replace("0.9", "2001-99-99").replace("0.3", "2001-01-01").encode()),
        ("yaml", "long.yaml", YAML.replace("0.3", "9" * 400).encode()),
        ("yaml", "nan.yaml", YAML.replace("0.3", ".nan").encode()),
        ("yaml", "nan2.yaml", YAML.replace("0.3", "nan").encode()),
        ("yaml", "run.yaml", b"!!python/object/apply:os.system ['touch VICTIM']".replace(b"VICTIM", bytes(victim))),
        ("mesh", "copies.dae", collada(30, 2).encode()), ("mesh", "circle.dae", collada(3, 2, True).encode()),
        ("mesh", "count.dae", collada().replace('count="12"', 'count="4000000000"').encode()),
        ("mesh", "offset.dae", collada().replace('offset="0"', 'offset="400000000"').encode()),
        ("mesh", "device.obj", b"mtllib /dev/stdin\n" + meshes()["tip.obj"]),
        ("mesh", "count.ply", meshes()["tip.ply"].replace(b"vertex 4", b"vertex 4000000000")),
        ("mesh", "count.stl", bytes(80) + struct.pack("<I", 2**32 - 1)),
        ("mesh", "laughs.dae", b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">]><COLLADA>&a;</COLLADA>'),
        ("urdf", "attributes.urdf", f"<robot {many}/>".encode()),
        ("urdf", "deep.urdf", b"<robot>" + b"<link>" * 400_000),
        ("urdf", "scale.urdf", MESH_URDF.replace("1 1 1", "1e300 1 1").encode()),
        ("urdf", "copies.urdf", MESH_URDF.replace("tip.stl", "bomb_copies.dae").encode()),
        ("scene", "dots.toml", b"a" + b".a" * 20_000 + b" = 1"), ("scene", "deep.toml", b"a = " + b"[" * 100_000),
        ("scene", "unknown.toml", "".join(f"k{i} = 1\n" for i in range(90_000)).encode()),
        ("brief", "dots.toml", b"[a" + b".a" * 20_000 + b"]"),
        ("study", "names.toml", (STUDY + "".join(f"k{i} = 1\n" for i in range(50_000))).encode()),
        ("csv", "long.csv", b"design,x,kind,error\n0,0.1,soft," + b"a" * 131_073 + b"\n"),
        ("csv", "null.csv", b"null"), ("json", "deep.csv.json", deep_json.encode()), ("json", "null.csv.json", b"null"),
        ("json", "none.csv.json", b"{"), ("json", "wide.csv.json", json.dumps(SWEEP | {"space": wide}).encode()),
        ("npy", "shape.npy", _npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }")),
        ("npy", "deep.npy", _npy("[" * 9000)), ("npy", "fields.npy", _npy("{'descr': [('a', '<f8')], 'shape': (1,)}")),
    ]  # fmt: skip
    lines = ['file = "VICTIM"', 'name = "x"', 'motors = "VICTIM"', "joint_friction = 'VICTIM'"]
    found += [("study", f"hand{i}.toml", study_saying(victim, line).encode()) for i, line in enumerate(lines)]
    more = ['file = ["VICTIM", "a"]', 'file = "VICTIM"', '"brief.objects" = "VICTIM"', '"brief.loads" = "VICTIM"']
    found += [("study", f"space{i}.toml", (STUDY + line).replace("VICTIM", victim.as_posix()).encode())
              for i, line in enumerate(more)]  # fmt: skip
    outs = [victim.with_suffix(".csv").as_posix(), "../outside.csv", "/dev/null.csv", "a\\u0000.csv"]
    found += [("study", f"out{i}.toml", STUDY.replace("study_out.csv", out).encode()) for i, out in enumerate(outs)]
    return found


def _npy(header):
    """A file of this header, and no numbers."""
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header) + 1) + header.encode() + b"\n"
