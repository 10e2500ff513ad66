"""Drawn images of markers, a linear code for images, and the similarity of two images (SSIM)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit_bench._onnx import Dense

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Pictures = NDArray[np.float64]

__all__ = ["Code", "draw_discs", "ssim"]

# Wang et al., Image quality assessment, IEEE TIP 13 (2004): for values from 0 to 1.
_C1, _C2 = 0.01**2, 0.03**2
_WINDOW_PX = 7


def draw_discs(places_px: NDArray[np.float64], radius_px: float, side_px: int) -> Pictures:
    """Draw white discs on black, centred at columns and rows (n, m, 2).

    Returns n x side x side, 0 to 1, with antialiased rims.
    """
    row, column = np.mgrid[:side_px, :side_px] + 0.5
    pictures: Pictures = np.zeros((len(places_px), side_px, side_px))
    for picture, places in zip(pictures, places_px, strict=True):
        for x, y in places:
            inside = radius_px + 0.5 - np.hypot(column - x, row - y)
            np.maximum(picture, np.clip(inside, 0, 1), out=picture)
    return pictures


class Code:
    """A linear code for images: the first ``length`` principal components."""

    def __init__(self, pictures: Pictures, length: int) -> None:
        flat = pictures.reshape(len(pictures), -1)
        self.shape = pictures.shape[1:]
        self.mean: NDArray[np.float64] = flat.mean(axis=0)
        _, _, ways = np.linalg.svd(flat - self.mean, full_matrices=False)
        self._ways: NDArray[np.float64] = ways[:length]

    def encode(self, pictures: Pictures) -> NDArray[np.float64]:
        """Encode images as numbers, n x length."""
        return np.asarray(
            (pictures.reshape(len(pictures), -1) - self.mean) @ np.transpose(self._ways)
        )

    def decode(self, numbers: NDArray[np.floating[Any]]) -> Pictures:
        """Decode numbers to images, clipped to 0 to 1."""
        flat: NDArray[np.float64] = np.clip(numbers @ self._ways + self.mean, 0, 1)
        return flat.reshape(len(numbers), *self.shape)

    def after(self, layer: Dense) -> Dense:
        """Convert a layer that outputs numbers to one that outputs images, flattened, unclipped."""
        return Dense(layer.weights @ self._ways, layer.bias @ self._ways + self.mean)


def ssim(one: Pictures, other: Pictures) -> NDArray[np.float64]:
    """Compute the structural similarity (SSIM) of n pairs of images with values from 0 to 1.

    Returns (n,); 1 for equal images.
    """
    mean_1, mean_2, mean_11, mean_22, mean_12 = (
        _around(values) for values in (one, other, one * one, other * other, one * other)
    )
    # Variances of a sample (n - 1), as in the usual implementations.
    count = _WINDOW_PX**2 / (_WINDOW_PX**2 - 1)
    var_1, var_2 = count * (mean_11 - mean_1**2), count * (mean_22 - mean_2**2)
    both = count * (mean_12 - mean_1 * mean_2)
    light = (2 * mean_1 * mean_2 + _C1) / (mean_1**2 + mean_2**2 + _C1)
    form = (2 * both + _C2) / (var_1 + var_2 + _C2)
    return (light * form).mean(axis=(1, 2))


def _around(pictures: Pictures) -> Pictures:
    """Average the square window around each pixel whose window lies inside the image."""
    size = (_WINDOW_PX, _WINDOW_PX)
    windows: NDArray[np.float64] = np.lib.stride_tricks.sliding_window_view(
        pictures, size, axis=(1, 2)
    )
    return windows.mean(axis=(3, 4))
