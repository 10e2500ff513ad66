"""Height that opaque markers hide: ShadowTac's pipeline on images with dark printed dots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import sim
from fabkit.errors import invalid
from fabkit_bench._bench import press
from fabkit_bench._images import blurred
from fabkit_bench._places import places
from fabkit_bench._report import Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fabkit_bench._bench import Bench

    Maps = NDArray[np.float64]

__all__ = ["CHOICES", "heights_lost"]

# Published loss of the largest height by opaque markers, percent, by their diameter in mm.
_PAPER = {0.5: 12.0, 0.7: 20.0}
# Reflectance of dark ink: the capture simulation's own figure.
_DARK = 0.05
# Diameters of spheres, mm, and of a lying cylinder: three of the paper, and a small sphere.
_SPHERES_MM = (8.0, 20.0, 50.0)
_CYLINDER_MM, _LENGTH_MM = 40.0, 40.0
_DEPTHS_MM = (0.8, 2.0)
# Press positions are above this share of the skin's height, so that contacts stay in the crop.
_ABOVE = 0.8
# The published pipeline: side of the shrunk crop, px, and the least divisor, an intensity.
_SHRUNK, _LEAST_GREY = 150, 1.0
# Standard deviation of the blur in shrunk pixels: OpenCV's default for a window of 55.
_BLUR_PX = 8.6
# Number of images in the mean reference image.
_AT_REST = 10
# Half width of the window around a marker's middle in which covered pixels are computed, px.
_WINDOW_PX = 14
# Addition to the row's name, and note, for each method.
_WAYS = (
    ("", "photometric stereo as published"),
    (", slopes under them taken as 0", "the same, told where dots are: ink may show no slope"),
)

CHOICES = (
    "opaque markers: dots of one diameter, at the dimples' places, instead of them; heights are "
    "compared with those of a skin that has neither",
    "dots are drawn into the capture engine's noiseless pictures, as that draws printed dots of "
    "flat gels: what is within a radius of where the gel has moved a dot's middle sends 5 % "
    "back, the coat 45 %; then comes noise by its law, for the means of the chip's pixels",
    "spheres of 8, 20 and 50 mm and a lying cylinder of 40 mm, 0.8 to 2 mm deep, within the upper "
    "fifth of the skin; the paper does not say what it pressed",
    "photometric stereo as published (protocol: crop, shrink, colours by three directions, "
    "Fourier sum, less the blurred height at rest, negative ones cut); not stated there: lamps' "
    "directions are those in which each colour is brightest at rest, slopes are 0 outside of the "
    "circle, sums less than 1 grey count as 1, the frequencies are those of Frankot and Chellappa; "
    "the scale is left away, as shares of heights do not have it",
)


@dataclass(frozen=True, eq=False)
class Camera:
    """Surface points at rest and ray directions, for each pixel."""

    points_mm: Maps
    """Surface points at rest, h x w x 3, sensor frame; NaN where no surface is seen."""
    directions: Maps
    """Unit directions of the rays in the gel: h x w x 3."""

    @staticmethod
    def of(sensor: sim.Sensor) -> Camera:
        """Compute the rays in the gel.

        They start on the plate's plane face, z = 0; the sensor is symmetric about its axis, so
        each ray lies in a plane with the axis.
        """
        truth = sensor.scene.cast()
        points = truth.point_in_sensor
        cosine = points[..., 2] / truth.range_mm
        radius = np.hypot(points[..., 0], points[..., 1])
        across = np.sqrt(np.maximum(1 - cosine**2, 0)) / np.maximum(radius, 1e-9)
        sideways = points[..., :2] * across[..., None]
        return Camera(points, np.concatenate([sideways, cosine[..., None]], axis=-1))

    def pressed_mm(self, depth_mm: NDArray[Any]) -> Maps:
        """Compute surface points for an indentation map ``depth_mm`` along the rays."""
        return self.points_mm - np.nan_to_num(depth_mm)[..., None] * self.directions


def covered(
    points_mm: Maps, middles_mm: Maps, middles_px: NDArray[Any], diameter_mm: float
) -> Maps:
    """Compute the fraction of each pixel that dots cover, h x w.

    A dot covers the surface within its radius of its middle.
    """
    height, width = points_mm.shape[:2]
    share = np.zeros((height, width))
    for middle, px in zip(middles_mm, middles_px, strict=True):
        if not ((px >= 0) & (px <= (width - 1, height - 1))).all():
            continue
        column, row = (round(float(one)) for one in px)
        rows = slice(max(row - _WINDOW_PX, 0), row + _WINDOW_PX + 1)
        columns = slice(max(column - _WINDOW_PX, 0), column + _WINDOW_PX + 1)
        near = points_mm[rows, columns]
        step_mm = np.linalg.norm(np.diff(near, axis=1), axis=2)
        if not np.isfinite(step_mm).any():
            continue
        squared = ((near - middle) ** 2).sum(axis=2)
        # Middles are interpolated between nodes coarser than pixels, some 0.03 mm off the surface:
        # subtract the distance of the nearest pixel.
        away_mm = np.sqrt(squared - np.nanmin(squared))
        # Antialiasing: pixels on the rim are covered in part.
        inside = (diameter_mm / 2 - away_mm) / np.nanmedian(step_mm) + 0.5
        share[rows, columns] = np.maximum(share[rows, columns], np.nan_to_num(inside).clip(0, 1))
    return share


@dataclass(frozen=True)
class Chip:
    """Noise of the capture simulation, for pixels that average ``pixels`` of the chip's."""

    read: float
    shot: float
    drift: float
    pixels: float

    def takes(self, grey: Maps, random: np.random.Generator, pictures: int = 1) -> Maps:
        """Simulate the mean of several noisy images: intensities, 0 to 255, not rounded."""
        variance = (self.read**2 + self.shot**2 * grey) / (self.pixels * pictures)
        drift = self.drift / np.sqrt(pictures) * random.standard_normal()
        noisy = grey + drift + np.sqrt(variance) * random.standard_normal(grey.shape)
        return noisy.clip(0, 255)


class Stereo:
    """The published photometric stereo pipeline: heights of the crop, in arbitrary units."""

    def __init__(self, rest: Maps) -> None:
        crop = self._crop(rest)
        rows, columns = self._from_middle(len(crop))
        # Each light's direction is that of the centroid of its colour's share of the intensity.
        share = crop / np.maximum(crop.sum(axis=2, keepdims=True), _LEAST_GREY)
        share = share * (np.hypot(rows, columns) < len(crop) / 2)[..., None]
        towards = [
            np.arctan2((share[..., k] * rows).sum(), (share[..., k] * columns).sum())
            for k in range(3)
        ]
        lamps: Maps = np.array([[np.cos(angle), np.sin(angle), 1.0] for angle in towards])
        self._solve = np.linalg.pinv(lamps).astype(np.float64)

    @staticmethod
    def _from_middle(side: int) -> tuple[Maps, Maps]:
        rows, columns = np.mgrid[0:side, 0:side] - (side - 1) / 2
        return rows, columns

    @staticmethod
    def _crop(picture: Maps) -> Maps:
        """Cut out the middle square and shrink it by averaging squares of pixels."""
        side = min(picture.shape[:2])
        top, left = ((length - side) // 2 for length in picture.shape[:2])
        factor = max(1, side // _SHRUNK)
        side -= side % factor
        cut = picture[top : top + side, left : left + side]
        return cut.reshape(side // factor, factor, side // factor, factor, -1).mean(axis=(1, 3))

    def height(self, picture: Maps, level: Maps | None = None) -> Maps:
        """Integrate slopes to heights, towards the camera; slopes are 0 where ``level`` is 1."""
        crop = self._crop(picture)
        side = len(crop)
        # Normal times albedo: components along columns, along rows, towards the camera.
        normals: Maps = np.einsum("rcl,nl->rcn", crop, self._solve)
        seen = np.hypot(*self._from_middle(side)) < side / 2
        if level is not None:
            seen = seen * (1 - self._crop(level[..., None])[..., 0])
        up: Maps = np.maximum(normals[..., 2], _LEAST_GREY)
        across: Maps = -normals[..., 0] / up * seen
        down: Maps = -normals[..., 1] / up * seen
        # Integration by Fourier transform, with the frequencies of Frankot and Chellappa.
        turns = 2j * np.pi * np.fft.fftfreq(side)
        square = np.abs(turns[:, None]) ** 2 + np.abs(turns) ** 2
        square[0, 0] = 1.0
        waves = -np.fft.fft2(down) * turns[:, None] - np.fft.fft2(across) * turns
        heights: Maps = np.fft.ifft2(waves / square).real
        return heights

    def largest(self, picture: Maps, rest: Maps, levels: tuple[Maps, Maps] | None = None) -> float:
        """Compute the largest height above the blurred height at rest, at least 0."""
        now, before = levels or (None, None)
        calm = blurred(self.height(rest, before)[None].astype(np.float32), _BLUR_PX)[0]
        return float(np.maximum(self.height(picture, now) - calm, 0).max())


@dataclass(frozen=True, eq=False)
class Views:
    """Images of one skin: a reference image and one for each press."""

    rest: Maps
    """Mean of ten reference images: h x w x 3."""
    pressed: Maps
    """Images of the presses: n x h x w x 3."""
    dots: Maps
    """Fraction of each pixel that dots cover, at rest and then pressed: (1 + n) x h x w."""


def _bodies(bench: Bench, sensor: sim.Sensor, count: int) -> list[sim.Body]:
    """Draw indenters, positions and indentations."""
    random = bench.random("occlusion")
    skin_mm = float(bench.design.parameters["skin.height"].value)
    drawn = places(sensor, random, count, margin_mm=_ABOVE * skin_mm)
    depth_mm = random.uniform(*_DEPTHS_MM, count)
    turn = random.uniform(0, np.pi, count)
    bodies: list[sim.Body] = []
    for k in range(count):
        kind = k % (len(_SPHERES_MM) + 1)
        radius = (*_SPHERES_MM, _CYLINDER_MM)[kind] / 2
        at_mm = drawn.beyond(radius - depth_mm)[k]
        if kind < len(_SPHERES_MM):
            bodies.append(sim.ball(radius).at(*at_mm))
            continue
        # The cylinder's axis is tangential to the skin.
        up = drawn.outward[k]
        first = np.cross(up, [np.cos(turn[k]), np.sin(turn[k]), 0.0])
        first /= np.linalg.norm(first)
        pose = np.eye(4)
        pose[:3, :3] = np.stack([np.cross(up, first), up, first], axis=1)
        pose[:3, 3] = at_mm
        bodies.append(sim.cylinder(radius, _LENGTH_MM).placed(pose))
    return bodies


def _centre_mm(bench: Bench) -> Maps:
    """Compute the centre of the sphere that the skin is a cap of, sensor frame, mm."""
    skin = bench.design.parameters
    height_mm, base_mm = (float(skin[f"skin.{name}"].value) for name in ("height", "base_diameter"))
    return np.array([0.0, 0.0, height_mm - (base_mm**2 / 4 + height_mm**2) / (2 * height_mm)])


def _skins(bench: Bench) -> tuple[sim.Sensor, sim.Sensor]:
    """Prepare two skins: a bare one for images, and one whose dimples track the dots' motion."""
    size = bench.size
    # As shallow as a mold allows, so that the dimples move with the surface.
    shallow = {"dimples.width": "0.3 mm", "dimples.height": "0.15 mm"}
    marked = bench.sensor(
        bench.design.replace(shallow), size_px=size.size_px, spacing_mm=size.picture_spacing_mm
    )
    # A skin needs at least one dimple: it stands at the outermost dimples' angle, above the crop.
    outward = marked.mark_place_mm - _centre_mm(bench)
    across_mm = np.linalg.norm(outward[:, :2], axis=1)
    polar = float(np.rad2deg(np.arctan2(across_mm, outward[:, 2])).max())
    listed = {"pattern": "list", "polar": [f"{polar - 1e-4:.4f} deg"], "azimuth": ["90 deg"]}
    bare = bench.design.replace({**shallow, **{f"dimples.{k}": v for k, v in listed.items()}})
    plain = bench.sensor(bare, size_px=size.picture_px, spacing_mm=size.picture_spacing_mm)
    return plain, marked


def _views(bench: Bench, plain: sim.Sensor, marked: sim.Sensor) -> dict[float, Views]:
    """Press both skins and draw dots into the images; return views by dot diameter, mm.

    Diameter 0 means no dots.
    """
    size = bench.size
    asked = [sim.Asked(body, seed=None) for body in _bodies(bench, plain, size.presses)]
    many, kept = bench.press(plain, [sim.Asked(seed=None), *asked])
    dots, same, _ = press(marked, [sim.Asked(seed=None), *(asked[k - 1] for k in kept[1:])])
    if len(same) != len(kept):
        raise invalid("dots of some presses are not known")
    camera = Camera.of(plain)
    centre_mm = _centre_mm(bench)
    # Move the dimples' ends radially onto the surface that the camera sees.
    outward = marked.mark_place_mm - centre_mm
    surface_mm = np.nanmedian(np.linalg.norm(camera.points_mm - centre_mm, axis=2))
    rest_mm = centre_mm + outward * surface_mm / np.linalg.norm(outward, axis=1, keepdims=True)
    # NaN beyond the solved layers: nothing moves there.
    middles_mm = rest_mm + np.nan_to_num(dots.mark_displacement_mm)
    middles_px = (dots.mark_px + 0.5) * size.picture_px[0] / size.size_px[0] - 0.5
    chip, dark = _chip(plain, bench.design.parameters["camera.width_px"].value, size.picture_px[0])
    found: dict[float, Views] = {}
    for diameter_mm in (0.0, *_PAPER):
        share = np.zeros(many.image.shape[:3])
        for k in range(len(many) if diameter_mm else 0):
            points_mm = camera.pressed_mm(many.depth_mm[k])
            share[k] = covered(points_mm, middles_mm[k], middles_px[k], diameter_mm)
        clean = many.image * (1 - share * (1 - dark))[..., None]
        random = bench.random(f"occlusion, noise with {diameter_mm:g} mm")
        rest = chip.takes(clean[0], random, _AT_REST)
        pressed = np.stack([chip.takes(one, random) for one in clean[1:]])
        found[diameter_mm] = Views(rest, pressed, share)
    return found


def _chip(sensor: sim.Sensor, chip_px: float, width_px: int) -> tuple[Chip, float]:
    """Return the chip's noise, and the reflectance of dark ink relative to the coat's."""
    known = {one["name"]: float(one["value"]) for one in sensor.document["constants"]}
    read, shot, drift = (known[f"{name}_grey"] for name in ("read_noise", "shot_noise", "drift"))
    chip = Chip(read, shot, drift, (chip_px / width_px) ** 2)
    return chip, _DARK / known["coat_diffuse"]


def _largest(view: Views) -> tuple[Maps, Maps]:
    """Compute the largest height of each press: as published, and with known dot positions."""
    stereo = Stereo(view.rest)
    published = [stereo.largest(one, view.rest) for one in view.pressed]
    told = [
        stereo.largest(one, view.rest, (dots, view.dots[0]))
        for one, dots in zip(view.pressed, view.dots[1:], strict=True)
    ]
    return np.array(published), np.array(told)


def heights_lost(bench: Bench) -> list[Row]:
    """Compute how much the largest heights fall with opaque markers, percent."""
    plain, marked = _skins(bench)
    bench.tell(f"  pressing {bench.size.presses} times, without markers and with them")
    views = _views(bench, plain, marked)
    bench.tell("  finding heights")
    found = {diameter_mm: _largest(view) for diameter_mm, view in views.items()}
    rows: list[Row] = []
    for way, (words, note) in enumerate(_WAYS):
        for diameter_mm, paper in _PAPER.items():
            lost = 100 * (1 - found[diameter_mm][way] / found[0.0][way])
            low, high = np.percentile(lost, (25, 75))
            spread = f"median; half of the presses lose {low:.1f} to {high:.1f} %"
            rows.append(
                Row(
                    f"height lost to opaque markers of {diameter_mm} mm{words}",
                    "%",
                    None if words else paper,
                    float(np.median(lost)),
                    None,
                    len(lost),
                    f"{note}; {spread}",
                )
            )
    return rows
