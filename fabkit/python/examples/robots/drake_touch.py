"""Presses a ball into a sensor in Drake, whose layers give way as tetrahedra (compliant hydroelastic contact).

    pip install drake
    fabkit export rtac0 --robot drake -o robot
    fabkit press rtac0 --indenter ball@0deg,0deg --depth 0.8mm --csv curve.csv
    python drake_touch.py robot curve.csv

Drake's pressure is the modulus times how far a point lies between the surface of the soft body and its middle: it knows neither the
glass below nor that rubber keeps its volume. The last column is the force of fabkit's elastic solution of the same ball.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
from pydrake.geometry import AddContactMaterial, AddRigidHydroelasticProperties, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import SpatialInertia, default_model_instance
from pydrake.systems.framework import DiagramBuilder

# Of the indenter `ball`, its radius.
BALL_M = 0.0025

folder = Path(sys.argv[1])
robot = json.loads((folder / "robot.json").read_text())
builder = DiagramBuilder()
# Contacts of where things are now, not of a step before.
config = MultibodyPlantConfig(time_step=1e-4, contact_model="hydroelastic", use_sampled_output_ports=False)
plant, _ = AddMultibodyPlant(config, builder)
(sensor,) = Parser(plant).AddModels(str(folder / f"{robot['sensor']}.drake.sdf"))
plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base", sensor))
ball = plant.AddRigidBody("ball", default_model_instance(), SpatialInertia.SolidSphereWithMass(0.01, BALL_M))
properties = ProximityProperties()
AddContactMaterial(dissipation=0.0, properties=properties)
AddRigidHydroelasticProperties(BALL_M / 20, properties)
plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(BALL_M), "ball", properties)
plant.Finalize()
diagram = builder.Build()
context = diagram.CreateDefaultContext()
own = plant.GetMyMutableContextFromRoot(context)

frame = next(frame for frame in robot["frames"] if frame["name"] == "touch_frame")
middle, normal = np.array(frame["place_m"]), np.array(frame["rotation"])[:, 2]
with open(sys.argv[2], newline="") as file:
    curve = [row for row in csv.DictReader(file) if float(row["depth_mm"]) > 0]
print("depth mm   drake N  fabkit N")
for row in curve:
    depth_m = float(row["depth_mm"]) / 1000
    plant.SetFreeBodyPose(own, ball, RigidTransform(middle + (BALL_M - depth_m) * normal))
    plant.SetFreeBodySpatialVelocity(own, ball, SpatialVelocity(np.zeros(6)))
    contacts = plant.get_contact_results_output_port().Eval(own)
    met = [contacts.hydroelastic_contact_info(i) for i in range(contacts.num_hydroelastic_contacts())]
    force_n = sum(abs(info.F_Ac_W().translational() @ normal) for info in met)
    print(f"{1000 * depth_m:8.3f} {force_n:9.3f} {float(row['force_n']):9.3f}")
