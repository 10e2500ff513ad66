"""Construction of a tree's solid in any kernel, from the kernel's own primitives and booleans."""

from __future__ import annotations

import math
from typing import Any, Generic, Protocol, TypeVar

Shape = TypeVar("Shape")

Profile = dict[str, Any]
Pose = dict[str, Any]


class Kernel(Protocol, Generic[Shape]):
    """Operations of a kernel. docs/tree.md defines the frames of primitives; lengths are in mm."""

    def sphere(self, radius_mm: float) -> Shape: ...
    def ellipsoid(self, semi_axes_mm: list[float]) -> Shape: ...
    def cylinder(self, radius_mm: float, height_mm: float) -> Shape: ...
    def cone(self, bottom_radius_mm: float, top_radius_mm: float, height_mm: float) -> Shape: ...
    def cuboid(self, size_mm: list[float]) -> Shape: ...
    def torus(self, ring_radius_mm: float, tube_radius_mm: float) -> Shape: ...
    def extrusion(self, profile: Profile, height_mm: float) -> Shape: ...
    def revolution(self, profile: Profile) -> Shape: ...
    def ellipsoid_offset(
        self, equatorial_mm: float, polar_mm: float, offset_mm: float
    ) -> Shape: ...

    def half_space(self, reach_mm: float) -> Shape:
        """Creates a solid below z = 0 that contains all its points within `reach_mm` of the origin."""
        ...

    def union(self, shapes: list[Shape]) -> Shape: ...
    def intersection(self, shapes: list[Shape]) -> Shape: ...
    def difference(self, shape: Shape, tools: list[Shape]) -> Shape: ...
    def placed(self, shape: Shape, pose: Pose) -> Shape: ...


def build(node: dict[str, Any], kernel: Kernel[Shape]) -> Shape:
    """Builds the solid of a tree, in the frame of its root."""
    return _Walk(kernel, 2.0 * reach_mm(node)).build(node, (0.0, 0.0, 0.0))


class _Walk(Generic[Shape]):
    def __init__(self, kernel: Kernel[Shape], reach: float):
        self.kernel, self.reach = kernel, reach

    def build(self, node: dict[str, Any], root: tuple[float, ...]) -> Shape:
        """Builds a node. `root` is the root's origin in this node's frame, mm."""
        ((kind, of),) = node.items()
        kernel = self.kernel
        match kind:
            case "union":
                return kernel.union([self.build(child, root) for child in of])
            case "intersection":
                return kernel.intersection([self.build(child, root) for child in of])
            case "difference":
                tools = [self.build(tool, root) for tool in of["minus"]]
                return kernel.difference(self.build(of["of"], root), tools)
            case "placed":
                inner = self.build(of["of"], _into(of["pose"], root))
                return kernel.placed(inner, of["pose"])
            case "feature":
                return self.build(of["of"], root)
            case "half-space":
                # Kernels have no infinite solids: this one is larger than anything that it can intersect.
                return kernel.half_space(self.reach + math.hypot(*root))
            case primitive:
                return getattr(kernel, primitive.replace("-", "_"))(**of)


def _into(pose: Pose, point: tuple[float, ...]) -> tuple[float, ...]:
    """Transforms a point from the outer frame to the inner one."""
    shifted = [p - t for p, t in zip(point, pose["translation_mm"])]
    rotation = pose["rotation"]
    return tuple(sum(rotation[row][axis] * shifted[row] for row in range(3)) for axis in range(3))


def reach_mm(node: dict[str, Any]) -> float:
    """Bounds the distance of all finite primitives of a tree from the origin of its root, mm."""
    ((kind, of),) = node.items()
    match kind:
        case "union" | "intersection":
            return max(map(reach_mm, of))
        case "difference":
            return max(map(reach_mm, [of["of"], *of["minus"]]))
        case "placed":
            return reach_mm(of["of"]) + math.hypot(*of["pose"]["translation_mm"])
        case "feature":
            return reach_mm(of["of"])
        case "half-space":
            return 0.0
        case "ellipsoid":
            return max(of["semi_axes_mm"])
        case "extrusion" | "revolution":
            return profile_reach_mm(of["profile"]) + of.get("height_mm", 0.0)
        case "ellipsoid-offset":
            return max(of["equatorial_mm"], of["polar_mm"]) + abs(of["offset_mm"])
        case "cuboid":
            return math.hypot(*of["size_mm"])
        case _:
            return sum(of.values())


def profile_reach_mm(profile: Profile) -> float:
    """Bounds the distance of a profile's points from the origin of its plane, mm."""
    path = profile["outer"]
    reach, here = math.hypot(*path["start"]), path["start"]
    for segment in path["segments"]:
        ((kind, how),) = segment.items()
        ends = max(math.hypot(*here), math.hypot(*how["to"]))
        if kind == "line":
            reach = max(reach, ends)
        elif kind == "arc":
            reach = max(reach, math.hypot(*how["centre"]) + math.dist(here, how["centre"]))
        else:
            reach = max(reach, math.hypot(*how["centre"]) + max(how["semi_axes_mm"]))
        here = how["to"]
    return reach
