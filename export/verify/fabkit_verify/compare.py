"""Comparison of a rebuilt solid with the properties that fabkit computed for the exact one.

Each comparison returns a Check with its value and its limit. Limits are derived where they are used:

- A kernel with exact faces (`chord_mm` 0) differs by rounding and by its own integration.
- A kernel with triangles is nowhere farther than its chord tolerance from the exact surface. That
  bounds the volume between the two by area times chord, and the other properties by the places
  where that volume can be.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy

from .measured import Rebuilt

# Limits for kernels with exact faces: relative volume, relative area, distance. OpenCascade intersects
# faces to 1e-7 mm and integrates volumes and areas adaptively.
EXACT_VOLUME = 1e-6
EXACT_AREA = 1e-6
EXACT_DISTANCE_MM = 1e-3
# Limit for bounding boxes, mm: OpenCascade's smallest box has its own tolerance.
EXACT_BOUNDS_MM = 1e-5
# Rounding of coordinates in a mesh file to 24 bits: half a step at 128 mm.
FLOAT32_MM = 8e-6
# Kernels that intersect facets with facets. The resulting edge is off by the facets' distance over the
# sine of the angle between the faces: the factor covers 30 degrees and more. fabkit's own meshes get no
# such allowance.
CUTS_FACETS = ("manifold3d",)
SEAM_FACTOR = 2.0


@dataclass(frozen=True)
class Check:
    """One comparison; it passes if `value` does not exceed `limit`."""

    what: str
    value: float
    limit: float
    unit: str
    # Explanation in words: the affected features and places.
    note: str = ""
    # Points of disagreement, mm, for the report's images.
    places_mm: tuple[tuple[float, float, float], ...] = ()

    @property
    def passed(self) -> bool:
        # NaN compares as false, so it fails.
        return bool(self.value <= self.limit)

    def as_json(self) -> dict[str, Any]:
        # JSON has no infinity.
        value = float(self.value) if numpy.isfinite(self.value) else None
        return {
            **asdict(self),
            "value": value,
            "limit": float(self.limit),
            "passed": self.passed,
        }


def compare(tree: dict, samples: dict, rebuilt: Rebuilt) -> list[Check]:
    """Compares all properties of a rebuilt solid with the samples document."""
    checks = [Check("complaints", 1.0, 0.0, "", text) for text in rebuilt.complaints]
    checks += _figures(tree, samples["figures"], rebuilt)
    checks += _lines(samples, rebuilt)
    checks.append(_points(samples["points"], rebuilt))
    checks += _landmarks(samples["landmarks"], rebuilt)
    return checks


def _figures(tree: dict, exact: dict, rebuilt: Rebuilt) -> list[Check]:
    """Compares volume, area, centroid, inertia, bounds, genus and number of shells."""
    mass, chord = rebuilt.mass, rebuilt.chord_mm
    volume, area = exact["volume_mm3"], exact["area_mm2"]
    low, high = numpy.array(exact["bounds_mm"])
    size = float(numpy.linalg.norm(high - low))
    inertia = numpy.array(exact["inertia_mm5"])
    largest = float(numpy.abs(inertia).max())
    # Upper bound of the volume between triangles and surface, mm3; it is at most `size` from the centroid.
    between = area * (chord + (FLOAT32_MM if chord else 0.0))
    if chord:
        limits = {
            "volume": between / volume,
            # Relative area change of a surface that is moved by a chord along its normal, if both of its
            # radii of curvature are the smallest of the tree (Steiner's formula).
            "area": 2.0 * chord / smallest_radius_mm(tree["solid"], chord),
            "centroid": between * size / volume,
            "inertia": between * size**2 / largest,
            "bounds": chord + FLOAT32_MM,
        }
    else:
        limits = {
            "volume": EXACT_VOLUME,
            "area": EXACT_AREA,
            # Effect of a volume that small, wherever it is in the box.
            "centroid": EXACT_VOLUME * size,
            "inertia": EXACT_VOLUME * volume * size**2 / largest,
            "bounds": EXACT_BOUNDS_MM,
        }
    off = {
        "volume": abs(mass.volume_mm3 - volume) / volume,
        "area": abs(mass.area_mm2 - area) / area,
        "centroid": float(numpy.linalg.norm(mass.centroid_mm - exact["centroid_mm"])),
        "inertia": float(numpy.abs(mass.inertia_mm5 - inertia).max()) / largest,
        "bounds": float(numpy.abs(rebuilt.bounds_mm - [low, high]).max()),
    }
    # Error bounds of fabkit's own figures add to the limits.
    own = {
        "volume": exact["volume_error_mm3"] / volume,
        "area": exact["area_error_mm2"] / area,
        "centroid": exact["centroid_error_mm"],
        "inertia": exact["inertia_error_mm5"] / largest,
        "bounds": exact["bounds_error_mm"],
    }
    units = {"volume": "relative", "area": "relative", "inertia": "relative"}
    checks = [
        Check(what, off[what], limits[what] + own[what], units.get(what, "mm")) for what in limits
    ]
    for what, found in (("genus", rebuilt.genus), ("shells", rebuilt.shells)):
        if found is None:
            continue
        note = f"{what}: {rebuilt.kernel} finds {found}, fabkit says {exact[what]}"
        checks.append(Check(what, abs(found - exact[what]), 0, "", note))
    return checks


def smallest_radius_mm(node: Any, least: float) -> float:
    """Returns the smallest radius of curvature of the curved faces in a tree, mm, and at least `least`."""
    radii: list[float] = []

    def visit(value: Any) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                if key in ("radius_mm", "tube_radius_mm", "bottom_radius_mm", "top_radius_mm"):
                    radii.append(inner)
                elif key in ("arc", "elliptic-arc"):
                    radii.append(_radius_of_arc(inner))
                elif key == "revolution":
                    radii.extend(_radii_of_corners(inner["profile"]))
                elif key == "ellipsoid-offset":
                    a, b = inner["equatorial_mm"], inner["polar_mm"]
                    radii.append(min(a, b) ** 2 / max(a, b) + inner["offset_mm"])
                visit(inner)
        elif isinstance(value, list):
            for inner in value:
                visit(inner)

    visit(node)
    return max(least, min((r for r in radii if r > 0.0), default=1.0))


def _radius_of_arc(how: dict) -> float:
    if "semi_axes_mm" in how:
        return min(how["semi_axes_mm"]) ** 2 / max(how["semi_axes_mm"])
    return float(numpy.hypot(how["to"][0] - how["centre"][0], how["to"][1] - how["centre"][1]))


def _radii_of_corners(profile: dict) -> list[float]:
    paths = [profile["outer"], *profile.get("holes", [])]
    ends = [next(iter(s.values()))["to"] for path in paths for s in path["segments"]]
    return [end[0] for end in ends]


def _lines(samples: dict, rebuilt: Rebuilt) -> list[Check]:
    """Compares the crossings of lines: distance between the surfaces, and volume between the solids."""
    lines = samples["lines"]
    origins = numpy.array([line["origin_mm"] for line in lines])
    directions = numpy.array([line["direction"] for line in lines])
    limit = rebuilt.chord_mm + FLOAT32_MM if rebuilt.chord_mm else EXACT_DISTANCE_MM
    off: list[_Deviation] = []
    bundles = [0.0 for _ in samples["bundle_mm2"]]
    for line, hits, origin, direction in zip(
        lines, rebuilt.crossings(origins, directions), origins, directions
    ):
        found = _compare_line(line, hits, origin, direction, limit, rebuilt)
        if rebuilt.kernel in CUTS_FACETS and line["of"].startswith("seam "):
            found = [replace(o, distance_mm=o.distance_mm / SEAM_FACTOR) for o in found]
        off += found
        if line["of"].startswith("bundle "):
            number = int(line["of"].removeprefix("bundle "))
            bundles[number] += samples["bundle_mm2"][number] * _length_in_one(line["t_mm"], hits)
    off.sort(key=lambda o: -o.distance_mm)
    worst = off[0].distance_mm if off else 0.0
    beyond = [o for o in off if o.distance_mm > limit]
    # Named features first: they say more than lines of a bundle or along a seam.
    names = list(dict.fromkeys(o.of for o in beyond))
    names.sort(key=lambda name: name.startswith(("bundle ", "seam ")))
    note = f"at {', '.join(names[:4])}" + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    places = tuple(tuple(map(float, o.at_mm)) for o in beyond[:200])
    area = samples["figures"]["area_mm2"]
    volume = samples["figures"]["volume_mm3"]
    return [
        Check("distance", worst, limit, "mm", note if beyond else "", places),
        # Each line stands for one cell of its bundle. The volume between two surfaces is at most the area
        # times their distance.
        Check("symmetric difference", max(bundles) / volume, limit * area / volume, "relative"),
    ]


def _length_in_one(exact: list[float], hits: numpy.ndarray) -> float:
    """Computes the length of the line that is inside one solid and outside the other."""
    if len(hits) % 2:
        return 0.0  # Through an edge: a kernel with tolerances met only one of its two faces.
    ends = sorted([(t, 0) for t in exact] + [(t, 1) for t in hits])
    inside, length = [False, False], 0.0
    for (t, which), (following, _) in zip(ends, ends[1:]):
        inside[which] = not inside[which]
        length += (following - t) if inside[0] != inside[1] else 0.0
    return length


@dataclass(frozen=True)
class _Deviation:
    distance_mm: float
    of: str
    at_mm: numpy.ndarray


def _compare_line(line, hits, origin, direction, limit, rebuilt) -> list[_Deviation]:
    """Measures the distance of each crossing to the nearest one of the other solid, along the normal.

    Close to an edge, a line may cross one solid twice and the other not at all, or the two solids on
    different faces of the edge. There the distance to the kernel's surface counts instead. Half way
    between two surfaces it is half of their distance.
    """
    exact, cosine = numpy.array(line["t_mm"]), numpy.abs(line["cosine"])
    found = []

    def add(distance: float, t: float) -> None:
        found.append(_Deviation(float(distance), line["of"], origin + t * direction))

    for t, c in zip(exact, cosine):
        distance = numpy.abs(hits - t).min(initial=numpy.inf) * c
        if distance > limit:
            distance = min(distance, rebuilt.distance_mm(origin + t * direction))
        add(distance, t)
    for t in hits:
        nearest = int(numpy.abs(exact - t).argmin()) if len(exact) else -1
        distance = abs(exact[nearest] - t) * cosine[nearest] if len(exact) else numpy.inf
        if distance > limit:
            # From here to the nearest other crossing, the line is inside one solid and outside the other.
            others = numpy.concatenate([exact, hits[hits != t]])
            middle = 0.5 * (t + others[numpy.abs(others - t).argmin()]) if len(others) else t
            depth = 2.0 * rebuilt.distance_mm(origin + middle * direction)
            distance = min(distance, depth) if len(others) else distance
        add(distance, t)
    return found


def _points(points: list[dict], rebuilt: Rebuilt) -> Check:
    """Compares on which side of the surface points are, except those nearer than the tolerance."""
    places = numpy.array([point["point_mm"] for point in points]).reshape(-1, 3)
    inside = rebuilt.contains(places)
    wrong = [
        place
        for place, found, point in zip(places, inside, points)
        if found != point["inside"] and rebuilt.distance_mm(place) > rebuilt.chord_mm + FLOAT32_MM
    ]
    at = tuple(tuple(map(float, place)) for place in wrong[:200])
    note = f"{len(wrong)} of {len(points)} points are on the wrong side" if wrong else ""
    return Check("containment", len(wrong), 0, "points", note, at)


def _landmarks(landmarks: list[dict], rebuilt: Rebuilt) -> list[Check]:
    """Checks that each landmark is on the surface, in the open or in the solid, as its document says.

    Lines along and across each landmark's axis are compared together with all other lines.
    """
    if not landmarks:
        return []
    limit = rebuilt.chord_mm + FLOAT32_MM if rebuilt.chord_mm else EXACT_DISTANCE_MM
    places = numpy.array([landmark["point_mm"] for landmark in landmarks])
    wrong, at = [], []
    for landmark, place, inside in zip(landmarks, places, rebuilt.contains(places)):
        wanted = landmark["lies_in"]
        if wanted != "surface" and inside == (wanted == "solid"):
            continue
        distance = rebuilt.distance_mm(place)
        if distance > limit:
            wrong.append(f"{landmark['name']} ({distance:.4f} mm from the surface, not in {wanted})")
            at.append(tuple(map(float, place)))
    return [Check("landmarks", len(wrong), 0, "landmarks", "; ".join(wrong[:4]), tuple(at[:200]))]
