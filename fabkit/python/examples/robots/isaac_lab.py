"""A sensor of Isaac Lab (TacSL, TacEx) from the files beside the USD file.

    fabkit export digit-like --robot usd -o robot
    cd robot && fabkit optics-pack digit-like --camera robot-camera.yaml -o optics

In Isaac Lab's own interpreter, which needs a GPU:

    from isaac_lab import tacsl, tacex
    sensor = tacsl("robot")      # isaaclab_contrib.sensors.tacsl_sensor.VisuoTactileSensorCfg
    sensor = tacex("robot")      # tacex.GelSightSensorCfg

Nothing here is tried in fabkit's tests but that the files have these classes' fields and name what is in the USD file.
"""

from pathlib import Path

import yaml


def read(folder, end):
    (path,) = Path(folder).glob(f"*.{end}.yaml")
    return yaml.safe_load(path.read_text())


def tacsl(folder):
    from isaaclab.sensors import TiledCameraCfg
    from isaaclab_contrib.sensors.tacsl_sensor import GelSightRenderCfg, VisuoTactileSensorCfg

    said = read(folder, "tacsl")
    camera = TiledCameraCfg(**said.pop("camera_cfg"))
    render = said.pop("render_cfg", None)
    if render is not None:
        render["base_data_path"] = str(Path(folder, render["base_data_path"]).resolve())
        said["render_cfg"] = GelSightRenderCfg(**render)
    return VisuoTactileSensorCfg(camera_cfg=camera, **said)


def tacex(folder):
    from tacex import GelSightSensorCfg
    from tacex.simulation_approaches.gpu_taxim import TaximSimulatorCfg

    said = read(folder, "tacex")
    taxim = said.pop("optical_sim_cfg")
    sensor = GelSightSensorCfg()
    sensor.from_dict(said)
    if taxim is not None:
        taxim["calib_folder_path"] = str(Path(folder, taxim["calib_folder_path"]).resolve())
        sensor.optical_sim_cfg = TaximSimulatorCfg(**taxim)
    return sensor
