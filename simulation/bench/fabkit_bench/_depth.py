"""Indentation from darkness, pixel by pixel: features, a small model, and its scores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit_bench import _models
from fabkit_bench._images import blurred, grey, neighbourhoods
from fabkit_bench._networks import Card, HeldOut, Numbers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fabkit import sim
    from fabkit_bench._onnx import OnnxNetwork

    Maps = NDArray[np.float32]

__all__ = [
    "DEEPEST_MM",
    "MASKS",
    "Model",
    "PixelData",
    "Score",
    "guess",
    "held_out",
    "prepare",
    "saturated",
    "score",
]

# Limits of the published script: smaller differences are noise, larger ones are clipped.
_LEAST_GREY = 3.0
_MOST_GREY = 47.0
# An 8-bit camera saturates at 255; the mean of noisy saturated images is a little less.
_WHITE_GREY = 254.0
# Largest indentation in the published script's targets, mm.
DEEPEST_MM = 2.0
# The published script's image width and blur, px, and the side of its network's field of view, px.
_WIDTH_PX = 640
_BLUR_PX = 5.0
_FIELD_PX = 13
# Standard deviations of the blurs for the wider model, as fractions of the image's width.
_AROUND = (0.02, 0.05)

MASKS = {
    "all": "all pixels that see the surface",
    "contact": "pixels that see what presses",
    "loss": "pixels whose input is not zero, on which the published loss is taken",
}


@dataclass(frozen=True, eq=False)
class PixelData:
    """Inputs and ground truth of the model for p presses of h x w pixels."""

    darkness: Maps
    """Darkening against the reference image, 0 to 1: p x h x w."""
    depth_mm: Maps
    """True indentation along each ray, mm, at least 0: p x h x w; 0 where no surface is seen."""
    masks: dict[str, NDArray[np.bool_]]
    """Pixels over which errors are averaged, by the names of :data:`MASKS`: p x h x w."""

    def __len__(self) -> int:
        return len(self.darkness)

    def some(self, chosen: NDArray[np.bool_] | slice) -> PixelData:
        """Select some presses."""
        masks = {name: mask[chosen] for name, mask in self.masks.items()}
        return PixelData(self.darkness[chosen], self.depth_mm[chosen], masks)


def prepare(many: sim.Many, reference: NDArray[np.uint8]) -> PixelData:
    """Prepare images as the published script does: subtract, blur, clip and scale to 0 to 1."""
    width = many.image.shape[2]
    sigma_px = _BLUR_PX * width / _WIDTH_PX
    differences = blurred(grey(reference[None]) - grey(many.image), sigma_px)
    span = _MOST_GREY
    darkness = np.clip(differences - _LEAST_GREY, 0.0, span) / span
    on_surface = np.isfinite(many.depth_mm)
    darkness = np.where(on_surface, darkness, 0.0).astype(np.float32)
    depth_mm = np.where(on_surface, np.maximum(many.depth_mm, 0.0), 0.0).astype(np.float32)
    masks = {
        "all": on_surface,
        "contact": many.contact & on_surface,
        "loss": darkness > 0.0,
    }
    return PixelData(darkness, depth_mm, masks)


class Model:
    """A perceptron on each pixel's neighbourhood, as the paper's network has.

    Parameters
    ----------
    seed
        Seed of initial weights and of the order of samples.
    epochs
        Number of epochs.
    wide
        Add the pixel's position and the mean darkness in larger neighbourhoods to the inputs,
        which the paper's network does not have.
    """

    def __init__(self, seed: int, epochs: int, *, wide: bool = False) -> None:
        self._wide = wide
        self._network = _models.Network((64, 32), seed=seed, epochs=epochs, batch=500)

    def fit(self, seen: PixelData, pixels: int, random: np.random.Generator) -> Model:
        """Train on at most ``pixels`` pixels of each press, drawn from those with an input."""
        self._network.fit(*self._drawn(seen, pixels, random))
        return self

    def fine_tune(
        self, seen: PixelData, pixels: int, epochs: int, random: np.random.Generator
    ) -> None:
        """Continue training on another unit's presses."""
        self._network.fine_tune(*self._drawn(seen, pixels, random), epochs)

    def predict(self, seen: PixelData) -> Maps:
        """Predict the indentation, mm: p x h x w; 0 in pixels without an input."""
        depth_mm = np.zeros_like(seen.depth_mm)
        where = seen.masks["loss"]
        if where.any():
            found = self._network.predict(self._features(seen, where))
            depth_mm[where] = np.clip(found, 0.0, DEEPEST_MM)
        return depth_mm

    def to_onnx(self) -> OnnxNetwork:
        """Write the model as ONNX; each row of its input is a pixel."""
        return self._network.to_onnx(within=(0.0, DEEPEST_MM))

    def card(self, train: PixelData, pixels: int, held_out: list[HeldOut]) -> Card:
        """Write the model's card; ``pixels`` is the most that were drawn of each press."""
        height, width = train.darkness.shape[1:]
        side = _side(width)
        takes = f"of each pixel the square of {side} x {side} around it, row by row, 0 outside"
        takes += (
            f", in a picture of {width} x {height} that is blurred by "
            f"{_BLUR_PX * width / _WIDTH_PX:g} px, taken from the picture at rest (the mean of "
            f"ten), less {_LEAST_GREY:g} grey and cut off at 0 and {_MOST_GREY:g} grey, as 0 to 1"
        )
        if self._wide:
            takes += (
                "; then column / width - 0.5, row / height - 0.5, and the same picture blurred by "
                f"{' and '.join(f'{part * width:g} px' for part in _AROUND)} there"
            )
        drawn = np.minimum(train.masks["loss"].sum(axis=(1, 2)), pixels)
        return Card(
            takes=Numbers(takes, "of 47 grey"),
            gives=Numbers("how deep the surface is pressed in, along the pixel's ray", "mm"),
            mask="pixels that see the surface and whose input is not zero; the others are 0 mm",
            training=(int(drawn.sum()), f"pixels of {len(train)} presses"),
            held_out=held_out,
        )

    def _drawn(
        self, seen: PixelData, pixels: int, random: np.random.Generator
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        kept = np.zeros(seen.darkness.shape, dtype=bool)
        for mask, into in zip(seen.masks["loss"], kept, strict=True):
            places = np.flatnonzero(mask)
            if len(places):
                some = random.choice(places, size=min(pixels, len(places)), replace=False)
                into.ravel()[some] = True
        return self._features(seen, kept), np.minimum(seen.depth_mm[kept], DEEPEST_MM)

    def _features(self, seen: PixelData, where: NDArray[np.bool_]) -> NDArray[Any]:
        _, height, width = seen.darkness.shape
        listed = [neighbourhoods(seen.darkness, _side(width))[where]]
        if self._wide:
            _, row, column = np.nonzero(where)
            listed.append(np.column_stack([column / width - 0.5, row / height - 0.5]))
            for part in _AROUND:
                listed.append(blurred(seen.darkness, part * width)[where][:, None])
        return np.concatenate(listed, axis=1).astype(np.float64)


def _side(width_px: int) -> int:
    """Compute the side of a pixel's neighbourhood, px, odd: the paper's, scaled to the width."""
    return max(3, 2 * round((_FIELD_PX * width_px / _WIDTH_PX - 1) / 2) + 1)


@dataclass(frozen=True)
class Score:
    """Score of one reconstruction over one mask."""

    mean_mm: float
    """Mean absolute error, mm."""
    near: float
    """Share of errors below 0.1 mm, percent."""


def score(found_mm: Maps, seen: PixelData, mask: str) -> Score:
    """Compare a reconstruction with ground truth over a mask."""
    where = seen.masks[mask] & np.isfinite(found_mm)
    errors = np.abs(found_mm[where] - seen.depth_mm[where]).astype(np.float64)
    if not len(errors):
        return Score(float("nan"), float("nan"))
    return Score(float(errors.mean()), float(100.0 * (errors < 0.1).mean()))


def saturated(seen: PixelData, reference: NDArray[np.uint8]) -> float:
    """Compute the share of contact pixels whose intensity no longer changes with indentation.

    They are darkened beyond the limit of the published script, or saturated at rest.
    """
    is_over = (seen.darkness >= 1.0) | (grey(reference[None]) >= _WHITE_GREY)
    where = seen.masks["contact"]
    return float(is_over[where].mean()) if where.any() else float("nan")


def held_out(found_mm: Maps, seen: PixelData, of: str) -> list[HeldOut]:
    """List the mean errors over each mask, for a card."""
    return [
        HeldOut(
            f"{of}, {words}: mean error", score(found_mm, seen, mask).mean_mm, "mm", len(found_mm)
        )
        for mask, words in MASKS.items()
    ]


def guess(train: PixelData, mask: str) -> float:
    """Return the best guess without an image: the median indentation over a mask, mm."""
    depths = train.depth_mm[train.masks[mask]]
    return float(np.median(depths)) if len(depths) else 0.0
