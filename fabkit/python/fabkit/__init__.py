"""Parts, molds, calibration and ground truth of vision-based tactile sensors.

:func:`load` reads a sensor; its attributes and methods give everything else. Computations run in
the compiled library, so results are the same bytes as those of the ``fabkit`` command.

Lengths are in mm and angles in rad, unless a name says otherwise; values with a unit of their own
are written as on the command line, ``"12.5 mm"`` or ``"160 deg"``. Frames are right-handed. The
sensor frame has its origin at the centre of the sensing surface's base circle and +z toward the
tip; the camera frame is OpenCV's, +z forward, +x right, +y down. A pose is named ``to_from``:
``sensor_from_camera`` maps points in the camera frame to the sensor frame, and is a (4, 4) matrix.

>>> import fabkit
>>> sensor = fabkit.load("rtac0", coat__thickness="0.1 mm")
>>> mesh = sensor.parts["shell"].mesh(tolerance_mm=0.05)
>>> mesh.vertices.dtype, mesh.triangles.dtype
(dtype('float64'), dtype('uint32'))
"""

from fabkit import calibrate, dataset, depth, sweep
from fabkit._fabkit import __version__
from fabkit.bodies import Body
from fabkit.cameras import Camera
from fabkit.checking import CheckReport, Finding
from fabkit.designs import (
    Change,
    Design,
    Fixture,
    Parameter,
    Section,
    Sensor,
    Step,
    check,
    export,
    load,
    sensors,
)
from fabkit.errors import DesignWarning, FabkitError, InvalidInputError, Problem, UnknownNameError
from fabkit.meshes import Mesh
from fabkit.pressing import Pressed, press

__all__ = [
    "Body",
    "Camera",
    "Change",
    "CheckReport",
    "Design",
    "DesignWarning",
    "FabkitError",
    "Finding",
    "Fixture",
    "InvalidInputError",
    "Mesh",
    "Parameter",
    "Pressed",
    "Problem",
    "Section",
    "Sensor",
    "Step",
    "UnknownNameError",
    "__version__",
    "calibrate",
    "check",
    "dataset",
    "depth",
    "export",
    "load",
    "press",
    "sensors",
    "sweep",
]


def __dir__() -> list[str]:
    return __all__
