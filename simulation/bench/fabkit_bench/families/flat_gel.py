"""Experiments of flat gels: depth by small models, and without a network if the light allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import sim
from fabkit.errors import FabkitError
from fabkit_bench import _models
from fabkit_bench._bench import Family, first_line, reference
from fabkit_bench._depth import MASKS, Model, PixelData, guess, held_out, prepare, score
from fabkit_bench._networks import Card, Numbers
from fabkit_bench._places import places
from fabkit_bench._report import Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fabkit_bench._bench import Bench
    from fabkit_bench._networks import HeldOut
    from fabkit_bench._onnx import OnnxNetwork

    Maps = NDArray[np.float32]


@dataclass(frozen=True)
class Size:
    """Numbers of presses and sizes of training."""

    size_px: tuple[int, int] = (160, 120)
    spacing_mm: float = 0.5
    train: int = 120
    """Number of training presses."""
    test: int = 40
    """Number of test presses of the same kinds, and of a kind that is not in training."""
    pixels: int = 300
    epochs: int = 60
    direct: bool = True
    """True to reconstruct depth without a network too: a minute where layers scatter light."""


# Indentations as fractions of the gel's thickness: small strain, and what fingers reach.
_SHALLOWEST, _DEEPEST = 0.08, 0.35


@dataclass(frozen=True, eq=False)
class Pressed:
    """Images of presses with inputs and ground truth."""

    images: NDArray[np.uint8]
    seen: PixelData


@dataclass(frozen=True, eq=False)
class Set:
    """A prepared sensor, its reference image, and training and test presses."""

    sensor: sim.Sensor
    reference: NDArray[np.uint8]
    train: Pressed
    test: Pressed
    other: Pressed
    """Test presses of a kind that is not in training."""


def _bodies(
    bench: Bench, sensor: sim.Sensor, of: str, count: int, *, other: bool
) -> list[sim.Asked]:
    """Draw presses of balls and lying capsules, or, if ``other``, of upright cylinders."""
    random = bench.random(of)
    drawn = places(sensor, random, count)
    thick_mm = float(bench.design.parameters["pad.thickness"].value)
    depth = thick_mm * random.uniform(_SHALLOWEST, _DEEPEST, count)
    radius = random.uniform(1.5, 4.0, count)
    length = random.uniform(2.0, 6.0, count)
    turn = random.uniform(0, np.pi, count)
    is_ball = random.random(count) < 0.5
    seeds = bench.noise(of, count)
    asked: list[sim.Asked] = []
    for k in range(count):
        if other:
            body = sim.cylinder(0.7 * radius[k], 6.0).at(*drawn.beyond(3.0 - depth)[k])
        elif is_ball[k]:
            body = sim.ball(radius[k]).at(*drawn.beyond(radius - depth)[k])
        else:
            # The capsule's axis is parallel to the pad.
            cos, sin = np.cos(turn[k]), np.sin(turn[k])
            pose = np.eye(4)
            pose[:3, :3] = np.array([[-sin, 0, cos], [cos, 0, sin], [0, 1, 0]])
            pose[:3, 3] = drawn.beyond(radius - depth)[k]
            body = sim.capsule(radius[k], length[k]).placed(pose)
        asked.append(sim.Asked(body, seed=seeds[k]))
    return asked


def _set(bench: Bench) -> Set:
    def make() -> Set:
        size: Size = bench.size
        sensor = bench.sensor(size_px=size.size_px, spacing_mm=size.spacing_mm)
        calm = reference(bench, sensor, "flat")

        def pressed(of: str, count: int, *, other: bool = False) -> Pressed:
            bench.tell(f"  pressing {count} times: {of}")
            many, _ = bench.press(sensor, _bodies(bench, sensor, of, count, other=other))
            return Pressed(many.image, prepare(many, calm))

        train, test = pressed("train", size.train), pressed("test", size.test)
        return Set(sensor, calm, train, test, pressed("other", size.test, other=True))

    return bench.once("set", make)


def _is_colored(made: Set) -> bool:
    return made.reference.ndim == 3


class Slopes:
    """The usual method for coloured light: slopes from colour and position, then integration."""

    def __init__(self, seed: int, epochs: int, reference: NDArray[np.uint8]) -> None:
        self._network = _models.Network((64, 32), seed=seed, epochs=epochs, batch=500)
        self._reference = reference.astype(np.float32)

    def fit(self, pressed: Pressed, pixels: int, random: np.random.Generator) -> Slopes:
        """Train on ``pixels`` pixels of each press, half of them in contact."""
        features = self._features(pressed.images)
        down, across = (np.gradient(pressed.seen.depth_mm, axis=axis) for axis in (1, 2))
        slopes = np.stack([down, across], axis=-1)
        chosen: list[NDArray[Any]] = []
        count, height, width = pressed.seen.depth_mm.shape
        for k in range(count):
            touched = np.flatnonzero(np.abs(slopes[k]).max(axis=-1) > 0.002)
            some = random.choice(touched, min(pixels // 2, len(touched)), replace=False)
            others = random.integers(height * width, size=pixels // 2)
            chosen.append(k * height * width + np.concatenate([some, others]))
        rows = np.concatenate(chosen)
        self._training = (len(rows), f"pixels of {count} presses, half of them where it presses")
        self._network.fit(
            features.reshape(-1, features.shape[-1])[rows].astype(np.float64),
            slopes.reshape(-1, 2)[rows].astype(np.float64),
        )
        return self

    def predict(self, pressed: Pressed) -> Maps:
        """Predict depth, mm: p x h x w; 0 along the image's edge."""
        features = self._features(pressed.images)
        found = np.zeros(pressed.seen.depth_mm.shape, dtype=np.float32)
        for k, one in enumerate(features):
            slopes = self._network.predict(one.reshape(-1, one.shape[-1]).astype(np.float64))
            down, across = np.moveaxis(slopes.reshape(*one.shape[:2], 2), 2, 0)
            found[k] = np.maximum(_integrate_slopes(down, across), 0.0)
        return found

    def to_onnx(self) -> OnnxNetwork:
        """Write the model as ONNX; each row of its input is a pixel."""
        return self._network.to_onnx()

    def card(self, held_out: list[HeldOut]) -> Card:
        """Write the model's card."""
        height, width, colours = self._reference.shape
        place = {"column / width - 0.5": "", "row / height - 0.5": ""}
        return Card(
            takes=Numbers(
                "of each pixel how much brighter it is than at rest (the mean of ten pictures), "
                "less the median of all pixels, and where it is; pictures of "
                f"{width} x {height}",
                {f"colour {k + 1}": "of 255 grey" for k in range(colours)} | place,
            ),
            gives=Numbers(
                "slopes of depth, which the bench sums by Poisson's equation, 0 at the edge",
                {"down": "mm per px", "across": "mm per px"},
            ),
            mask="whole pictures",
            training=self._training,
            held_out=held_out,
        )

    def _features(self, images: NDArray[np.uint8]) -> Maps:
        count, height, width = images.shape[:3]
        rows, columns = np.mgrid[0:height, 0:width]
        place = np.stack([columns / width - 0.5, rows / height - 0.5], axis=-1)
        places_of = np.broadcast_to(place, (count, height, width, 2))
        differences = (images.astype(np.float32) - self._reference) / 255.0
        # Most of an image is untouched, so the median difference is the drift of brightness.
        differences -= np.median(differences, axis=(1, 2), keepdims=True)
        return np.concatenate([differences, places_of], axis=-1).astype(np.float32)


def _integrate_slopes(down: NDArray[Any], across: NDArray[Any]) -> NDArray[np.float64]:
    """Integrate slopes, (h, w) each, to heights by least squares, with 0 at the edge.

    This solves Poisson's equation with sine transforms, in which the Laplacian is diagonal.
    """
    height, width = (int(n) for n in down.shape)
    source = np.gradient(down, axis=0) + np.gradient(across, axis=1)
    sines = [
        np.sin(np.pi * np.outer(np.arange(1, n + 1), np.arange(1, n + 1)) / (n + 1))
        * np.sqrt(2 / (n + 1))
        for n in (height, width)
    ]
    curves = [2 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1)) - 2 for n in (height, width)]
    waves: NDArray[np.float64] = sines[0] @ source @ sines[1]
    waves = waves / (curves[0][:, None] + curves[1])
    heights: NDArray[np.float64] = sines[0] @ waves @ sines[1]
    return heights


def _learned(bench: Bench, made: Set) -> tuple[Maps, Maps]:
    """Predict depth with a small model, for both tests."""
    size: Size = bench.size
    random = bench.random("pixels")
    if _is_colored(made):
        slopes = Slopes(bench.seed, size.epochs, made.reference)
        slopes.fit(made.train, size.pixels, random)
        found = slopes.predict(made.test), slopes.predict(made.other)
        bench.keep("slopes", slopes.to_onnx(), slopes.card(_errors(found, made)))
        return found
    model = Model(bench.seed, size.epochs, wide=True)
    model.fit(made.train.seen, size.pixels, random)
    found = model.predict(made.test.seen), model.predict(made.other.seen)
    card = model.card(made.train.seen, size.pixels, _errors(found, made))
    bench.keep("depth", model.to_onnx(), card)
    return found


def _errors(found: tuple[Maps, Maps], made: Set) -> list[HeldOut]:
    pairs = zip(_KINDS, found, (made.test, made.other), strict=True)
    return [one for kind, depth_mm, of in pairs for one in held_out(depth_mm, of.seen, kind)]


def _reconstructed(made: Set) -> tuple[Maps, Maps] | str:
    """Reconstruct depth without a network for both tests, or return the error's message."""
    images = np.concatenate([made.test.images, made.other.images])
    try:
        # One call for both: each call solves for the light at rest first.
        depth_mm = np.nan_to_num(made.sensor.reconstruct(images, made.reference)[0])
    except FabkitError as error:
        return first_line(error)
    return depth_mm[: len(made.test.images)], depth_mm[len(made.test.images) :]


_KINDS = ("other places", "a kind never seen")


def _depth(bench: Bench) -> list[Row]:
    made = _set(bench)
    how = (
        "perceptron 64-32 from colours and place to slopes, summed by Poisson's equation"
        if _is_colored(made)
        else "perceptron 64-32 from each pixel's neighbours, wider means and its place"
    )
    rows = _rows(made, "by a small model", _learned(bench, made), how)
    if not bench.size.direct:
        return rows
    bench.tell("  reconstructing without a network")
    found = _reconstructed(made)
    if isinstance(found, str):
        missing = f"not run: {found}"
        return [*rows, Row("without a network", "mm", None, None, None, 0, missing)]
    how = "solved from the light's law, with the constants that the pictures were made with"
    return rows + _rows(made, "without a network", found, how)


def _rows(made: Set, label: str, found: tuple[Maps, Maps], how: str) -> list[Row]:
    rows: list[Row] = []
    masks = ("all", "contact") if _is_colored(made) else tuple(MASKS)
    for kind, depth_mm, pressed in zip(_KINDS, found, (made.test, made.other), strict=True):
        for mask in masks:
            constant = guess(made.train.seen, mask)
            own = score(depth_mm, pressed.seen, mask)
            blind = score(np.full_like(depth_mm, constant), pressed.seen, mask)
            note = (
                f"{how}; no published figure; over {MASKS[mask]}; trained on balls and lying "
                f"capsules, the kind never seen is flat cylinders; trivial guess: {constant:.2f} mm"
            )
            figures = (None, own.mean_mm, blind.mean_mm)
            name = f"depth {label}, {kind}: mean error, {mask}"
            rows.append(Row(name, "mm", *figures, len(depth_mm), note))
    return rows


def _mean_mm(bench: Bench, mask: str) -> float:
    made = bench.once("set", lambda: _set(bench))
    depth_mm, _ = bench.once("learned", lambda: _learned(bench, made))
    return score(depth_mm, made.test.seen, mask).mean_mm


FAMILY = Family(
    experiments={"depth": _depth},
    figures={
        "depth_mae_mm": lambda bench: _mean_mm(bench, "contact"),
        "depth_mae_all_mm": lambda bench: _mean_mm(bench, "all"),
    },
    quick=Size(),
    full=Size(size_px=(320, 240), spacing_mm=0.3, train=1000, test=200, epochs=50),
    small=Size(size_px=(80, 60), spacing_mm=0.7, train=40, test=10, epochs=30),
    choices=(
        "for coloured light, that drift is taken off and 60 epochs were chosen by the errors of "
        "digit-like's own test, seed 0: other seeds and sensors tell what that flatters",
        "pressers are balls of 1.5 to 4 mm radius and lying capsules, 8 to 35 % of the gel's "
        "thickness deep, evenly over what the camera sees",
        "the reference is the mean of ten pictures at rest",
        "no two presses share a place, so that nothing leaks from training to test",
    ),
    left_out=("no paper of this project has a figure for these sensors",),
)
