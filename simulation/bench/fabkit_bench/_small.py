"""Networks that predict indentation from a pixel's neighbourhood, trained with numpy.

Their form is that of R-Tac0's published network: a convolution, a second one (separable by
channel, which is cheap, or full), and a perceptron at each pixel. Training uses single pixels with
the square around them. Apart from image borders that equals training on whole images, and it costs
less when the contact covers few pixels.
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

# Huber loss: smaller errors count by their square; in units of the network's output.
_SQUARE_BELOW = 0.02


RATE = 5e-3
"""Initial learning rate."""


@dataclass(frozen=True)
class Form:
    """Sizes of a network."""

    first: tuple[int, int]
    """Channels, and side of the window in px, of the first convolution."""
    second: tuple[int, int]
    """Channels, and side of the window in px, of the second convolution."""
    hidden: tuple[int, ...]
    """Widths of the perceptron's hidden layers."""
    is_separable: bool
    """True if each channel of the second convolution sees only its own input channel."""

    @property
    def side_px(self) -> int:
        """Side of the receptive field, px."""
        return self.first[1] + self.second[1] - 1


SMALL = Form((16, 7), (16, 7), (32, 16), is_separable=True)
PAPER = Form((64, 7), (128, 7), (64,), is_separable=False)


class Small:
    """A network with its weights."""

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
        """Predict outputs (n,) for squares (n, side, side)."""
        return self._forward(squares)[-1][:, 0]

    def _forward(self, squares: Array) -> list[Array]:
        """Compute the input of each layer, and as the last item the output."""
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
        """Compute the mean Huber loss and its derivatives by weights and biases."""
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
            # A layer's input went through a ReLU, except the separable convolution's output.
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
        """Train with Adam and cosine decay on squares (n, side, side) and targets (n,)."""
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
                # Adam with its usual decay rates, 0.9 and 0.999, and bias correction.
                scale = now * np.sqrt(1 - 0.999**step) / (1 - 0.9**step)
                every = zip(parameters, means, squared, [*slopes[0], *slopes[1]], strict=True)
                for one, mean, square, slope in every:
                    mean += 0.1 * (slope - mean)
                    square += 0.001 * (slope**2 - square)
                    one -= (scale * mean / (np.sqrt(square) + 1e-8)).astype(np.float32)
            if tell is not None:
                tell(f"  epoch {epoch + 1} of {epochs}: {np.mean(losses):.4f}")

    def onnx(self) -> bytes:
        """Write the network as ONNX, with a last ReLU: the output is at least 0."""
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
