"""Independent readers of robot files: OpenUSD, PyBullet, Drake, MuJoCo, TACTO's formulas, Isaac Lab's schemas.

Each ``*_reads`` function raises if its check fails; ``projections`` yields each target's own projection of points.
"""

import math
import xml.etree.ElementTree as ET

import jsonschema
import meshio
import mujoco
import numpy as np
import pybullet
import yaml
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdValidation
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo
from scipy.spatial.transform import Rotation

NUMBER = {"type": "number"}
SIZE = {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 2, "maxItems": 2}
DIMENSIONS = {
    "type": "object",
    "properties": dict.fromkeys(["width", "length", "height"], NUMBER),
    "required": ["width", "length", "height"],
    "additionalProperties": False,
}


def fields(required=(), **properties):
    """Returns the JSON Schema of an object with these properties and no others."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
    }


# Fields of the classes that read these files, as their sources document them.
TACSL = fields(
    ["prim_path", "tactile_array_size", "tactile_margin"],
    prim_path={"type": "string"},
    enable_camera_tactile={"type": "boolean"},
    enable_force_field={"type": "boolean"},
    tactile_array_size=SIZE,
    tactile_margin=NUMBER,
    normal_contact_stiffness={"type": "number", "exclusiveMinimum": 0},
    tangential_stiffness={"type": "number", "exclusiveMinimum": 0},
    friction_coefficient={"type": "number", "minimum": 0},
    render_cfg=fields(
        ["sensor_data_dir_name", "image_height", "image_width", "mm_per_pixel"],
        base_data_path={"type": "string"},
        sensor_data_dir_name={"type": "string"},
        image_height={"type": "integer"},
        image_width={"type": "integer"},
        num_bins={"type": "integer"},
        mm_per_pixel=NUMBER,
    ),
    camera_cfg=fields(
        ["prim_path", "height", "width", "data_types"],
        prim_path={"type": "string"},
        spawn={"type": "null"},
        height={"type": "integer"},
        width={"type": "integer"},
        data_types={"type": "array", "items": {"enum": ["distance_to_image_plane"]}},
    ),
)
TACEX = fields(
    ["prim_path", "case_dimensions", "gelpad_dimensions", "sensor_camera_cfg", "data_types"],
    prim_path={"type": "string"},
    case_dimensions=DIMENSIONS,
    gelpad_dimensions=DIMENSIONS,
    sensor_camera_cfg=fields(
        prim_path_appendix={"type": "string"},
        update_period=NUMBER,
        resolution=SIZE,
        data_types={"type": "array", "items": {"enum": ["depth"]}},
        clipping_range={"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2},
    ),
    data_types={
        "type": "array",
        "items": {"enum": ["tactile_rgb", "marker_motion", "height_map", "camera_depth", "camera_rgb"]},
    },
    compute_indentation_depth_class={"enum": ["optical_sim", "marker_motion_sim"]},
    optical_sim_cfg={
        "anyOf": [
            {"type": "null"},
            fields(
                ["gelpad_height", "gelpad_to_camera_min_distance"],
                calib_folder_path={"type": "string"},
                gelpad_height=NUMBER,
                gelpad_to_camera_min_distance=NUMBER,
                with_shadow={"type": "boolean"},
                tactile_img_res=SIZE,
            ),
        ]
    },
)


def usd_reads(path, document):
    """Opens a file with OpenUSD, runs all its validators, and checks masses, collision shapes and tetrahedra."""
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert any(v.GetMetadata().name.startswith("usdPhysics") for v in validators)
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert not errors, [error.GetMessage() for error in errors]
    assert UsdGeom.GetStageMetersPerUnit(stage) == UsdPhysics.GetStageKilogramsPerUnit(stage) == 1
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    root = stage.GetDefaultPrim()
    for link in document["links"]:
        prim = root.GetChild(link["name"].replace("-", "_"))
        assert prim.HasAPI(UsdPhysics.RigidBodyAPI) and prim.HasAPI(UsdPhysics.MassAPI), link
        mass = UsdPhysics.MassAPI(prim)
        np.testing.assert_allclose(mass.GetMassAttr().Get(), link["mass_kg"], rtol=1e-6)
        np.testing.assert_allclose(mass.GetCenterOfMassAttr().Get(), link["centre_m"], atol=1e-8)
        axes = mass.GetPrincipalAxesAttr().Get()
        turn = Rotation.from_quat([*axes.GetImaginary(), axes.GetReal()]).as_matrix()
        inertia = turn @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ turn.T
        tensor = np.array(link["inertia_kg_m2"])
        np.testing.assert_allclose(inertia, tensor, atol=1e-6 * tensor.max())
    shapes = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)]
    assert len(shapes) == document["collision"]["pieces"] + bool(document["taxels"])
    welds = [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.FixedJoint)]
    assert len(welds) == len(document["links"]) - 1
    if document["taxels"]:
        touch = next(prim for prim in shapes if prim.GetName() == "touch")
        points = np.array(touch.GetAttribute("tet_points").Get())
        cells = np.array(touch.GetAttribute("tet_indices").Get()).reshape(-1, 4)
        volumes_positive(points, cells)
        surface = np.array(touch.GetAttribute("tet_surf_points").Get())
        faces = np.array(touch.GetAttribute("tet_surf_indices").Get()).reshape(-1, 3)
        # The volume that the surface encloses is that of all tetrahedra.
        a, b, c = (surface[faces[:, k]].astype(float) for k in range(3))
        enclosed = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        np.testing.assert_allclose(enclosed, volumes_positive(points, cells), rtol=1e-4)


def volumes_positive(points, cells):
    """Checks that all tetrahedra have a positive volume; returns the sum."""
    a, b, c, d = (np.asarray(points, dtype=float)[cells[:, k]] for k in range(4))
    volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6
    assert volumes.min() > 0
    return volumes.sum()


def tetrahedra_read(folder, document):
    """Checks that both tetrahedra files contain the same nodes, in metres, and the same sets."""
    vtk = meshio.read(folder / "robot-tetrahedra.vtk")
    msh = meshio.read(folder / "robot-tetrahedra.msh")
    np.testing.assert_array_equal(vtk.points, msh.points)
    cells = vtk.cells_dict["tetra"]
    assert len(cells) == document["soft"]["tetrahedra"] == len(msh.cells_dict["tetra"])
    assert len(vtk.points) == document["soft"]["nodes"]
    volumes_positive(vtk.points, cells)
    assert {name for name, (_, dim) in msh.field_data.items() if dim == 2} == {"outer", "bonded"}
    nodes = np.unique(msh.cells_dict["triangle"][msh.cell_data_dict["gmsh:physical"]["triangle"] == 1])
    np.testing.assert_array_equal(nodes, np.flatnonzero(vtk.point_data["outer"]))


def bullet_reads(path, document):
    """Checks total mass and number of collision shapes in PyBullet, with a free base."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        robot = pybullet.loadURDF(str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        links = range(-1, pybullet.getNumJoints(robot))
        masses = [pybullet.getDynamicsInfo(robot, link)[0] for link in links]
        np.testing.assert_allclose(sum(masses), document["mass_kg"], rtol=1e-6)
        pybullet.stepSimulation()
        shapes = sum(len(pybullet.getCollisionShapeData(robot, link)) for link in links)
        assert shapes == path.read_text().count("<collision"), shapes
    finally:
        pybullet.disconnect(client)


def drake_reads(path, document):
    """Checks that Drake's strict parser accepts a file, with mass and frames; returns the number of geometries."""
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=1e-3, contact_model="hydroelastic")
    plant, scene = AddMultibodyPlant(config, builder)
    parser = Parser(plant)
    parser.SetStrictParsing()
    (model,) = parser.AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base", model))
    plant.Finalize()
    builder.Build()
    context = plant.CreateDefaultContext()
    np.testing.assert_allclose(plant.CalcTotalMass(context), document["mass_kg"], rtol=1e-6)
    for frame in document["frames"]:
        pose = plant.GetFrameByName(frame["name"], model).CalcPoseInWorld(context)
        np.testing.assert_allclose(pose.translation(), frame["place_m"], atol=1e-9)
        np.testing.assert_allclose(pose.rotation().matrix(), frame["rotation"], atol=1e-7)
    return scene.model_inspector().num_geometries()


def schemas_hold(folder, sensor, document):
    """Validates the files for Isaac Lab's classes, and checks that the USD file has the prims that they name."""
    stage = Usd.Stage.Open(str(folder / f"{sensor}.usda"))
    for name, schema in [("tacsl", TACSL), ("tacex", TACEX)]:
        path = folder / f"{sensor}.{name}.yaml"
        if not document["taxels"]:
            assert not path.exists()
            continue
        said = yaml.safe_load(path.read_text())
        jsonschema.validate(said, schema)
        named = [said["prim_path"]]
        named += [said["camera_cfg"]["prim_path"]] if name == "tacsl" else []
        named += [said["prim_path"] + "/camera"] if name == "tacex" else []
        for prim in named:
            assert stage.GetPrimAtPath(prim.replace("{ENV_REGEX_NS}", "")), prim


def projections(folder, sensor, document):
    """Yields each target's name and projection of points in the sensor frame, m, to pixels; (0, 0) is the first
    pixel's centre."""
    pinhole = document["camera"]["pinhole"]
    size = np.array([pinhole["width_px"], pinhole["height_px"]])
    yield "mujoco", mujoco_camera(folder / f"{sensor}.mjcf.xml", size)
    yield "usd", usd_camera(folder / f"{sensor}.usda", size)
    yield "sdf", sdf_camera(folder / f"{sensor}.sdf", size)
    frame = next(f for f in document["frames"] if f["name"] == document["camera"]["frame"])
    yield "drake", drake_camera(frame, pinhole)
    path = folder / f"{sensor}.tacto.yaml"
    if path.exists():
        yield "tacto", tacto_camera(path, size)


def seen(points, place, axes, focal, size):
    """Projects points by a pinhole; `axes` are right, down, forward as rows, the focal length is in px."""
    local = (points - place) @ np.transpose(axes)
    return focal * local[:, :2] / local[:, 2:] + (size - 1) / 2


def mujoco_camera(path, size):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_array_equal(model.cam_resolution[0], size)
    focal = size[1] / 2 / math.tan(math.radians(model.cam_fovy[0]) / 2)
    right, up, back = data.cam_xmat[0].reshape(3, 3).T
    return lambda points: seen(points, data.cam_xpos[0], [right, -up, -back], focal, size)


def usd_camera(path, size):
    stage = Usd.Stage.Open(str(path))
    prim = stage.GetDefaultPrim().GetChild("base").GetChild("camera")
    frustum = UsdGeom.Camera(prim).GetCamera(Usd.TimeCode.Default()).frustum
    matrix = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()

    def project(points):
        clip = np.array([matrix.Transform(Gf.Vec3d(*point)) for point in points])
        # Clip coordinates run from -1 to 1 over the whole image, with y upwards.
        return (clip[:, :2] * [1, -1] + 1) / 2 * size - 0.5

    return project


def sdf_camera(path, size):
    """Returns Gazebo's projection: it looks along x with z up, and its field of view is horizontal."""
    root = ET.parse(path).getroot()
    sensor = root.find(".//sensor")
    image = sensor.find("camera/image")
    np.testing.assert_array_equal([int(image.find(k).text) for k in ("width", "height")], size)
    focal = size[0] / 2 / math.tan(float(sensor.find("camera/horizontal_fov").text) / 2)
    named = sensor.find("pose").get("relative_to")
    frame = next(f for f in root.iter("frame") if f.get("name") == named)
    outer, inner = (np.array(p.text.split(), dtype=float) for p in (frame.find("pose"), sensor.find("pose")))
    turn = Rotation.from_euler("xyz", outer[3:])
    place = outer[:3] + turn.apply(inner[:3])
    forward, left, up = (turn * Rotation.from_euler("xyz", inner[3:])).as_matrix().T
    return lambda points: seen(points, place, [-left, -up, forward], focal, size)


def drake_camera(frame, pinhole):
    middle = pinhole["middle_px"]
    info = CameraInfo(
        width=pinhole["width_px"],
        height=pinhole["height_px"],
        focal_x=pinhole["focal_px"],
        focal_y=pinhole["focal_px"],
        # In Drake, (0, 0) is the first pixel's corner.
        center_x=middle[0] + 0.5,
        center_y=middle[1] + 0.5,
    )

    def project(points):
        local = (points - frame["place_m"]) @ np.array(frame["rotation"])
        uv = local @ info.intrinsic_matrix().T
        return uv[:, :2] / uv[:, 2:] - 0.5

    return project


def tacto_camera(path, size):
    """Returns TACTO's projection, as it passes it to pyrender: rotations about fixed axes, looking along -z, y up."""
    said = yaml.safe_load(path.read_text())["sensor"]["camera"][0]
    focal = size[1] / 2 / math.tan(math.radians(said["yfov"]) / 2)
    right, up, back = Rotation.from_euler("xyz", said["orientation"], degrees=True).as_matrix().T
    return lambda points: seen(points, said["position"], [right, -up, -back], focal, size)
