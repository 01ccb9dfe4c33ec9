"""Your own inputs: an object from an STL file, a hand that is a Pinocchio model, a posture that a planner gives."""

import pathlib
import tempfile

import pinocchio as pin
import trimesh

import handlcp as hl

stl = pathlib.Path(tempfile.mkdtemp()) / "capsule.stl"  # in millimetres, as CAD programs write it
trimesh.creation.capsule(height=60.0, radius=18.0).export(stl)
model = pin.buildModelFromUrdf(str(pathlib.Path(__file__).parents[2] / "urdf" / "three_finger.urdf"))

part = hl.Mesh(stl, scale=1e-3, placement=(0, 0, 0.08), density=1000.0)  # kg/m³
hand = hl.Hand.from_model(model, joint_stiffness=6.0, pad_flexibility=1e-4, tip_radius=0.012)
planned = {name: 0.14 if name.endswith("proximal") else 0.062 for name in hand.joint_names}  # rad
grasp = hand.at(planned).grasp(part, friction=0.8, squeeze=0.004)
print(grasp.check())
