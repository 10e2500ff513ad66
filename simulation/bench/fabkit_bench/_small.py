"""Networks that tell depth from a pixel's neighbours, trained with numpy alone.

A convolution, another one (of each channel for itself, which is cheap, or of all), and a perceptron
at each pixel: the form of R-Tac0's published network. Learning looks at single pixels with the
square around them: the same as looking at whole pictures, but at their borders, and less to compute
where few pixels are touched.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit_bench._onnx import Convolution, Relu, chain

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[Any]

__all__ = ["PAPER", "SMALL", "Form", "Small"]

# Errors below that count by their square, in units of what the network gives as 1.
_SQUARE_BELOW = 0.02


RATE = 5e-3
"""How fast networks learn at first."""


@dataclass(frozen=True)
class Form:
    """Sizes of a network."""

    first: tuple[int, int]
    """Channels and side of the first convolution's window, px."""
    second: tuple[int, int]
    """The same of the second one."""
    hidden: tuple[int, ...]
    """Channels of the perceptron between its first and its last layer."""
    is_separable: bool
    """Whether each channel of the second convolution sees its own one alone."""

    @property
    def side_px(self) -> int:
        """Side of the square that a pixel is told from."""
        return self.first[1] + self.second[1] - 1


SMALL = Form((16, 7), (16, 7), (32, 16), is_separable=True)
PAPER = Form((64, 7), (128, 7), (64,), is_separable=False)


class Small:
    """Such a network with its numbers."""

    def __init__(self, form: Form, seed: int) -> None:
        self.form = form
        self._random = np.random.default_rng(seed)
        (c1, k1), (c2, k2) = form.first, form.second
        sizes = [c2, *form.hidden, 1]
        second = (k2 * k2, c1) if form.is_separable else (k2 * k2 * c1, c2)
        shapes = [(k1 * k1, c1), second, *pairwise(sizes)]
        ins = [k1 * k1, k2 * k2 if form.is_separable else k2 * k2 * c1, *sizes[:-1]]
        self.weights: list[Array] = [
            (self._random.standard_normal(shape) * np.sqrt(2 / n)).astype(np.float32)
            for shape, n in zip(shapes, ins, strict=True)
        ]
        outs = [c1, c2, *sizes[1:]]
        self.biases: list[Array] = [np.zeros(n, np.float32) for n in outs]

    def predict(self, squares: Array) -> Array:
        """Answer (n,) for squares (n, side, side)."""
        return self._forward(squares)[-1][:, 0]

    def _forward(self, squares: Array) -> list[Array]:
        """List what each layer is given, and at the end what comes out."""
        (c1, k1), (_, k2) = self.form.first, self.form.second
        windows: NDArray[Any] = np.lib.stride_tricks.sliding_window_view(
            squares, (k1, k1), axis=(1, 2)
        )
        given: list[Array] = [np.ascontiguousarray(windows).reshape(-1, k1 * k1)]
        after: Array = np.maximum(given[0] @ self.weights[0] + self.biases[0], 0)
        if self.form.is_separable:
            given.append(after.reshape(-1, k2 * k2, c1))
            after = np.einsum("npc,pc->nc", given[-1], self.weights[1]) + self.biases[1]
        else:
            given.append(after.reshape(-1, k2 * k2 * c1))
            after = np.maximum(given[-1] @ self.weights[1] + self.biases[1], 0)
        for weights, bias in zip(self.weights[2:-1], self.biases[2:-1], strict=True):
            given.append(after)
            after = np.maximum(after @ weights + bias, 0)
        given.append(after)
        given.append(after @ self.weights[-1] + self.biases[-1])
        return given

    def loss(self, squares: Array, targets: Array) -> tuple[float, list[Array], list[Array]]:
        """Tell the mean of errors, and its derivatives by weights and biases."""
        given = self._forward(squares)
        error = given[-1][:, 0] - targets
        size = np.abs(error)
        is_small = size < _SQUARE_BELOW
        losses = np.where(is_small, error**2 / (2 * _SQUARE_BELOW), size - _SQUARE_BELOW / 2)
        slope: Array = np.clip(error / _SQUARE_BELOW, -1, 1)[:, None] / np.float32(len(error))
        by_weights: list[Array] = list(self.weights)
        by_biases: list[Array] = list(self.weights)
        for i in range(len(self.weights) - 1, -1, -1):
            by_biases[i] = slope.sum(axis=0)
            if i == 1 and self.form.is_separable:
                by_weights[i] = np.einsum("npc,nc->pc", given[i], slope)
                slope = slope[:, None, :] * self.weights[i]
            else:
                by_weights[i] = np.transpose(given[i]) @ slope
                slope = slope @ np.transpose(self.weights[i]) if i else slope
            # What a layer is given went through a Relu, but for what a separable one gives.
            if i > (2 if self.form.is_separable else 0) or i == 1:
                slope = slope * (given[i] > 0)
            if i == 1:
                slope = np.reshape(slope, (-1, self.form.first[0]))
        return float(losses.mean()), by_weights, by_biases

    def fit(
        self,
        squares: NDArray[Any],
        targets: Array,
        *,
        epochs: int,
        batch: int = 512,
        rate: float = RATE,
        tell: Callable[[str], None] | None = None,
    ) -> None:
        """Learn by Adam, with steps that shrink; squares (n, side, side), targets (n,)."""
        parameters = [*self.weights, *self.biases]
        means = [np.zeros_like(one) for one in parameters]
        squared = [np.zeros_like(one) for one in parameters]
        steps, step = epochs * (len(targets) // batch), 0
        for epoch in range(epochs):
            order = self._random.permutation(len(targets))
            losses: list[float] = []
            for start in range(0, len(order) - batch + 1, batch):
                some = np.sort(order[start : start + batch])
                loss, *slopes = self.loss(squares[some].astype(np.float32), targets[some])
                losses.append(loss)
                now = rate * 0.5 * (1 + np.cos(np.pi * step / steps))
                step += 1
                scale = now * np.sqrt(1 - 0.999**step) / (1 - 0.9**step)
                every = zip(parameters, means, squared, [*slopes[0], *slopes[1]], strict=True)
                for one, mean, square, slope in every:
                    mean += 0.1 * (slope - mean)
                    square += 0.001 * (slope**2 - square)
                    one -= (scale * mean / (np.sqrt(square) + 1e-8)).astype(np.float32)
            if tell is not None:
                tell(f"  epoch {epoch + 1} of {epochs}: {np.mean(losses):.4f}")

    def onnx(self) -> bytes:
        """Write it as ONNX; what comes out is no less than 0."""
        (c1, k1), (c2, k2) = self.form.first, self.form.second
        first: Array = np.reshape(np.transpose(self.weights[0]), (c1, 1, k1, k1))
        layers: list[Convolution | Relu] = [Convolution(first, self.biases[0]), Relu()]
        if self.form.is_separable:
            second: Array = np.reshape(np.transpose(self.weights[1]), (c1, 1, k2, k2))
            layers.append(Convolution(second, self.biases[1], groups=c1))
        else:
            second = np.transpose(np.reshape(self.weights[1], (k2, k2, c1, c2)), (3, 2, 0, 1))
            layers += [Convolution(second, self.biases[1]), Relu()]
        for weights, bias in zip(self.weights[2:], self.biases[2:], strict=True):
            layers += [Convolution(np.transpose(weights)[:, :, None, None], bias), Relu()]
        return chain(layers)
