"""Pictures of markers, what is left of them in a few numbers, and how alike two pictures are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit_bench._onnx import Dense

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Pictures = NDArray[np.float64]

__all__ = ["Code", "drawn", "likeness"]

# Wang et al., Image quality assessment, IEEE TIP 13 (2004): for values from 0 to 1.
_C1, _C2 = 0.01**2, 0.03**2
_WINDOW_PX = 7


def drawn(places_px: NDArray[np.float64], radius_px: float, side_px: int) -> Pictures:
    """Draw white discs on black, (n, m, 2) columns and rows: n x side x side, from 0 to 1."""
    row, column = np.mgrid[:side_px, :side_px] + 0.5
    pictures: Pictures = np.zeros((len(places_px), side_px, side_px))
    for picture, places in zip(pictures, places_px, strict=True):
        for x, y in places:
            inside = radius_px + 0.5 - np.hypot(column - x, row - y)
            np.maximum(picture, np.clip(inside, 0, 1), out=picture)
    return pictures


class Code:
    """The best linear code of so many numbers a picture (principal components)."""

    def __init__(self, pictures: Pictures, length: int) -> None:
        flat = pictures.reshape(len(pictures), -1)
        self.shape = pictures.shape[1:]
        self.mean: NDArray[np.float64] = flat.mean(axis=0)
        _, _, ways = np.linalg.svd(flat - self.mean, full_matrices=False)
        self._ways: NDArray[np.float64] = ways[:length]

    def encode(self, pictures: Pictures) -> NDArray[np.float64]:
        """Tell the numbers of pictures: n x length."""
        return np.asarray(
            (pictures.reshape(len(pictures), -1) - self.mean) @ np.transpose(self._ways)
        )

    def decode(self, numbers: NDArray[np.floating[Any]]) -> Pictures:
        """Make pictures of numbers again, from 0 to 1."""
        flat: NDArray[np.float64] = np.clip(numbers @ self._ways + self.mean, 0, 1)
        return flat.reshape(len(numbers), *self.shape)

    def after(self, layer: Dense) -> Dense:
        """Let a layer that gives numbers give pictures, row by row, that are not cut off yet."""
        return Dense(layer.weights @ self._ways, layer.bias @ self._ways + self.mean)


def likeness(one: Pictures, other: Pictures) -> NDArray[np.float64]:
    """Tell the structural similarity (SSIM) of pairs of pictures from 0 to 1: n, 1 where alike."""
    mean_1, mean_2, mean_11, mean_22, mean_12 = (
        _around(values) for values in (one, other, one * one, other * other, one * other)
    )
    # Of a sample, as the usual implementations have it.
    count = _WINDOW_PX**2 / (_WINDOW_PX**2 - 1)
    var_1, var_2 = count * (mean_11 - mean_1**2), count * (mean_22 - mean_2**2)
    both = count * (mean_12 - mean_1 * mean_2)
    light = (2 * mean_1 * mean_2 + _C1) / (mean_1**2 + mean_2**2 + _C1)
    form = (2 * both + _C2) / (var_1 + var_2 + _C2)
    return (light * form).mean(axis=(1, 2))


def _around(pictures: Pictures) -> Pictures:
    """Mean over the square around each pixel that has a whole one."""
    size = (_WINDOW_PX, _WINDOW_PX)
    windows: NDArray[np.float64] = np.lib.stride_tricks.sliding_window_view(
        pictures, size, axis=(1, 2)
    )
    return windows.mean(axis=(3, 4))
