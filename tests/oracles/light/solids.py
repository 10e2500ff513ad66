"""Solids as trees of primitives, and the stretches of straight lines inside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .primitives import HalfSpace, Primitive, primitive
from .roots import Array

Indices = NDArray[np.int64]

# Crossings nearer to each other than this along a line are one, mm.
ONE_PLACE_MM = 1e-10
# A face's code is the number of its leaf times this, plus its number there.
FACES = 1 << 16


@dataclass
class Rays:
    """Lines in the sensor frame, mm; directions are unit."""

    o: Array
    d: Array

    def __len__(self) -> int:
        return len(self.o)

    def at(self, which: NDArray[Any]) -> Rays:
        return Rays(self.o[which], self.d[which])


@dataclass
class Spans:
    """Stretches of rays inside a solid: number of the ray, both distances, and the codes of both faces."""

    ray: Indices
    low: Array
    high: Array
    face_low: Indices
    face_high: Indices

    def __len__(self) -> int:
        return len(self.ray)

    @staticmethod
    def none() -> Spans:
        e, f = np.zeros(0, np.int64), np.zeros(0)
        return Spans(e, f, f, e, e)

    def of_rays(self, numbers: Indices) -> Spans:
        """Returns the stretches with the rays' numbers in the caller's list."""
        return Spans(numbers[self.ray], self.low, self.high, self.face_low, self.face_high)


def combine(parts: list[tuple[Spans, int]], least: int) -> Spans:
    """Combines stretches: a point is inside if the weights of the parts that contain it sum up to `least` or more.

    `least` is above 0. Union, intersection and difference are special cases.
    """
    ray = np.concatenate([s.ray for s, _ in parts for _ in range(2)])
    t = np.concatenate([x for s, _ in parts for x in (s.low, s.high)])
    face = np.concatenate([x for s, _ in parts for x in (s.face_low, s.face_high)])
    step = np.concatenate([np.full(len(s), sign * w) for s, w in parts for sign in (1, -1)])
    # At equal distances begins come before ends, so that touching stretches merge.
    order = np.lexsort((-step, t, ray))
    ray, t, face, step = ray[order], t[order], face[order], step[order]
    # Every stretch that begins also ends, so the cumulative sum is 0 at the start of each ray.
    count = np.cumsum(step)
    is_in, was_in = count >= least, count - step >= least
    low, high = np.flatnonzero(is_in & ~was_in), np.flatnonzero(was_in & ~is_in)
    keep = t[high] - t[low] > 0.0
    low, high = low[keep], high[keep]
    return Spans(ray[low], t[low], t[high], face[low], face[high])


class Node:
    """A solid in the sensor frame with a bounding box."""

    box: Array

    def spans(self, rays: Rays) -> Spans:
        """Returns the stretches of whole lines inside the solid; a ray's number is its index in `rays`."""
        at = np.flatnonzero(crosses(self.box, rays))
        return self.near(rays.at(at)).of_rays(at) if len(at) else Spans.none()

    def near(self, rays: Rays) -> Spans:
        raise NotImplementedError


def crosses(box: Array, rays: Rays) -> NDArray[np.bool_]:
    """Returns for each ray whether it passes through a box ahead of its origin."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (box[0] - 1e-6 - rays.o) / rays.d, (box[1] + 1e-6 - rays.o) / rays.d
    enter, leave = np.fmin(a, b).max(-1), np.fmax(a, b).min(-1)
    return (enter <= leave) & (leave >= 0.0)


class Leaf(Node):
    def __init__(self, of: Primitive, number: int, rotation: Array, shift: Array):
        self.of, self.number, self.rotation, self.shift = of, number, rotation, shift
        low, high = of.bounds
        if isinstance(of, HalfSpace):
            self.box = np.array([[-np.inf] * 3, [np.inf] * 3])
        else:
            corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                                for z in (low[2], high[2])])
            placed = corners @ rotation.T + shift
            self.box = np.stack([placed.min(0), placed.max(0)])

    def near(self, rays: Rays) -> Spans:
        o, d = (rays.o - self.shift) @ self.rotation, rays.d @ self.rotation
        if isinstance(self.of, HalfSpace):
            return self._endless(o, d)
        t, faces = self.of.places(o, d)
        t = np.where(np.isfinite(t), t, np.inf)
        order = np.argsort(t, axis=1)
        t = np.take_along_axis(t, order, 1)
        with np.errstate(invalid="ignore"):
            gap = np.diff(t, axis=1)
            middle = t[:, :-1] + 0.5 * gap
        real = np.isfinite(middle) & (gap > ONE_PLACE_MM)
        inside = np.zeros_like(real)
        row, column = np.nonzero(real)
        points = o[row] + middle[row, column][:, None] * d[row]
        inside[row, column] = self.of.inside(points)
        # Between two crossings that are one, the state does not change.
        for k in range(1, inside.shape[1]):
            same = ~real[:, k] & np.isfinite(t[:, k + 1])
            inside[same, k] = inside[same, k - 1]
        padded = np.pad(inside, ((0, 0), (1, 1)))
        row, low = np.nonzero(padded[:, 1:] & ~padded[:, :-1])
        _, high = np.nonzero(padded[:, :-1] & ~padded[:, 1:])
        code = faces[order] + FACES * self.number
        return Spans(row, t[row, low], t[row, high], code[row, low], code[row, high])

    def _endless(self, o: Array, d: Array) -> Spans:
        with np.errstate(divide="ignore"):
            t = -o[:, 2] / d[:, 2]
        level, falls = d[:, 2] == 0.0, d[:, 2] < 0.0
        low = np.where(level | ~falls, -np.inf, t)
        high = np.where(level | falls, np.inf, t)
        at = np.flatnonzero(~level | (o[:, 2] < 0.0))
        code = np.full(len(at), FACES * self.number)
        return Spans(at, low[at], high[at], code, code)

    def normal(self, p: Array, face: Indices) -> Array:
        """Returns unit normals at points of the sensor frame; the sign is arbitrary."""
        return self.of.normal((p - self.shift) @ self.rotation, face) @ self.rotation.T


class Union(Node):
    def __init__(self, nodes: list[Node]):
        self.nodes = nodes
        boxes = np.array([node.box for node in nodes])
        self.box = np.stack([boxes[:, 0].min(0), boxes[:, 1].max(0)])

    def near(self, rays: Rays) -> Spans:
        found = [spans for node in self.nodes if len(spans := node.spans(rays))]
        return combine([(spans, 1) for spans in found], 1) if found else Spans.none()


class Intersection(Node):
    def __init__(self, nodes: list[Node]):
        self.nodes = nodes
        boxes = np.array([node.box for node in nodes])
        self.box = np.stack([boxes[:, 0].max(0), boxes[:, 1].min(0)])

    def near(self, rays: Rays) -> Spans:
        found = [node.spans(rays) for node in self.nodes]
        return combine([(spans, 1) for spans in found], len(found))


class Difference(Node):
    def __init__(self, of: Node, minus: list[Node]):
        self.of, self.minus = of, Union(minus)
        self.box = of.box

    def near(self, rays: Rays) -> Spans:
        spans = self.of.spans(rays)
        at = np.unique(spans.ray)
        if len(at) == 0 or not self.minus.nodes:
            return spans
        cut = self.minus.spans(rays.at(at)).of_rays(at)
        return combine([(spans, 1), (cut, -1)], 1) if len(cut) else spans


class Forest:
    """Trees of a document, with a common list of leaves."""

    def __init__(self) -> None:
        self.leaves: list[Leaf] = []

    def plant(self, tree: dict[str, Any], pose: dict[str, Any] | None = None) -> Node:
        """Adds a tree at a pose and returns its node; without a pose it is in the sensor frame."""
        rotation = np.eye(3) if pose is None else np.array(pose["rotation"])
        shift = np.zeros(3) if pose is None else np.array(pose["translation_mm"])
        return self._node(tree, rotation, shift)

    def _node(self, tree: dict[str, Any], rotation: Array, shift: Array) -> Node:
        ((kind, of),) = tree.items()
        match kind:
            case "union":
                return Union([self._node(child, rotation, shift) for child in of])
            case "intersection":
                return Intersection([self._node(child, rotation, shift) for child in of])
            case "difference":
                tools = [self._node(tool, rotation, shift) for tool in of["minus"]]
                return Difference(self._node(of["of"], rotation, shift), tools)
            case "placed":
                by = of["pose"]
                moved = rotation @ np.array(by["translation_mm"]) + shift
                return self._node(of["of"], rotation @ np.array(by["rotation"]), moved)
            case "feature":
                return self._node(of["of"], rotation, shift)
        leaf = Leaf(primitive(kind, of), len(self.leaves), rotation, shift)
        self.leaves.append(leaf)
        return leaf

    def normals(self, points: Array, codes: Indices) -> Array:
        """Returns unit normals at points of the sensor frame, on faces given by their codes."""
        result = np.full(points.shape, np.nan)
        for number in np.unique(codes // FACES):
            at = np.flatnonzero(codes // FACES == number)
            result[at] = self.leaves[number].normal(points[at], codes[at] % FACES)
        return result
