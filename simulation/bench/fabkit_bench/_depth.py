"""Depth from darkness, pixel by pixel: what a small model learns, and how it is scored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit_bench import _learn
from fabkit_bench._networks import Card, HeldOut, Numbers
from fabkit_bench._pictures import blurred, grey, neighbourhoods

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fabkit import sim
    from fabkit_bench._onnx import Written

    Maps = NDArray[np.float32]

__all__ = [
    "DEEPEST_MM",
    "MASKS",
    "Model",
    "Score",
    "Seen",
    "guess",
    "held_out",
    "saturated",
    "score",
    "seen",
]

# The published script's: differences below the first are noise, above the second the same.
_LEAST_GREY = 3.0
_MOST_GREY = 47.0
# An 8-bit chip says no more; the mean of noisy pictures is a little less.
_WHITE_GREY = 254.0
# Its targets end there too, mm.
DEEPEST_MM = 2.0
# Its pictures' width and blur, px, and the side of the square of pixels that its network sees.
_WIDTH_PX = 640
_BLUR_PX = 5.0
_FIELD_PX = 13
# How far around a wider view sees, as parts of the picture's width.
_AROUND = (0.02, 0.05)

MASKS = {
    "all": "all pixels that see the surface",
    "contact": "pixels that see what presses",
    "loss": "pixels whose input is not zero, on which the published loss is taken",
}


@dataclass(frozen=True, eq=False)
class Seen:
    """Presses as the model sees them: p presses of h x w pixels."""

    darkness: Maps
    """How much darker than at rest, 0 to 1: p x h x w."""
    depth_mm: Maps
    """Truth along each ray, from 0: p x h x w; 0 where no surface is seen."""
    masks: dict[str, NDArray[np.bool_]]
    """Over which pixels errors are averaged, by the names of :data:`MASKS`: p x h x w."""

    def __len__(self) -> int:
        return len(self.darkness)

    def some(self, chosen: NDArray[np.bool_] | slice) -> Seen:
        """Keep some presses."""
        masks = {name: mask[chosen] for name, mask in self.masks.items()}
        return Seen(self.darkness[chosen], self.depth_mm[chosen], masks)


def seen(many: sim.Many, reference: NDArray[np.uint8]) -> Seen:
    """Prepare pictures as the published script does: blurred, subtracted, cut off, scaled."""
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
    return Seen(darkness, depth_mm, masks)


class Model:
    """A perceptron that sees each pixel's neighbours, as the paper's network does.

    Parameters
    ----------
    wide
        Let it see where the pixel is, and the mean darkness farther around, which the paper's
        network cannot.
    """

    def __init__(self, seed: int, epochs: int, *, wide: bool = False) -> None:
        self._wide = wide
        self._network = _learn.Network((64, 32), seed=seed, epochs=epochs, batch=500)

    def fit(self, seen: Seen, pixels: int, random: np.random.Generator) -> Model:
        """Learn from so many pixels of each press, drawn from those with an input."""
        self._network.fit(*self._drawn(seen, pixels, random))
        return self

    def go_on(self, seen: Seen, pixels: int, epochs: int, random: np.random.Generator) -> None:
        """Learn on from another unit's presses."""
        self._network.go_on(*self._drawn(seen, pixels, random), epochs)

    def predict(self, seen: Seen) -> Maps:
        """Depth, mm: p x h x w; 0 without an input."""
        depth_mm = np.zeros_like(seen.depth_mm)
        where = seen.masks["loss"]
        if where.any():
            found = self._network.predict(self._features(seen, where))
            depth_mm[where] = np.clip(found, 0.0, DEEPEST_MM)
        return depth_mm

    def written(self) -> Written:
        """Write it as ONNX, one pixel a row."""
        return self._network.written(within=(0.0, DEEPEST_MM))

    def card(self, train: Seen, pixels: int, held_out: list[HeldOut]) -> Card:
        """Say what it is; ``pixels`` of each press were drawn at most."""
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
        self, seen: Seen, pixels: int, random: np.random.Generator
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        kept = np.zeros(seen.darkness.shape, dtype=bool)
        for mask, into in zip(seen.masks["loss"], kept, strict=True):
            places = np.flatnonzero(mask)
            if len(places):
                some = random.choice(places, size=min(pixels, len(places)), replace=False)
                into.ravel()[some] = True
        return self._features(seen, kept), np.minimum(seen.depth_mm[kept], DEEPEST_MM)

    def _features(self, seen: Seen, where: NDArray[np.bool_]) -> NDArray[Any]:
        _, height, width = seen.darkness.shape
        listed = [neighbourhoods(seen.darkness, _side(width))[where]]
        if self._wide:
            _, row, column = np.nonzero(where)
            listed.append(np.column_stack([column / width - 0.5, row / height - 0.5]))
            for part in _AROUND:
                listed.append(blurred(seen.darkness, part * width)[where][:, None])
        return np.concatenate(listed, axis=1).astype(np.float64)


def _side(width_px: int) -> int:
    """Side of the square that a pixel is told from."""
    return max(3, 2 * round((_FIELD_PX * width_px / _WIDTH_PX - 1) / 2) + 1)


@dataclass(frozen=True)
class Score:
    """Of one way to find depth, over one mask."""

    mean_mm: float
    """Mean of absolute errors, mm."""
    near: float
    """Share of errors below 0.1 mm, percent."""


def score(found_mm: Maps, seen: Seen, mask: str) -> Score:
    """Compare with the truth over a mask."""
    where = seen.masks[mask] & np.isfinite(found_mm)
    errors = np.abs(found_mm[where] - seen.depth_mm[where]).astype(np.float64)
    if not len(errors):
        return Score(float("nan"), float("nan"))
    return Score(float(errors.mean()), float(100.0 * (errors < 0.1).mean()))


def saturated(seen: Seen, reference: NDArray[np.uint8]) -> float:
    """Tell the share of the pixels in contact that say no more of depth.

    They are darker by more than what the published script lets its network see, or so bright at
    rest that the chip could not say more.
    """
    is_over = (seen.darkness >= 1.0) | (grey(reference[None]) >= _WHITE_GREY)
    where = seen.masks["contact"]
    return float(is_over[where].mean()) if where.any() else float("nan")


def held_out(found_mm: Maps, seen: Seen, of: str) -> list[HeldOut]:
    """Say for a card how far depth is off over each mask."""
    return [
        HeldOut(
            f"{of}, {words}: mean error", score(found_mm, seen, mask).mean_mm, "mm", len(found_mm)
        )
        for mask, words in MASKS.items()
    ]


def guess(train: Seen, mask: str) -> float:
    """Find the depth that is the best guess without a picture: the median over a mask, mm."""
    depths = train.depth_mm[train.masks[mask]]
    return float(np.median(depths)) if len(depths) else 0.0
