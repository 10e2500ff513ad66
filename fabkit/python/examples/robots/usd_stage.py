"""Puts a sensor on a stage with a ball above it, for Isaac Sim or any other reader of UsdPhysics.

    pip install usd-core
    fabkit export rtac0 --robot usd -o robot
    python usd_stage.py robot stage.usda
"""

import json
import sys
from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdPhysics

folder, path = Path(sys.argv[1]), Path(sys.argv[2])
robot = json.loads((folder / "robot.json").read_text())
frame = next(frame for frame in robot["frames"] if frame["name"] == "touch_frame")

stage = Usd.Stage.CreateNew(str(path))
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 1)
UsdPhysics.SetStageKilogramsPerUnit(stage, 1)
UsdPhysics.Scene.Define(stage, "/scene")
world = UsdGeom.Xform.Define(stage, "/world")
stage.SetDefaultPrim(world.GetPrim())
sensor = stage.DefinePrim("/world/sensor")
sensor.GetReferences().AddReference(str((folder / f"{robot['sensor']}.usda").resolve()))
# Its base stands still; a robot's own link would carry it by the frame `mount`.
hold = UsdPhysics.FixedJoint.Define(stage, "/world/hold")
hold.CreateBody1Rel().SetTargets(["/world/sensor/base"])
ball = UsdGeom.Sphere.Define(stage, "/world/ball")
ball.CreateRadiusAttr(0.004)
ball.CreateExtentAttr([(-0.004, -0.004, -0.004), (0.004, 0.004, 0.004)])
UsdGeom.XformCommonAPI(ball).SetTranslate(Gf.Vec3d(*frame["place_m"]) + Gf.Vec3d(0, 0, 0.006))
UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
UsdPhysics.MassAPI.Apply(ball.GetPrim()).CreateMassAttr(0.01)
stage.Save()

bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
kilograms = sum(UsdPhysics.MassAPI(body).GetMassAttr().Get() for body in bodies)
print(f"{len(bodies)} bodies, {1000 * kilograms:.2f} g")
