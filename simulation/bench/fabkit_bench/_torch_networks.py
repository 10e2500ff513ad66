"""The papers' networks, in PyTorch; no other module imports it.

All networks are seeded and trained on one CPU thread, so that figures are reproducible.
"""

from __future__ import annotations

import contextlib
import importlib
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit.errors import invalid
from fabkit_bench._layers import layer
from fabkit_bench._onnx import Graph, OnnxNetwork

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from numpy.typing import NDArray

    Array = NDArray[np.floating[Any]]
    Numbers = NDArray[np.float64]

__all__ = ["Autoencoder", "Network", "recurrent", "require", "resnet_18"]

# Samples in one forward pass of a prediction: limits memory.
_AT_ONCE = 64


def require() -> Any:
    """Import and return PyTorch; raise if it is missing."""
    try:
        return importlib.import_module("torch")
    except ImportError as error:
        hint = "pip install fabkit-cad[torch]"
        raise invalid("papers' networks need PyTorch, which is not installed", hint) from error


@contextlib.contextmanager
def _repeatable(seed: int) -> Generator[Any]:
    """Make PyTorch deterministic: a seed, one thread; restore its settings afterwards."""
    torch = require()
    threads, strict = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        torch.set_num_threads(1)
        torch.use_deterministic_algorithms(True)
        try:
            yield torch
        finally:
            torch.set_num_threads(threads)
            torch.use_deterministic_algorithms(strict)


class Network:
    """A regression network with standardised inputs and targets.

    Parameters
    ----------
    form
        Creates the module with random initial weights.
    seed
        Seed of initial weights and of the order of samples.
    epochs
        Number of epochs.
    rate
        Learning rate of Adam.
    batch
        Samples in a batch.
    loss
        Name of a loss of ``torch.nn``, such as ``"L1Loss"``.
    """

    def __init__(
        self,
        form: Callable[[], Any],
        *,
        seed: int,
        epochs: int,
        rate: float,
        batch: int,
        loss: str = "MSELoss",
    ) -> None:
        self._seed, self._epochs, self._rate, self._batch = seed, epochs, rate, batch
        self._loss = loss
        with _repeatable(seed):
            self._form = form()

    def fit(self, samples: Array, targets: Array) -> Network:
        """Train on samples (n, ...) and targets (n, t)."""
        self._shape, self._count = samples.shape[1:], targets.shape[1]
        self._middle, self._spread = _scale(samples.reshape(-1, samples.shape[-1]), whole=True)
        self._to_middle, self._to_spread = _scale(targets)
        with _repeatable(self._seed) as torch:
            given = torch.from_numpy(self._in(samples))
            wanted = torch.from_numpy(
                ((targets - self._to_middle) / self._to_spread).astype(np.float32)
            )
            _train(
                torch,
                self._form,
                given,
                wanted,
                self._epochs,
                self._rate,
                self._batch,
                getattr(torch.nn, self._loss)(),
            )
        return self

    def predict(self, samples: Array) -> Numbers:
        """Predict targets (n, t)."""
        with _repeatable(self._seed) as torch:
            found = _answered(torch, self._form, self._in(samples))
        return found * self._to_spread + self._to_middle

    def to_onnx(self, form: str) -> OnnxNetwork:
        """Write the network as ONNX with raw inputs and outputs; ``form`` describes it in words."""
        graph = Graph("network")

        def constant(values: Any) -> str:
            return graph.constant(np.asarray(values, np.float32))

        # Not folded into the first layer: zero padding of convolutions has to mean the mean.
        given = graph.node("Sub", "x", constant(self._middle))
        given = graph.node("Div", given, constant(self._spread))
        found = layer(graph, self._form, given)
        found = graph.node("Mul", found, constant(self._to_spread))
        graph.node("Add", found, constant(self._to_middle), out="y")
        loss = {"L1Loss": "absolute error", "MSELoss": "squared error"}[self._loss]
        learned = (
            f"{loss} of standardised numbers, Adam {self._rate:g}, {self._epochs} epochs, batches "
            f"of {self._batch}"
        )
        takes, gives = ("n", *self._shape), ("n", self._count)
        return OnnxNetwork(graph.model(takes, gives), "float32", takes, gives, form, learned)

    def _in(self, samples: Array) -> NDArray[np.float32]:
        return ((samples - self._middle) / self._spread).astype(np.float32)


def _train(
    torch: Any,
    form: Any,
    given: Any,
    wanted: Any,
    epochs: int,
    rate: float,
    batch: int,
    loss: Any,
) -> None:
    """Train a module with Adam."""
    steps = torch.optim.Adam(form.parameters(), lr=rate)
    form.train()
    for _ in range(epochs):
        order = torch.randperm(len(given))
        for some in order.split(batch):
            if len(some) < 2:
                # Batch normalisation needs at least two samples.
                continue
            steps.zero_grad()
            loss(form(given[some]), wanted[some]).backward()
            steps.step()
    form.eval()


def _answered(torch: Any, form: Any, samples: NDArray[np.float32]) -> Numbers:
    form.eval()
    with torch.no_grad():
        parts = [form(part).numpy() for part in torch.from_numpy(samples).split(_AT_ONCE)]
    return np.concatenate(parts).astype(np.float64)


def _scale(values: Array, *, whole: bool = False) -> tuple[Any, Any]:
    """Compute mean and standard deviation of each column, or of all values if ``whole``.

    The standard deviation is 1 where values are constant.
    """
    axis = None if whole else 0
    spread = values.std(axis=axis)
    return values.mean(axis=axis), np.where(spread > 1e-12, spread, 1.0)


def resnet_18(outputs: int) -> Any:
    """Create a ResNet-18 for images with one channel, (n, 1, h, w): He et al., CVPR 2016."""
    nn = require().nn

    class Block(nn.Module):
        """A residual block: two convolutions and a skip connection."""

        def __init__(self, before: int, after: int, stride: int) -> None:
            super().__init__()
            self.ahead = nn.Sequential(
                nn.Conv2d(before, after, 3, stride, 1, bias=False),
                nn.BatchNorm2d(after),
                nn.ReLU(),
                nn.Conv2d(after, after, 3, 1, 1, bias=False),
                nn.BatchNorm2d(after),
            )
            self.around = (
                nn.Identity()
                if before == after
                else nn.Sequential(
                    nn.Conv2d(before, after, 1, stride, bias=False), nn.BatchNorm2d(after)
                )
            )

        def forward(self, given: Any) -> Any:
            return nn.functional.relu(self.ahead(given) + self.around(given))

    layers: list[Any] = [
        nn.Conv2d(1, 64, 7, 2, 3, bias=False),
        nn.BatchNorm2d(64),
        nn.ReLU(),
        nn.MaxPool2d(3, 2, 1),
    ]
    before = 64
    for after in (64, 128, 256, 512):
        layers += [Block(before, after, 1 if before == after else 2), Block(after, after, 1)]
        before = after
    return nn.Sequential(*layers, nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Linear(512, outputs))


def recurrent(inputs: int, outputs: int, *, layers: int = 3, width: int = 256) -> Any:
    """Create an LSTM for series (n, steps, inputs) that predicts from the last step."""
    nn = require().nn

    class Last(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.steps = nn.LSTM(inputs, width, layers, batch_first=True)
            self.out = nn.Linear(width, outputs)

        def forward(self, given: Any) -> Any:
            return self.out(self.steps(given)[0][:, -1])

    return Last()


class Autoencoder:
    """The convolutional autoencoder of Soter et al.: 68 x 68 images as 9 x 9 x 4 = 324 numbers.

    The decoder is as published. Of the encoder only the output size is published; here it mirrors
    the decoder.
    """

    def __init__(
        self, pictures: Array, *, seed: int, epochs: int, rate: float = 1e-3, batch: int = 50
    ) -> None:
        self._seed = seed
        self._learned = (
            f"binary cross entropy of pictures, Adam {rate:g}, {epochs} epochs, batches of {batch}"
        )
        with _repeatable(seed) as torch:
            nn = torch.nn
            self._encoder = nn.Sequential(
                nn.Conv2d(1, 16, 3, padding=1),
                nn.ReLU(),
                nn.MaxPool2d(2),
                nn.Conv2d(16, 8, 3, padding=1),
                nn.ReLU(),
                nn.MaxPool2d(2),
                nn.Conv2d(8, 4, 3, padding=1),
                nn.ReLU(),
                # 17 to 9 pixels: `ceil_mode` keeps the last column and row.
                nn.MaxPool2d(2, ceil_mode=True),
                nn.Flatten(),
            )
            self._decoder = nn.Sequential(
                nn.Unflatten(1, (4, 9, 9)),
                nn.Conv2d(4, 4, 3, padding=1),
                nn.ReLU(),
                nn.Upsample(scale_factor=2),
                nn.Conv2d(4, 8, 3, padding=1),
                nn.ReLU(),
                nn.Upsample(scale_factor=2),
                nn.Conv2d(8, 16, 3),
                nn.ReLU(),
                nn.Upsample(scale_factor=2),
                nn.Conv2d(16, 1, 3, padding=1),
                nn.Sigmoid(),
            )
            both = nn.Sequential(self._encoder, self._decoder)
            given = torch.from_numpy(_one_channel(pictures))
            _train(torch, both, given, given, epochs, rate, batch, nn.BCELoss())

    def encode(self, pictures: Array) -> Numbers:
        """Encode images (n, 68, 68) as numbers, n x 324."""
        with _repeatable(self._seed) as torch:
            return _answered(torch, self._encoder, _one_channel(pictures))

    def decode(self, numbers: Array) -> Numbers:
        """Decode numbers (n, 324) to images from 0 to 1, n x 68 x 68."""
        with _repeatable(self._seed) as torch:
            return _answered(torch, self._decoder, numbers.astype(np.float32))[:, 0]

    def to_onnx(self) -> tuple[OnnxNetwork, OnnxNetwork]:
        """Write the encoder and the decoder as ONNX."""
        sizes, pictures = ("n", 324), ("n", 1, 68, 68)
        halves = (
            (self._encoder, pictures, sizes, "encoder: mirror image of the published decoder"),
            (self._decoder, sizes, pictures, "decoder as published"),
        )
        found: list[OnnxNetwork] = []
        for half, takes, gives, form in halves:
            graph = Graph("code")
            graph.node("Identity", layer(graph, half, "x"), out="y")
            onnx = graph.model(takes, gives)
            found.append(OnnxNetwork(onnx, "float32", takes, gives, form, self._learned))
        return found[0], found[1]


def _one_channel(pictures: Array) -> NDArray[np.float32]:
    return pictures[:, None].astype(np.float32)
