"""Image processing with numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["blurred", "grey", "neighbourhoods", "shrunk"]


def grey(images: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Average the colour channels of (n, h, w) or (n, h, w, 3), 0 to 255: (n, h, w)."""
    values = images.astype(np.float32)
    return values.mean(axis=3) if values.ndim == 4 else values


def blurred(images: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    """Blur images (n, h, w) by a Gaussian; edge pixels are repeated."""
    if sigma_px <= 0:
        return images
    reach = max(1, round(3 * sigma_px))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma_px) ** 2)
    weights = (weights / weights.sum()).astype(np.float32)
    for axis in (1, 2):
        pad = [(reach, reach) if k == axis else (0, 0) for k in range(3)]
        wide = np.pad(images, pad, mode="edge")
        length = images.shape[axis]
        images = sum(
            weight * np.take(wide, range(k, k + length), axis=axis)
            for k, weight in enumerate(weights)
        )  # pyright: ignore[reportAssignmentType]
    return images


def neighbourhoods(images: NDArray[np.float32], side_px: int) -> NDArray[np.float32]:
    """Collect each pixel's square neighbourhood: (n, h, w, side * side), zero outside images."""
    reach = side_px // 2
    wide = np.pad(images, [(0, 0), (reach, reach), (reach, reach)])
    windows: NDArray[Any] = np.lib.stride_tricks.sliding_window_view(
        wide, (side_px, side_px), axis=(1, 2)
    )
    return windows.reshape(*images.shape, side_px * side_px)


def shrunk(images: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Shrink images by averaging squares of pixels: (n, h // factor, w // factor)."""
    count, height, width = images.shape
    height, width = height // factor, width // factor
    cut = images[:, : height * factor, : width * factor]
    return cut.reshape(count, height, factor, width, factor).mean(axis=(2, 4))
