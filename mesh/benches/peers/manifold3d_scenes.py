"""The two scenes of mesh/benches/scenes built with manifold3d, as a Python user would.

Reads scene names from stdin, one per line; answers each with seconds, volume and triangle count on
one line. Seconds cover building the part and turning it into the bytes of a binary STL.

Needs: pip install manifold3d numpy
"""

import math
import sys
import time

import manifold3d
import numpy as np
from manifold3d import CrossSection, Manifold, OpType

TOLERANCE_MM = 0.01


def count(radius, tolerance):
    """Segments of a full turn that keep the sagitta within the tolerance, a multiple of 4."""
    return max(8, 4 * math.ceil(math.pi / math.acos(1.0 - tolerance / radius) / 4.0))


def arc(centre_y, radius, start, end, tolerance):
    """Points of an arc about (0, centre_y), both ends included."""
    steps = max(1, math.ceil(count(radius, tolerance) * abs(end - start) / (2.0 * math.pi)))
    angles = [start + (end - start) * k / steps for k in range(steps + 1)]
    return [(radius * math.cos(a), centre_y + radius * math.sin(a)) for a in angles]


def revolved(points, radius, tolerance):
    return Manifold.revolve(CrossSection([points]), count(radius, tolerance))


def fibonacci(number, z_from, z_to):
    golden_angle = math.pi * (3.0 - math.sqrt(5.0))
    for k in range(number):
        z = z_from + (z_to - z_from) * (k + 0.5) / number
        across = math.sqrt(1.0 - z * z)
        yield np.array([across * math.cos(k * golden_angle), across * math.sin(k * golden_angle), z])


def along(axis, point):
    """The 3 x 4 matrix that carries z at the origin to an axis at a point."""
    x = np.cross([0.0, 1.0, 0.0], axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis, point])


def dimpled_mold():
    # What bends both ways strays both ways: each gets half of the tolerance.
    half = TOLERANCE_MM / 2.0
    radius, reach, root = 0.225, 0.5, 0.3
    cap_radius, cap_height, over = 17.5, 8.0, 0.1
    sphere = (cap_radius**2 + cap_height**2) / (2.0 * cap_height)
    centre_z = cap_height - sphere
    edge = math.asin(-centre_z / sphere)
    outline = [(0.0, -over), (cap_radius, -over)]
    outline += arc(centre_z, sphere, edge, math.pi / 2.0, half)
    cap = revolved(outline, sphere, half)
    shaft = root + reach - radius
    outline = [(0.0, 0.0), (radius, 0.0)] + arc(shaft, radius, 0.0, math.pi / 2.0, half)
    dimple = revolved(outline, radius, half)
    centre = np.array([0.0, 0.0, centre_z])
    dimples = [
        dimple.transform(along(axis, centre + axis * (sphere - root)))
        for axis in fibonacci(200, math.cos(math.radians(46.0)), 1.0)
    ]
    tools = Manifold.batch_boolean([cap, *dimples], OpType.Add)
    return Manifold.cube([45.0, 45.0, 14.0]).translate([-22.5, -22.5, 0.0]) - tools


def perforated_dome():
    half = TOLERANCE_MM / 2.0
    outline = arc(0.0, 18.0, 0.0, math.pi / 2.0, half) + arc(0.0, 15.0, math.pi / 2.0, 0.0, half)
    shell = revolved(outline, 18.0, half)
    hole = Manifold.cylinder(5.0, 0.5, circular_segments=count(0.5, TOLERANCE_MM))
    holes = [hole.transform(along(axis, axis * 14.0)) for axis in fibonacci(100, 0.1, 1.0)]
    return shell - Manifold.batch_boolean(holes, OpType.Add)


def binary_stl(solid):
    mesh = solid.to_mesh()
    corners = mesh.vert_properties[:, :3][mesh.tri_verts]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.zeros(len(corners), record)
    records["normal"], records["corners"] = normals, corners
    return bytes(80) + np.uint32(len(corners)).tobytes() + records.tobytes()


SCENES = {"dimpled mold": dimpled_mold, "perforated dome": perforated_dome}


def main():
    for line in sys.stdin:
        start = time.perf_counter()
        solid = SCENES[line.strip()]()
        content = binary_stl(solid)
        seconds = time.perf_counter() - start
        assert len(content) == 84 + 50 * solid.num_tri()
        print(seconds, solid.volume(), solid.num_tri(), flush=True)


if __name__ == "__main__":
    main()
