"""Primitives of docs/tree.md and their crossings with lines, each in its own frame, mm."""

from __future__ import annotations

from typing import Any

import numpy as np

from .offsets import Ellipse
from .profiles import Outline, Turned
from .roots import Array, quadratic, quartic


class Primitive:
    """A solid: candidate crossings with lines, and a test of what is inside.

    `places` may contain false crossings too; `inside` decides for the stretch between two of them.
    """

    bounds: Array

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        """Returns candidate crossings as lengths along unit rays, (rays, k), NaN for none, and their faces, (k,)."""
        raise NotImplementedError

    def inside(self, p: Array) -> Array:
        """Returns for points (..., 3) whether they are inside."""
        raise NotImplementedError

    def normal(self, p: Array, face: Array) -> Array:
        """Returns unit normals, of arbitrary sign, at points (n, 3) on faces (n,)."""
        raise NotImplementedError


def _box(low: list[float], high: list[float]) -> Array:
    return np.array([low, high])


def _unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


class Ellipsoid(Primitive):
    """An ellipsoid or a ball."""

    def __init__(self, semi_axes_mm: list[float]):
        self.axes = np.array(semi_axes_mm)
        self.bounds = np.stack([-self.axes, self.axes])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        o, d = o / self.axes, d / self.axes
        a = (d * d).sum(-1)
        # Measure lengths from the foot of the perpendicular, to avoid cancellation.
        foot = -(o * d).sum(-1) / a
        near = o + foot[:, None] * d
        t = quadratic(a, np.zeros_like(a), (near * near).sum(-1) - 1.0)
        return t + foot[:, None], np.zeros(2, int)

    def inside(self, p: Array) -> Array:
        p = p / self.axes
        return (p * p).sum(-1) < 1.0

    def normal(self, p: Array, face: Array) -> Array:
        return _unit(p / self.axes**2)


class Cone(Primitive):
    """A cone, truncated cone or cylinder."""

    def __init__(self, bottom_radius_mm: float, top_radius_mm: float, height_mm: float):
        self.radius, self.height = bottom_radius_mm, height_mm
        self.slope = (top_radius_mm - bottom_radius_mm) / height_mm
        wide = max(bottom_radius_mm, top_radius_mm)
        self.bounds = _box([-wide, -wide, 0.0], [wide, wide, height_mm])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        reach, grows = self.radius + self.slope * o[:, 2], self.slope * d[:, 2]
        a = d[:, 0] ** 2 + d[:, 1] ** 2 - grows**2
        b = o[:, 0] * d[:, 0] + o[:, 1] * d[:, 1] - reach * grows
        c = o[:, 0] ** 2 + o[:, 1] ** 2 - reach**2
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([-o[:, 2] / d[:, 2], (self.height - o[:, 2]) / d[:, 2]], axis=-1)
        return np.concatenate([quadratic(a, b, c), ends], axis=-1), np.array([0, 0, 1, 2])

    def inside(self, p: Array) -> Array:
        x, y, z = np.moveaxis(p, -1, 0)
        return (z > 0.0) & (z < self.height) & (np.hypot(x, y) < self.radius + self.slope * z)

    def normal(self, p: Array, face: Array) -> Array:
        out = np.hypot(p[:, 0], p[:, 1])
        side = np.stack([p[:, 0], p[:, 1], -self.slope * out], axis=-1)
        return _unit(np.where((face == 0)[:, None], side, [0.0, 0.0, 1.0]))


class Cuboid(Primitive):
    def __init__(self, size_mm: list[float]):
        x, y, z = size_mm
        self.bounds = _box([-x / 2, -y / 2, 0.0], [x / 2, y / 2, z])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.concatenate([(self.bounds[0] - o) / d, (self.bounds[1] - o) / d], axis=-1)
        return t, np.array([0, 1, 2, 0, 1, 2])

    def inside(self, p: Array) -> Array:
        return ((p > self.bounds[0]) & (p < self.bounds[1])).all(-1)

    def normal(self, p: Array, face: Array) -> Array:
        return np.eye(3)[face]


class HalfSpace(Primitive):
    """The half space z <= 0. Its spans have no ends: see `solids.py`."""

    bounds = _box([-np.inf] * 3, [np.inf, np.inf, 0.0])

    def inside(self, p: Array) -> Array:
        return p[..., 2] < 0.0

    def normal(self, p: Array, face: Array) -> Array:
        return np.broadcast_to([0.0, 0.0, 1.0], p.shape)


class Torus(Primitive):
    def __init__(self, ring_radius_mm: float, tube_radius_mm: float):
        self.ring, self.tube = ring_radius_mm, tube_radius_mm
        wide = ring_radius_mm + tube_radius_mm
        self.bounds = _box([-wide, -wide, -tube_radius_mm], [wide, wide, tube_radius_mm])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        return turned_ellipse(o, d, [self.ring, 0.0], [self.tube] * 2), np.zeros(4, int)

    def inside(self, p: Array) -> Array:
        out = np.hypot(p[..., 0], p[..., 1]) - self.ring
        return np.hypot(out, p[..., 2]) < self.tube

    def normal(self, p: Array, face: Array) -> Array:
        out = np.hypot(p[:, 0], p[:, 1])
        middle = p * [1.0, 1.0, 0.0] * (self.ring / out)[:, None]
        return _unit(p - middle)


def turned_ellipse(o: Array, d: Array, centre: list[float], axes: list[float]) -> Array:
    """Computes candidate crossings with an ellipse in the half plane (distance from z, z) that is revolved around z.

    With u the distance from z and q = u^2 + c^2 - a^2 + (a/b)^2 (z - h)^2, the surface is q = 2 c u. Squaring both
    sides gives a quartic polynomial without square roots.
    """
    (c, h), (a, b) = centre, axes
    k = (a / b) ** 2
    # Measure lengths from the point nearest to the middle, to keep them small.
    middle = np.array([0.0, 0.0, h])
    foot = -((o - middle) * d).sum(-1)
    p = o + foot[:, None] * d
    z = p[:, 2] - h
    across = np.stack([d[:, 0] ** 2 + d[:, 1] ** 2, p[:, 0] * d[:, 0] + p[:, 1] * d[:, 1],
                       p[:, 0] ** 2 + p[:, 1] ** 2])
    q2 = across[0] + k * d[:, 2] ** 2
    q1 = across[1] + k * z * d[:, 2]
    q0 = across[2] + k * z * z + c * c - a * a
    if c == 0.0:
        return quadratic(q2, q1, q0) + foot[:, None]
    coefficients = [q2 * q2, 4.0 * q2 * q1, 2.0 * q2 * q0 + 4.0 * q1 * q1, 4.0 * q1 * q0, q0 * q0]
    for power, term in enumerate([across[0], 2.0 * across[1], across[2]]):
        coefficients[2 + power] = coefficients[2 + power] - 4.0 * c * c * term
    return quartic(np.stack(coefficients, axis=-1)) + foot[:, None]


class Extrusion(Primitive):
    """An extruded profile. Faces 0 and 1 are its ends, then one for each segment."""

    def __init__(self, profile: dict[str, Any], height_mm: float):
        self.outline, self.height = Outline(profile), height_mm
        low, high = self.outline.bounds
        self.bounds = _box([*low, 0.0], [*high, height_mm])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([-o[:, 2] / d[:, 2], (self.height - o[:, 2]) / d[:, 2]], axis=-1)
        sides, faces = self.outline.crossings(o[:, :2], d[:, :2])
        return np.concatenate([ends, sides], axis=-1), np.concatenate([[0, 1], faces + 2])

    def inside(self, p: Array) -> Array:
        z = p[..., 2]
        return (z > 0.0) & (z < self.height) & self.outline.inside(p[..., :2])

    def normal(self, p: Array, face: Array) -> Array:
        flat = np.concatenate([self.outline.normal(p[:, :2], face - 2), np.zeros((len(p), 1))], -1)
        return _unit(np.where((face < 2)[:, None], [0.0, 0.0, 1.0], flat))


class Revolution(Primitive):
    """A revolved profile, with a face for each segment."""

    def __init__(self, profile: dict[str, Any]):
        self.outline = Outline(profile)
        self.turned = Turned(self.outline, turned_ellipse)
        (_, low), (wide, high) = self.outline.bounds
        self.bounds = _box([-wide, -wide, low], [wide, wide, high])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        return self.turned.crossings(o, d)

    def inside(self, p: Array) -> Array:
        flat = np.stack([np.hypot(p[..., 0], p[..., 1]), p[..., 2]], axis=-1)
        return self.outline.inside(flat)

    def normal(self, p: Array, face: Array) -> Array:
        out = np.hypot(p[:, 0], p[:, 1])
        n = self.outline.normal(np.stack([out, p[:, 2]], axis=-1), face)
        share = n[:, :1] / np.maximum(out, 1e-300)[:, None]
        return _unit(np.concatenate([p[:, :2] * share, n[:, 1:]], axis=-1))


class EllipsoidOffset(Primitive):
    """The solid within a signed distance of an ellipsoid of revolution. It is convex."""

    def __init__(self, equatorial_mm: float, polar_mm: float, offset_mm: float):
        self.ellipse, self.offset = Ellipse(equatorial_mm, polar_mm), offset_mm
        wide, high = equatorial_mm + offset_mm, polar_mm + offset_mm
        self.bounds = _box([-wide, -wide, -high], [wide, wide, high])

    def places(self, o: Array, d: Array) -> tuple[Array, Array]:
        return self.ellipse.crossings(o, d, self.offset), np.zeros(2, int)

    def inside(self, p: Array) -> Array:
        return self.ellipse.distance(p)[0] < self.offset

    def normal(self, p: Array, face: Array) -> Array:
        return self.ellipse.distance(p)[1]


def primitive(kind: str, of: dict[str, Any]) -> Primitive:
    """Creates a primitive of a tree by its kind."""
    match kind:
        case "sphere":
            return Ellipsoid([of["radius_mm"]] * 3)
        case "ellipsoid":
            return Ellipsoid(**of)
        case "cylinder":
            return Cone(of["radius_mm"], of["radius_mm"], of["height_mm"])
        case "cone":
            return Cone(**of)
        case "cuboid":
            return Cuboid(**of)
        case "torus":
            return Torus(**of)
        case "half-space":
            return HalfSpace()
        case "extrusion":
            return Extrusion(**of)
        case "revolution":
            return Revolution(**of)
        case "ellipsoid-offset":
            return EllipsoidOffset(**of)
    raise ValueError(f"unknown kind of node: {kind}")
