"""The small models: the only place that knows scikit-learn, which has no types.

All of them are seeded and run on one thread, so that figures do not depend on the machine's cores.
"""

from __future__ import annotations

import contextlib
import importlib
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit.errors import invalid
from fabkit_bench._onnx import Dense, Graph, Written, perceptron

if TYPE_CHECKING:
    from collections.abc import Generator

    from numpy.typing import NDArray

    from fabkit_bench._likeness import Code

    Array = NDArray[np.floating[Any]]

__all__ = ["Components", "Network", "Process", "Ridge", "needed", "one_thread"]


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        hint = "pip install fabkit-cad[bench]"
        raise invalid("benches need scikit-learn, which is not installed", hint) from error


def needed() -> None:
    """Say at once if scikit-learn is missing."""
    _module("sklearn")


@contextlib.contextmanager
def one_thread() -> Generator[None]:
    """Let linear algebra use one thread: sums in another order differ in their last digits."""
    try:
        limits: Any = importlib.import_module("threadpoolctl").threadpool_limits
    except ImportError:
        # It comes with scikit-learn, without which nothing is learned.
        yield
        return
    with limits(1):
        yield


class Network:
    """A perceptron with hidden layers, ReLU between them, on standardised numbers."""

    def __init__(
        self,
        hidden: tuple[int, ...],
        *,
        seed: int,
        epochs: int,
        rate: float = 1e-3,
        batch: int = 200,
    ) -> None:
        self._model = _module("sklearn.neural_network").MLPRegressor(
            hidden_layer_sizes=hidden,
            batch_size=batch,
            learning_rate_init=rate,
            max_iter=epochs,
            n_iter_no_change=epochs,
            random_state=seed,
        )

    def fit(self, features: Array, targets: Array) -> Network:
        """Learn: features (n, f), targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._to_middle, self._to_spread = _scale(targets)
        with warnings.catch_warnings():
            # It always ends by its number of epochs.
            warnings.simplefilter("ignore")
            self._model.fit(self._in(features), self._out(targets))
        return self

    def go_on(self, features: Array, targets: Array, epochs: int) -> None:
        """Learn on from other samples, with the scales of the first ones."""
        with warnings.catch_warnings():
            # A batch may be larger than all that there is.
            warnings.simplefilter("ignore")
            for _ in range(epochs):
                self._model.partial_fit(self._in(features), self._out(targets))

    def predict(self, features: Array) -> Array:
        """Answer (n,) or (n, t)."""
        return self._model.predict(self._in(features)) * self._to_spread + self._to_middle

    def layers(self, of: Components | None = None) -> list[Dense]:
        """List its layers so that raw numbers go in and come out."""
        sums = zip(self._model.coefs_, self._model.intercepts_, strict=True)
        layers = [Dense(weights, bias) for weights, bias in sums]
        layers[0] = _standardising(layers[0], self._middle, self._spread)
        if of is not None:
            layers[0] = of.before(layers[0])
        last, spread, middle = layers[-1], self._to_spread, self._to_middle
        layers[-1] = Dense(last.weights * spread, last.bias * spread + middle)
        return layers

    def written(
        self, *, of: Components | None = None, within: tuple[float, float] | None = None
    ) -> Written:
        """Write it as ONNX, of raw numbers: n x f to n x t.

        Parameters
        ----------
        of
            What it learned from are these components of what is then given.
        within
            Cut off what comes out.
        """
        model = self._model
        learned = (
            f"squared error, Adam at first {model.learning_rate_init:g}, {model.max_iter} epochs, "
            f"batches of {model.batch_size}"
        )
        return perceptron(self.layers(of), learned=learned, within=within)

    def _in(self, features: Array) -> Array:
        return (features - self._middle) / self._spread

    def _out(self, targets: Array) -> Array:
        return (targets - self._to_middle) / self._to_spread


class Ridge:
    """Least squares with a penalty, chosen among some by leaving out one sample after the other."""

    def __init__(self, penalties: tuple[float, ...] = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0)) -> None:
        self._model = _module("sklearn.linear_model").RidgeCV(alphas=penalties)

    def fit(self, features: Array, targets: Array) -> Ridge:
        """Learn: features (n, f), targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Answer (n,) or (n, t)."""
        return self._model.predict((features - self._middle) / self._spread)

    def layers(self, into: Code | None = None) -> list[Dense]:
        """List its one layer so that raw numbers go in."""
        weights = np.transpose(np.atleast_2d(self._model.coef_))
        layer = Dense(weights, np.atleast_1d(self._model.intercept_))
        layer = _standardising(layer, self._middle, self._spread)
        return [layer if into is None else into.after(layer)]

    def written(
        self, *, into: Code | None = None, within: tuple[float, float] | None = None
    ) -> Written:
        """Write it as ONNX, of raw numbers: n x f to n x t.

        Parameters
        ----------
        into
            What it gives are numbers of this code, of which pictures are then made.
        within
            Cut off what comes out.
        """
        learned = f"ridge, penalty {self._model.alpha_:g} by leaving one sample out"
        return perceptron(self.layers(into), learned=learned, within=within)


class Components:
    """The directions in which samples differ most."""

    def __init__(self, count: int) -> None:
        self._count = count

    def fit(self, samples: Array) -> Components:
        """Learn from (n, f)."""
        self._middle = samples.mean(axis=0)
        _, _, directions = np.linalg.svd(samples - self._middle, full_matrices=False)
        self._directions = directions[: self._count]
        return self

    def __call__(self, samples: Array) -> Array:
        """Tell how far samples (n, f) lie along them: (n, count)."""
        found: Array = np.einsum("nf,cf->nc", samples - self._middle, self._directions)
        return found

    def before(self, layer: Dense) -> Dense:
        """Let a layer of components take the samples themselves."""
        weights: Array = np.transpose(self._directions) @ layer.weights
        return Dense(weights, layer.bias - self._middle @ weights)


class Process:
    """A Gaussian process of one number, with noise, its lengths fitted."""

    def __init__(self, seed: int) -> None:
        kernels = _module("sklearn.gaussian_process.kernels")
        kernel = kernels.ConstantKernel() * kernels.RBF() + kernels.WhiteKernel()
        self._model = _module("sklearn.gaussian_process").GaussianProcessRegressor(
            kernel, normalize_y=True, random_state=seed
        )

    def fit(self, features: Array, targets: Array) -> Process:
        """Learn: features (n, f), targets (n,)."""
        self._middle, self._spread = _scale(features)
        with warnings.catch_warnings():
            # A length at its bound is an answer too.
            warnings.simplefilter("ignore")
            self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Answer (n,)."""
        return self._model.predict((features - self._middle) / self._spread)

    def written(self) -> Written:
        """Write its mean as ONNX, of raw numbers: n x f to n x 1.

        In float64, as it is evaluated here: weights of both signs may nearly cancel.
        """
        model, graph = self._model, Graph("process")
        kernel = model.kernel_.k1
        length = self._spread * kernel.k2.length_scale
        near = model.X_train_ / kernel.k2.length_scale
        alone = graph.constant(np.array([1], np.int64))
        scaled = graph.node("Sub", "x", graph.constant(self._middle))
        scaled = graph.node("Div", scaled, graph.constant(length))
        # n x 1 x f less m x f.
        apart = graph.node("Unsqueeze", scaled, alone)
        apart = graph.node("Sub", apart, graph.constant(near))
        apart = graph.node("Mul", apart, apart)
        apart = graph.node("ReduceSum", apart, graph.constant(np.array([2], np.int64)), keepdims=0)
        alike = graph.node("Exp", graph.node("Mul", apart, graph.constant(np.array(-0.5))))
        weights = kernel.k1.constant_value * model._y_train_std * model.alpha_.reshape(-1, 1)
        found = graph.node("MatMul", alike, graph.constant(weights))
        middle = np.atleast_1d(model._y_train_mean).astype(float)
        graph.node("Add", found, graph.constant(middle), out="y")
        takes, gives = ("n", near.shape[1]), ("n", 1)
        form = f"Gaussian process of {len(near)} samples: its mean, with a squared exponential"
        learned = "likeliest constant, length and noise, from their defaults"
        written = graph.model(takes, gives, "float64")
        return Written(written, "float64", takes, gives, form, learned)


def _standardising(layer: Dense, middle: Array, spread: Array) -> Dense:
    """Let a layer of standardised numbers take raw ones."""
    weights = layer.weights / spread[:, None]
    return Dense(weights, layer.bias - middle @ weights)


def _scale(values: Array) -> tuple[Array, Array]:
    """Mean and standard deviation of each column; 1 where nothing varies."""
    spread = values.std(axis=0)
    return values.mean(axis=0), np.where(spread > 1e-12, spread, 1.0)
